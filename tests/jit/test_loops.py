"""Loops written for one chunk: what is called, compiled, kept and told of them."""

import inspect
import json
import os
import subprocess
import sys
from typing import NamedTuple

import numba
import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import joint_region, parallel_loop, parallel_loop_by_colour
from pellucid.jit.registry import kernels

compiled_only = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")


@parallel_loop()
def scale(chunk, values, factor):
    """Values times a factor; shape (chunks,)."""
    values[chunk] *= factor


@parallel_loop(allocates=True)
def _sum_rows(chunk, values, sums):
    sums[chunk] = values[chunk].copy().sum()


@kernel()
def scale_twice(chunks, values, factor):
    scale(chunks, values, factor)
    scale(chunks, values, factor)


class Slabs(NamedTuple):
    across: int


class Mapped(NamedTuple):
    slabs: Slabs


class Target(NamedTuple):
    sums: np.ndarray


@parallel_loop_by_colour(gives="target.sums")
def add_to_both(s, mapped, target, share):
    """Reaches the next slab too."""
    for _ in range(300 if s else 100_000):
        target.sums[s] += share
        target.sums[s + 1] = 0.5 * target.sums[s + 1] + target.sums[s]


@parallel_loop_by_colour(gives="seen")
def note(s, mapped, seen, turn):
    """The slabs in the order in which they are done."""
    seen[s] = turn[0]
    turn[0] += 1.0


def mapped_in_rows(across):
    return Bundle(Mapped(Bundle(Slabs(across))))


@pytest.mark.parametrize("count", [0, 1, 2, 7, 1000])
def test_a_call_does_every_chunk_once(threads, count):
    values = np.ones(1001)
    scale(count, values, 3.0)
    assert np.array_equal(values, np.where(np.arange(1001) < count, 3.0, 1.0))


def test_kernels_call_a_loop_as_python_does(threads):
    values = np.ones(100)
    scale_twice(60, values, 3.0)
    assert np.array_equal(values, np.where(np.arange(100) < 60, 9.0, 1.0))


def test_a_chunk_may_make_arrays(threads):
    values, sums = np.arange(12.0).reshape(4, 3), np.zeros(4)
    _sum_rows(4, values, sums)
    assert np.array_equal(sums, values.sum(axis=1))


def test_neighbours_are_never_done_at_the_same_time(threads):
    seen, expected = np.zeros(31), np.zeros(31)
    for s in [*range(0, 30, 2), *range(1, 30, 2)]:
        for _ in range(300 if s else 100_000):
            expected[s] += 0.5
            expected[s + 1] = 0.5 * expected[s + 1] + expected[s]
    add_to_both(30, mapped_in_rows(1), Bundle(Target(seen)), 0.5)
    assert np.array_equal(seen, expected)


def test_slabs_of_every_other_row_go_first():
    numba.set_num_threads(1)
    try:
        seen = np.full(8, -1.0)
        note(8, mapped_in_rows(2), seen, np.zeros(1))
    finally:
        numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    assert np.array_equal(np.argsort(seen), [0, 4, 1, 5, 2, 6, 3, 7])


def test_processes_hear_what_neighbours_add_to(monkeypatch):
    given = []
    monkeypatch.setattr(joint_region, "by_parity", lambda do, arrays: (do(), given.extend(arrays)))
    sums, seen = np.zeros(4), np.zeros(4)
    add_to_both(3, mapped_in_rows(1), Bundle(Target(sums)), 1.0)
    note(4, mapped_in_rows(1), seen, np.zeros(1))
    assert given[0] is sums
    assert given[1] is seen
    assert sums.all()


def test_an_argument_that_is_not_there_cannot_be_given():
    with pytest.raises(ValueError, match="'target' is not in list"):
        parallel_loop_by_colour(gives="target")(lambda s, mapped: None)


@pytest.mark.parametrize("loop", [scale, add_to_both])
def test_a_loop_is_known_by_the_name_and_words_of_its_function(loop):
    assert loop.__module__ == __name__
    assert loop.__doc__
    assert "def " + loop.__name__ in inspect.getsource(getattr(loop, "py_func", loop))


def test_the_loop_and_its_chunks_are_registered():
    assert (__name__, "scale") in kernels
    assert (__name__, "scale_chunk") in kernels
    assert list(inspect.signature(scale).parameters) == ["chunk", "values", "factor"]


@compiled_only
def test_an_error_tells_the_line_of_the_chunk_and_where_the_loop_is():
    @parallel_loop()
    def wrong(chunk, values):
        values[chunk] = "text"

    with pytest.raises(numba.TypingError) as error:
        wrong(1, np.ones(1))
    said = str(error.value)
    assert 'values[chunk] = "text"' in said
    assert "wrong_chunk" in said
    lines = inspect.getsource(sys.modules[__name__]).split("\n")
    assert f'test_loops.py", line {lines.index("    def wrong(chunk, values):")}' in said


LOOP = """
import json
import numpy as np
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop, parallel_loop_by_colour
from numba.core.event import RecordingListener, install_listener
from typing import NamedTuple

@parallel_loop()
def add(s, x):
    x[s] += 2.0 * s

class Slabs(NamedTuple):
    across: int

class Mapped(NamedTuple):
    slabs: Slabs

@parallel_loop_by_colour(gives="x")
def add_by_colour(s, mapped, x):
    x[s] += 3.0 * s

x, compiled = np.zeros(10), RecordingListener()
with install_listener("numba:compile", compiled):
    add(10, x)
    add_by_colour(10, Bundle(Mapped(Bundle(Slabs(5)))), x)
print(json.dumps([x.sum(), sorted({event.data["dispatcher"].py_func.__name__ for _, event in compiled.buffer})]))
"""


@compiled_only
def test_a_second_process_compiles_nothing(tmp_path):
    def run(text):
        (tmp_path / "script.py").write_text(text)
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": os.pathsep.join(sys.path)}
        command = [sys.executable, "script.py"]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=100)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    assert run(LOOP) == [225.0, ["add", "add_by_colour", "add_by_colour_chunk", "add_chunk"]]
    assert run(LOOP) == [225.0, []]
    assert run(LOOP.replace("2.0 * s", "4.0 * s")) == [315.0, ["add", "add_chunk"]]
    names = {file.name.rpartition("-")[0] for file in (tmp_path / "cache").rglob("*.nbc")}
    assert names == {"add", "add_chunk", "add_by_colour", "add_by_colour_chunk"}
