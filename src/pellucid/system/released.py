"""Memory that arrays no longer use, given back to the system."""

import ctypes
import mmap
import sys

import numpy as np

NOT_NEEDED = 4  # MADV_DONTNEED of Linux: the pages hold zeros when they are used again


def release(array: np.ndarray) -> None:
    """Give back the whole pages of memory of an array in C order whose values are not needed any more; on Linux alone."""
    if sys.platform != "linux" or array.nbytes < 2 * mmap.PAGESIZE:
        return
    begin = -(-array.ctypes.data // mmap.PAGESIZE) * mmap.PAGESIZE
    length = (array.ctypes.data + array.nbytes - begin) // mmap.PAGESIZE * mmap.PAGESIZE
    ctypes.CDLL(None).madvise(ctypes.c_void_p(begin), ctypes.c_size_t(length), NOT_NEEDED)
