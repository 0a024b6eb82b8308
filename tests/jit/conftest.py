"""What tests of kernels share."""

import numba
import pytest


@pytest.fixture(params=[1, 2, 4])
def threads(request):
    """Runs the test on this many threads, or all there are."""
    before = numba.get_num_threads()
    numba.set_num_threads(min(request.param, numba.config.NUMBA_NUM_THREADS))
    yield numba.get_num_threads()
    numba.set_num_threads(before)
