"""Processes that execute commands one after the other, so that modules and kernels are loaded once for many short commands."""

import json
import os
import signal
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import IO, Any, cast

SIGTERM = 143
"""Exit status of a command that SIGTERM ended after a checkpoint."""
SHORT = 60.0
"""Longest command after which a process stays for the next one [s]. A start takes a few seconds, so a new process costs a
longer command little, and returns its memory."""


class CommandProcess:
    """Process that executes commands one after the other, each with its output in a log of its own.

    `is_reusable` is True if the process waits for another command. Ctrl-C in a terminal does not reach the process; it
    terminates when its standard input is closed, also by the end of this process: a running command then receives SIGTERM, so
    that a run writes a checkpoint first.
    """

    def __init__(self, program: str, log: Path) -> None:
        """Start the process. program: Python text that calls `execute_commands`; log: file for errors of the start."""
        with log.open("wb") as output:
            self._process = subprocess.Popen(
                [sys.executable, "-c", program],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=output,
                start_new_session=True,
            )
        self._orders, self._answers = cast(IO[bytes], self._process.stdin), cast(IO[bytes], self._process.stdout)
        self.is_reusable = False

    @property
    def is_alive(self) -> bool:
        """True if the process has not terminated."""
        return self._process.poll() is None

    def execute(self, arguments: Sequence[str], log: Path) -> int:
        """Execute a command and return its exit status, negative if a signal killed the process.

        arguments: arguments of the command; log: file that receives the output, in place of its former contents.
        """
        self.is_reusable = False
        try:
            self._orders.write(json.dumps([*map(str, arguments)]).encode() + b"\n")
            self._orders.write(os.fsencode(log) + b"\n")
            self._orders.flush()
        except (OSError, ValueError):  # it has just been terminated
            return self._process.wait()
        answer = self._answers.readline()
        if not answer:
            return self._process.wait()
        status, self.is_reusable = json.loads(answer)
        return int(status)

    def close(self) -> None:
        """Let the process terminate; see the class. Does not wait."""
        with suppress(OSError):  # it was killed with a command unread
            self._orders.close()

    def wait(self) -> None:
        """Wait until the process has terminated."""
        self._process.wait()
        self._answers.close()


def execute_commands(load: Callable[[], Callable[[], Any]], is_clean: Callable[[], bool]) -> None:
    """Execute the commands that the parent sends, until it closes the standard input of this process or ends.

    load: function that imports the program and returns its main function, which reads `sys.argv`. is_clean: returns True if
    the last command left nothing behind that could affect the next one. The process serves another command only after one
    that succeeded, was short and left nothing behind.
    """
    sys.stdout.flush()
    answers = os.dup(1)  # not inherited by processes that a command starts
    os.dup2(2, 1)
    received: SimpleQueue[bytes] = SimpleQueue()

    def listen() -> None:
        with os.fdopen(os.dup(0), "rb") as orders:
            while line := orders.readline():
                received.put(line)
        os.kill(os.getpid(), signal.SIGTERM)

    Thread(target=listen, daemon=True).start()
    main = load()
    stays = True
    while stays:
        sys.argv[:] = ["pellucid", *json.loads(received.get())]
        _direct_output(os.fsdecode(received.get().removesuffix(b"\n")))
        began = time.monotonic()
        status = _status(main)
        sys.stdout.flush()
        sys.stderr.flush()
        stays = status == 0 and time.monotonic() - began < SHORT and is_clean()
        os.write(answers, json.dumps([status, stays]).encode() + b"\n")


def _direct_output(log: str) -> None:
    """Write the output of this process and of its children to the file `log`."""
    file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
    os.dup2(file, 1)
    os.dup2(file, 2)
    os.close(file)


def _status(main: Callable[[], Any]) -> int:
    try:
        main()
    except SystemExit as error:
        if error.code is None or isinstance(error.code, int):
            return error.code or 0
        sys.stderr.write(f"{error.code}\n")
        return 1
    except BaseException:
        traceback.print_exc()
        return 1
    return 0
