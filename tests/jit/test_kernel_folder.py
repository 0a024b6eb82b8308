"""Processes that need the same kernel: one compiles it, the others wait for it."""

import json
import os
import subprocess
import sys
import time

import pytest

from pellucid.jit import kernel_folder
from pellucid.jit.kernel_folder import Held, acquire, release

pytestmark = pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")
KEY = "0123456789abcdef0123456789abcdef"
COUNT = """
import json, sys, time
from numba.core import event
from pellucid.jit import kernel

@kernel()
def total(values):
    result = 0.0
    for value in values:
        result += value
    return result

compiled = event.RecordingListener()
event.register("numba:compile", compiled)
import numpy as np
import pellucid.jit.cache as cache
save = cache.KernelCache.save_overload
def slowly(self, sig, data):
    time.sleep(1.0)  # the others need the kernel meanwhile
    save(self, sig, data)
cache.KernelCache.save_overload = slowly
print("ready", flush=True)
sys.stdin.readline()
assert total(np.ones(3)) == 3.0
print(json.dumps(len(compiled.buffer) // 2))
"""


def test_of_several_processes_one_compiles(tmp_path):
    file = tmp_path / "program.py"
    file.write_text(COUNT)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": os.pathsep.join(sys.path)}
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "env": environment}
    processes = [subprocess.Popen([sys.executable, str(file)], **pipes) for _ in range(3)]
    for process in processes:
        assert process.stdout.readline() == "ready\n"
    for process in processes:
        process.stdin.write("\n")
        process.stdin.flush()
    counts = [json.loads(process.communicate(timeout=100)[0]) for process in processes]
    assert sorted(counts) == [0, 0, 1]


HOLD = """
import sys
from pathlib import Path
from pellucid.jit.kernel_folder import acquire
assert acquire(Path(sys.argv[1]), sys.argv[2])
print("held", flush=True)
sys.stdin.readline()
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that holds the lock of KEY."""
    command = [sys.executable, "-c", HOLD, str(tmp_path / "locks"), KEY]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_a_lock_that_is_never_released_is_not_waited_for(tmp_path, holder, monkeypatch):
    monkeypatch.setattr(kernel_folder, "LONGEST_WAIT", 0.1)
    start = time.monotonic()
    assert not acquire(tmp_path / "locks", KEY)
    assert time.monotonic() - start >= 0.1
    assert acquire(tmp_path / "locks", KEY[::-1]), "another kernel has its own lock"
    release(tmp_path / "locks", KEY[::-1])


def test_a_process_that_is_killed_holds_nothing(tmp_path, holder):
    holder.kill()
    holder.wait()
    assert acquire(tmp_path / "locks", KEY)
    release(tmp_path / "locks", KEY)


def test_locks_last_as_long_as_the_compilation(tmp_path):
    held, command = Held(), [sys.executable, "-c", HOLD, str(tmp_path / "locks"), KEY]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}

    @held.compiling()
    def compile_in_vain():
        assert held.lock(tmp_path / "locks", KEY)
        raise ValueError("no code")

    with pytest.raises(ValueError, match="no code"):
        compile_in_vain()
    done = subprocess.run(command, input="\n", capture_output=True, text=True, env=environment, timeout=100)
    assert done.stdout == "held\n", done.stderr


def test_without_a_folder_nothing_is_locked(tmp_path):
    (tmp_path / "file").write_text("")
    start = time.monotonic()
    assert not acquire(tmp_path / "file" / "locks", KEY)
    assert time.monotonic() - start < 1.0
