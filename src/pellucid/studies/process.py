"""Run a member of a study, i.e. one of its cases, in a separate process. If the worker that started it ends, the process
writes a checkpoint and ends."""

import subprocess
import sys
import time
from pathlib import Path
from threading import Event, Lock

from pellucid.errors import UsageError
from pellucid.results.storage import lock
from pellucid.results.storage.run_folder import RunFolder
from pellucid.studies.members import FAILED, INTERRUPTED, Outcome, outcome, places

BEGIN = """
from pellucid.system.processes import terminated_with_parent
terminated_with_parent()
from pellucid.cli import main
main()
"""
PAUSE = 0.2  # s between two looks at a folder in which another process writes
TAIL = 20  # lines of a log that hold the reason of a failure
BAD_ARGUMENT, SIGTERM = 2, 143

_running: set[subprocess.Popen] = set()
_changing = Lock()
_ending = Event()


def run_member(out: Path, digest: str, threads: int, until: float | None) -> Outcome:
    """Run a member of the study in the folder `out` in a separate process, from the start or from its last checkpoint, and
    return its outcome; a finished member is not run again.

    digest: identifies the member. until: time at which the run ends [s]; None: end of the case.
    """
    where = places(out, digest)
    while _is_held(where.run):  # by the process of a study that was killed just now, or by another study
        time.sleep(PAUSE)
    found = outcome(out, digest)
    if found is not None:
        return found
    options = ["--no-report", "--threads", f"{threads}", *(["--until", repr(until)] if until is not None else [])]
    anew = ["run", f"{where.case}", "--out", f"{where.run}", *options]
    begun = RunFolder(where.run).case.is_file()
    status = _call(["resume", f"{where.run}", *options] if begun else anew, where.log)
    if begun and status == BAD_ARGUMENT:  # it cannot go on: another version of the program began it
        status = _call(anew, where.log)
    return _ended(status, where.log) if status else outcome(out, digest) or Outcome(FAILED, "the run wrote no summary")


def allow_running() -> None:
    """Allow members to start again after `end_running`."""
    _ending.clear()


def end_running() -> None:
    """Make all members that this process runs write a checkpoint and stop, wait until they have stopped, and start no more
    members."""
    with _changing:
        _ending.set()
        running = list(_running)
        for process in running:
            if process.stdin is not None:
                process.stdin.close()
    for process in running:
        process.wait()


def _is_held(folder: Path) -> bool:
    try:
        lock.refuse_held(folder)
    except UsageError:
        return True
    return False


def _call(arguments: list[str], log: Path) -> int:
    """Run a `pellucid` command with these arguments in a separate process, with output to `log`; return its exit status."""
    command = [sys.executable, "-c", BEGIN, *arguments]
    with log.open("wb") as said:
        with _changing:
            if _ending.is_set():
                return SIGTERM
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=said, stderr=said, start_new_session=True)
            _running.add(process)
        try:
            return process.wait()
        finally:
            with _changing:
                _running.discard(process)
                if process.stdin is not None:
                    process.stdin.close()


def _ended(status: int, log: Path) -> Outcome:
    """Return the outcome of a process that ended with a status other than 0: interrupted, or failed with the error message at
    the end of its log."""
    if status == SIGTERM or status == -15:
        return Outcome(INTERRUPTED, "interrupted; run the same command again to continue from the checkpoint")
    if status < 0:
        return Outcome(FAILED, f"the process was killed by signal {-status}; see {log}")
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()[-TAIL:]
    starts = [number for number, line in enumerate(lines) if line.startswith("pellucid: ")]
    text = "\n".join(lines[starts[-1] :] if starts else lines[-1:]).removeprefix("pellucid: ")
    return Outcome(FAILED, text or f"exit status {status}; see {log}")
