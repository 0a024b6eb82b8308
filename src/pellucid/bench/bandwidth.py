"""Memory bandwidth by the triad of STREAM (McCalpin 1995): a = b + s c on arrays far larger than the caches."""

import time

import numpy as np
from numba import set_num_threads

from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for


@kernel(inner=True)
def _triad_share(share, shares, a, b, c, s):  # type: ignore[no-untyped-def]
    for i in range(share * len(a) // shares, (share + 1) * len(a) // shares):
        a[i] = b[i] + s * c[i]


@kernel()
def _triad(shares, a, b, c, s):  # type: ignore[no-untyped-def]
    parallel_for(_triad_share, shares, shares, a, b, c, s)


def triad_bandwidth(threads: int, length: int = 20_000_000, repeats: int = 5) -> float:
    """Best rate of `repeats` triads on `threads` threads [bytes/s], 24 bytes an element as STREAM counts them."""
    a, b, c = np.zeros(length), np.ones(length), np.ones(length)
    set_num_threads(threads)
    _triad(threads, a, b, c, 2.0)
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        _triad(threads, a, b, c, 2.0)
        best = min(best, time.perf_counter() - start)
    return 24.0 * length / best
