import os
import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

import pytest

from pellucid.system.command_process import CommandProcess

PROGRAM = """
import os, signal, sys, time
from pellucid.system.command_process import execute_commands

def main():
    print("executing", *sys.argv[1:])
    if sys.argv[1] == "exit":
        sys.exit(int(sys.argv[2]) if sys.argv[2].isdigit() else sys.argv[2])
    if sys.argv[1] == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if sys.argv[1] == "fail":
        raise ValueError("wrong")
    if sys.argv[1] == "sleep":
        time.sleep(100)
    if sys.argv[1] == "child":
        os.system("echo from a child")

execute_commands(lambda: main, lambda: len(sys.argv) < 4)
"""


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return tmp_path / "log.txt"


def execute(process: CommandProcess, log: Path, *arguments: str) -> tuple[int, bool]:
    return process.execute(arguments, log), process.is_reusable


def test_each_command_has_its_own_log(tmp_path: Path) -> None:
    logs = [tmp_path / f"log {number} µ.txt" for number in range(3)]
    process = CommandProcess(PROGRAM, logs[0])
    assert execute(process, logs[0], "print", "a b") == (0, True)
    assert execute(process, logs[1], "exit", "0") == (0, True)
    assert execute(process, logs[2], "child", "") == (0, True)
    texts = [log.read_text().split() for log in logs]
    assert texts[0] == ["executing", "print", "a", "b"]
    assert texts[1] == ["executing", "exit", "0"]
    assert "from a child" in logs[2].read_text()
    process.close()
    process.wait()
    assert not process.is_alive


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["exit", "3"], 3, "executing exit 3"),
        (["exit", "in words"], 1, "in words"),
        (["fail"], 1, "ValueError: wrong"),
        (["kill"], -9, ""),
        (["print", "leaves something", "behind"], 0, "leaves something"),
    ],
)
def test_a_process_ends_after_a_failure_or_what_it_left_behind(
    log: Path, arguments: list[str], status: int, words: str
) -> None:
    process = CommandProcess(PROGRAM, log)
    assert execute(process, log, *arguments) == (status, False)
    process.wait()
    assert words in log.read_text()


def test_a_program_that_cannot_start_says_why(log: Path) -> None:
    process = CommandProcess("import no_such_module", log)
    assert execute(process, log, "print") == (1, False)
    assert "no_such_module" in log.read_text()
    process.close()


def test_a_closed_process_ends_its_command_by_sigterm(log: Path) -> None:
    process = CommandProcess(PROGRAM, log)
    ended: list[int] = []
    thread = Thread(target=lambda: ended.append(process.execute(["sleep"], log)))
    thread.start()
    time.sleep(0.3)
    process.close()
    thread.join(timeout=20)
    assert ended == [-15]


def test_a_process_ends_with_its_parent() -> None:
    """The parent is killed and closes nothing itself."""
    script = (
        "import sys, time\nfrom pathlib import Path\nfrom pellucid.system.command_process import CommandProcess\n"
        f"process = CommandProcess({PROGRAM!r}, Path(sys.argv[1]))\nprint(process._process.pid, flush=True)\n"
        "process.execute(['sleep'], Path(sys.argv[1]))"
    )
    parent = subprocess.Popen([sys.executable, "-c", script, os.devnull], stdout=subprocess.PIPE)
    assert parent.stdout
    child = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    until = time.monotonic() + 20
    while Path(f"/proc/{child}/cmdline").is_file() and Path(f"/proc/{child}/cmdline").read_bytes():
        assert time.monotonic() < until
        time.sleep(0.01)
