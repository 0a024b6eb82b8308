"""Folder of compiled kernels, and the lock of one kernel among processes: the first compiles it, the others wait and load it
from the cache.

All locks are bytes of one file (POSIX record locks), so nothing has to be removed, and the locks of a process that dies are
released. Where files cannot be locked, each process compiles for itself.
"""

import fcntl
import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pellucid.errors import UsageError


def cache_folder() -> Path:
    """Return the folder in which compiled kernels are stored. Raises UsageError if no folder is set and there is no home
    folder."""
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        root = os.environ.get("XDG_CACHE_HOME")
        base = str((Path(root) if root else _home() / ".cache") / "pellucid")
    return Path(base) / "kernels"


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError:
        raise UsageError(
            "there is no home folder for compiled kernels: set the environment variable NUMBA_CACHE_DIR to a folder for them"
        ) from None


LONGEST_WAIT = 60.0
"""Time after which a process no longer waits for another one and compiles the kernel itself [s]."""
POLL = 0.02
"""Time between two attempts to lock [s]."""

_files: dict[tuple[int, Path], int] = {}  # descriptors by process and path; closing one would release all locks in its file


def _descriptor(file: Path) -> int:
    key = os.getpid(), file
    if key not in _files:
        file.parent.mkdir(parents=True, exist_ok=True)
        _files[key] = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    return _files[key]


def acquire(file: Path, key: str) -> bool:
    """Lock a kernel among processes, by its hexadecimal key, in the lock file `file`; return True if the kernel is locked.
    Returns False at once if files cannot be locked, and after `LONGEST_WAIT` if another process still holds the lock."""
    end = time.monotonic() + LONGEST_WAIT
    try:
        descriptor = _descriptor(file)
    except OSError:
        return False
    while True:
        try:
            fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, int(key[:15], 16))
            return True
        except (BlockingIOError, PermissionError):  # both mean that another process holds it
            if time.monotonic() > end:
                return False
            time.sleep(POLL)
        except OSError:
            return False


def release(file: Path, key: str) -> None:
    """Release the lock of a kernel, given by its hexadecimal key, in the lock file `file`."""
    with suppress(OSError):
        fcntl.lockf(_descriptor(file), fcntl.LOCK_UN, 1, int(key[:15], 16))


class Held(threading.local):
    """Locks of kernels that this thread holds while it compiles them, so that no other process compiles the same kernels."""

    def __init__(self) -> None:
        self._held: list[tuple[Path, str]] = []

    def lock(self, file: Path, key: str) -> bool:
        """Lock a kernel among processes until the end of the present `compiling` block; return True if the kernel is
        locked.

        file: lock file; key: hexadecimal key of the kernel; see `acquire`.
        """
        if not acquire(file, key):
            return False
        self._held.append((file, key))
        return True

    @contextmanager
    def compiling(self) -> Iterator[None]:
        """Context manager that releases, at the end of its block, the locks of kernels that were taken in the block."""
        before = len(self._held)
        try:
            yield
        finally:
            while len(self._held) > before:
                release(*self._held.pop())


held = Held()
