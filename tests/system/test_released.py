import mmap
import sys

import numpy as np
import pytest

from pellucid.system.released import release


def resident():
    """Memory of this process [bytes]."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * mmap.PAGESIZE


@pytest.mark.skipif(sys.platform != "linux", reason="the system takes memory back on Linux alone")
def test_memory_goes_back_and_what_is_kept_stays():
    array = np.arange(4_000_000, dtype=float)
    before = resident()
    release(array[1_000_000:])
    assert before - resident() > 0.9 * 24_000_000
    assert np.array_equal(array[:1_000_000], np.arange(1_000_000.0))
    array[1_000_000:] = 7.0  # it can be used again
    assert array[-1] == 7.0


def test_less_than_a_page_is_left_alone():
    array = np.arange(100.0)
    release(array)
    assert np.array_equal(array, np.arange(100.0))
