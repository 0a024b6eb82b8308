"""Work shared with other processes."""

import os
import signal
import subprocess
import sys
import time

import pytest

from pellucid.system.processes import Helper, free_cores, helped, shared


def squarer():
    return square


def square(number):
    if number < 0:
        raise ValueError(f"{number} is negative")
    return number**2, os.getpid()


def sleeper():
    return time.sleep


def ended_by_itself():
    os._exit(1)


def done_by(helpers, jobs=range(20), work=square):
    told = []
    with helped(helpers):
        answers = shared(list(jobs), work, helpers, told.append)
    assert told[-1] == len(answers)
    return answers


def test_answers_stand_in_the_order_of_the_jobs_whoever_found_them():
    def slowly(number):
        time.sleep(0.2)
        return square(number)

    for helpers in ([], [Helper(squarer), Helper(squarer)]):
        answers = done_by(helpers, work=slowly)
        assert [answer for answer, _ in answers] == [number**2 for number in range(20)]
        assert any(process != os.getpid() for _, process in answers) == bool(helpers)


@pytest.mark.parametrize("make", [ended_by_itself, squarer])
def test_what_a_helper_fails_at_is_done_here(make):
    answers = done_by([Helper(make)], [1, 2, -3], lambda number: (time.sleep(0.3), number))
    assert [job for _, job in answers][-1:] in ([-3], [os.getpid()])
    assert len(answers) == 3


def test_an_error_of_this_process_is_raised_and_helpers_end():
    helper = Helper(sleeper)
    with pytest.raises(ValueError, match="-1 is negative"):
        done_by([helper], [-1, 1e6], square)
    assert helper._process.returncode == -signal.SIGKILL


def test_a_helper_tells_what_went_wrong():
    helper = Helper(squarer)
    with helped([helper]):
        assert helper.ask(3)[0] == 9
        with pytest.raises(RuntimeError, match="ValueError: -3 is negative"):
            helper.ask(-3)


def is_there(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


SCRIPT = """
import sys, threading, time
from pellucid.system.processes import Helper
sys.path.insert(0, {folder!r})
import test_processes
helper = Helper(test_processes.sleeper)
threading.Thread(target=helper.ask, args=(1e6,), daemon=True).start()
print(helper._process.pid, flush=True)
time.sleep(1e6)
"""


def test_a_helper_ends_with_its_parent_however_that_ends():
    script = SCRIPT.format(folder=os.path.dirname(__file__))
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as parent:
        helper = int(parent.stdout.readline())
        assert is_there(helper)
        time.sleep(2.0)
        parent.kill()
    deadline = time.monotonic() + 60.0
    while (there := is_there(helper)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not there


def test_the_core_of_this_process_is_not_free():
    assert 0 <= free_cores() < os.cpu_count()
