"""Memory of this machine: bandwidth, and peak memory of this process."""

import resource
import sys
import time
from pathlib import Path

import numpy as np
from numba import set_num_threads

from pellucid.jit.loops import parallel_loop


@parallel_loop()
def _triad(share, shares, a, b, c, s):  # type: ignore[no-untyped-def]
    for i in range(share * len(a) // shares, (share + 1) * len(a) // shares):
        a[i] = b[i] + s * c[i]


def triad_bandwidth(threads: int, length: int = 20_000_000, repeats: int = 5) -> float:
    """Measure and return the memory bandwidth [bytes/s]: the best rate of `repeats` triads (a = b + s c on arrays of
    `length` doubles) on `threads` threads, counting 24 bytes per element as in STREAM."""
    a, b, c = np.zeros(length), np.ones(length), np.ones(length)
    set_num_threads(threads)
    _triad(threads, threads, a, b, c, 2.0)
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        _triad(threads, threads, a, b, c, 2.0)
        best = min(best, time.perf_counter() - start)
    return 24.0 * length / best


def peak_bytes() -> int:
    """Return the peak memory of this process [bytes]. On Linux `getrusage` would include the memory of the parent process."""
    status = Path("/proc/self/status")
    if status.exists():
        return 1024 * next(int(line.split()[1]) for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
