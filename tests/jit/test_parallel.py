"""The loop that threads share: every chunk once, on any number of threads, from the cache as well."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.loops import _plain_by_colour, _plain_loop, parallel_by_colour, parallel_for
from pellucid.jit.region import make_known


@kernel(inner=True)
def _fill(s, result, who, factor):
    result[s] += factor * s
    who[s] = numba.get_thread_id()


@kernel()
def fill(count, result, who, factor):
    parallel_for(_fill, count, result, who, factor)


@kernel(inner=True)
def _meet(s, count, shares, met, looks, who):
    """The first and the last chunk of a share wait for those of all others, so that no thread can help another."""
    who[s] = numba.get_thread_id()
    for k in range(shares):
        for end, at in enumerate((k * count // shares, (k + 1) * count // shares - 1)):
            if s == at:
                met[end, k] = 1.0
                while met[end].sum() < shares and looks[k] < 1e9:
                    looks[k] += 1.0


@kernel()
def meet(count, shares, met, looks, who):
    parallel_for(_meet, count, count, shares, met, looks, who)


@kernel(inner=True)
def _add_to_both(s, seen):
    """Reaches the next chunk too, which a neighbour of the other colour must not do at the same time; the first takes long."""
    for _ in range(1000 if s else 100_000):
        seen[s] += 1.0
        seen[s + 1] = 0.5 * seen[s + 1] + seen[s]


@kernel()
def add_by_colour(count, seen):
    parallel_by_colour(_add_to_both, count, 1, seen)


@kernel(inner=True)
def _note(s, seen, turn):
    seen[s] = turn[0]
    turn[0] += 1.0


@kernel()
def note_by_colour(count, across, seen, turn):
    parallel_by_colour(_note, count, across, seen, turn)


COUNTS = [0, 1, 2, 3, 7, 1000]


@pytest.mark.parametrize("count", COUNTS)
def test_every_chunk_is_done_once(threads, count):
    result, who = np.zeros(1001), np.full(1001, -1)
    fill(count, result, who, 0.5)
    expected = 0.5 * np.arange(1001)
    expected[count:] = 0.0
    assert np.array_equal(result, expected)
    assert who.max() < threads
    if count == 1000 and not numba.config.DISABLE_JIT:
        seen = set(who[:1000])
        for _ in range(1000):  # on a busy machine another thread may come too late
            fill(count, result, who, 0.5)
            seen |= set(who[:1000])
        assert len(seen) == threads


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="there is one thread")
def test_each_thread_has_its_own_share(threads):
    """As OpenMP numbers threads; other layers of numba may give shares to whoever comes."""
    make_known()
    if numba.threading_layer() != "omp":
        pytest.skip(f"the layer {numba.threading_layer()} does not number threads so")
    count = 41
    for _ in range(3):
        who = np.full(count, -1)
        meet(count, threads, np.zeros((2, threads)), np.zeros(threads), who)
        assert np.array_equal(who, np.repeat(np.arange(threads), np.diff(np.arange(threads + 1) * count // threads)))


@pytest.mark.parametrize("count", COUNTS)
def test_even_chunks_go_before_odd_ones(threads, count):
    expected, seen = np.zeros(1002), np.zeros(1002)
    for colour in range(2):
        for s in range(colour, count, 2):
            _add_to_both.py_func(s, expected) if hasattr(_add_to_both, "py_func") else _add_to_both(s, expected)
    add_by_colour(count, seen)
    assert np.array_equal(seen, expected)


@pytest.mark.parametrize("count", COUNTS)
def test_plain_python_does_the_same(count):
    done: list = []

    def note(s, *rest):
        done.append((s, rest))

    _plain_loop(note, count, "a", "b")
    assert done == [(s, ("a", "b")) for s in range(count)]
    done.clear()
    _plain_by_colour(note, count, 1, "a")
    assert done == [(s, ("a",)) for s in [*range(0, count, 2), *range(1, count, 2)]]


@pytest.mark.parametrize(("rows", "across"), [(1, 1), (1, 5), (4, 1), (4, 4), (5, 3), (3, 2)])
def test_neighbours_in_rows_are_of_different_colours(rows, across):
    """On one thread chunks are done in order: even rows first, and of a row the even chunks."""
    numba.set_num_threads(1)
    try:
        seen = np.full(rows * across, -1.0)
        note_by_colour(rows * across, across, seen, np.zeros(1))
    finally:
        numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    done: list = []
    _plain_by_colour(lambda s: done.append(s), rows * across, across)
    assert np.array_equal(np.argsort(seen), done)
    colours = [(row % 2, place % 2) for row, place in (divmod(s, across) for s in done)]
    assert colours == sorted(colours)
    assert len(set(done)) == rows * across


SCRIPT = """
import sys
sys.path.insert(0, {folder!r})
import numpy as np
import test_parallel
result, who = np.zeros(100), np.zeros(100, dtype=np.int64)
test_parallel.fill(100, result, who, 2.0)
assert result.sum() == 9900.0, result
print(sum(test_parallel.fill.stats.cache_hits.values()))
"""


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="there is nothing to cache")
def test_a_driver_from_the_cache_runs_in_a_process_without_threads(tmp_path):
    """Nothing else has started numba's threads there."""
    said = []
    for _ in range(2):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
        script = SCRIPT.format(folder=os.path.dirname(__file__))
        done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, timeout=100)
        assert done.returncode == 0, done.stderr
        said.append(done.stdout.strip())
    assert said == ["0", "1"]
