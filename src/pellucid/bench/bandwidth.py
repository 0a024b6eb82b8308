"""Memory bandwidth by the triad of STREAM (McCalpin 1995): a = b + s c on arrays far larger than the caches."""

import time

import numpy as np
from numba import prange, set_num_threads

from pellucid.jit import kernel


@kernel(parallel=True)
def _triad(a, b, c, s):  # type: ignore[no-untyped-def]
    for i in prange(len(a)):
        a[i] = b[i] + s * c[i]


def triad_bandwidth(threads: int, length: int = 20_000_000, repeats: int = 5) -> float:
    """Best rate of `repeats` triads on `threads` threads [bytes/s], 24 bytes an element as STREAM counts them."""
    a, b, c = np.zeros(length), np.ones(length), np.ones(length)
    set_num_threads(threads)
    _triad(a, b, c, 2.0)
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        _triad(a, b, c, 2.0)
        best = min(best, time.perf_counter() - start)
    return 24.0 * length / best
