"""The loop that threads share: every chunk once, on any number of threads, from the cache as well."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for


@kernel(inner=True)
def _fill(s, result, who, factor):
    result[s] += factor * s
    who[s] = numba.get_thread_id()


@kernel()
def fill(start, step, count, result, who, factor):
    parallel_for(_fill, start, step, count, result, who, factor)


@pytest.fixture(params=[1, 2, 4])
def threads(request):
    """Runs the test on this many threads, or all there are."""
    before = numba.get_num_threads()
    numba.set_num_threads(min(request.param, numba.config.NUMBA_NUM_THREADS))
    yield numba.get_num_threads()
    numba.set_num_threads(before)


@pytest.mark.parametrize("count", [0, 1, 2, 3, 7, 1000])
@pytest.mark.parametrize(("start", "step"), [(0, 1), (1, 2)])
def test_every_chunk_is_done_once(threads, start, step, count):
    result, who = np.zeros(2002), np.full(2002, -1)
    fill(start, step, count, result, who, 0.5)
    expected = np.zeros(2002)
    expected[start : start + step * count : step] = 0.5 * np.arange(start, start + step * count, step)
    assert np.array_equal(result, expected)
    assert who.max() < threads
    if count == 1000:
        assert len(np.unique(who[who >= 0])) == threads


@pytest.mark.parametrize("count", [0, 1, 2, 3, 7, 1000])
@pytest.mark.parametrize(("start", "step"), [(0, 1), (1, 2)])
def test_plain_python_does_the_same(start, step, count):
    from pellucid.jit.parallel import _plain

    done = []
    _plain(lambda s, *rest: done.append((s, rest)), start, step, count, "a", "b")
    assert done == [(s, ("a", "b")) for s in range(start, start + step * count, step)]


SCRIPT = """
import sys
sys.path.insert(0, {folder!r})
import numpy as np
import test_parallel
result, who = np.zeros(100), np.zeros(100, dtype=np.int64)
test_parallel.fill(0, 1, 100, result, who, 2.0)
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
