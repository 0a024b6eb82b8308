"""Files that are either complete or absent, even if the process is killed; the lock of a run's folder; the list of the
pictures that the program drew."""

import errno
import json
import os
import socket
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from pellucid.errors import PellucidError, UsageError

DRAFT = ".writing"
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
UNFIT = (errno.ENOENT, errno.ENOTDIR, errno.EACCES, errno.EPERM, errno.EROFS, errno.ENAMETOOLONG, errno.ELOOP)


class OutputError(PellucidError):
    """Error for results that cannot be written or read: a full disk, a missing permission, a damaged file."""

    exit_status = 3


def draft_of(path: Path) -> Path:
    """Return the temporary path under which a file is written first."""
    return path.with_name(f".{path.name}{DRAFT}")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path in the folder of `path`. It replaces `path` atomically if the block succeeds.

    The file is synced to the disk before it is renamed, and the folder before the block is left. If the block fails, `path`
    stays unchanged and the temporary file is removed.
    """
    temporary = draft_of(path)
    try:
        yield temporary
        sync(temporary)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise
    sync(path.parent)


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` atomically (UTF-8, no translation of line ends)."""
    with replacing(path) as temporary:
        temporary.write_bytes(text.encode())


def sync(path: Path) -> None:
    """Flush a file or a folder to the disk (fsync)."""
    try:
        handle = os.open(path, os.O_RDONLY)
    except PermissionError:  # some systems do not open folders
        if path.is_dir():
            return
        raise
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def usable(folder: Path) -> Iterator[None]:
    """Turn errors of the operating system in the block into a `UsageError`: results cannot be written to `folder`."""
    try:
        yield
    except OSError as error:
        if error.errno not in UNFIT:
            raise
        reason = f"cannot write results to {folder}: {error.strerror}"
        raise UsageError(f"{reason}\n    Set `--out` to a writable folder.") from error


@contextmanager
def explained(folder: Path) -> Iterator[None]:
    """Turn errors of the operating system in the block, such as a full disk, into an `OutputError` that states the remedy."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error) or type(error).__name__
        checkpoints = folder / "checkpoint"
        kept = any(checkpoints.glob("*.npz")) if checkpoints.is_dir() else False
        mend = "Free disk space" if error.errno in FULL else "Correct the cause"
        remedy = (
            f"The earlier checkpoints are intact. {mend}, then run `pellucid resume {folder}` to continue."
            if kept
            else f"No checkpoint was written yet. {mend}, then start the run again."
        )
        raise OutputError(f"cannot write the results to {folder}: {reason}\n    {remedy}") from error


if sys.platform != "win32":
    import fcntl

LOCK = "run.lock"
PROGRAM = "pellucid"
MOST_OF_SIGNATURE = 1000  # bytes of a signature


@contextmanager
def lock_held(folder: Path) -> Iterator[None]:
    """Hold the lock of an existing run folder during the block. No other process or thread can write to the folder.

    Raises `UsageError`, with process, machine and time of the owner, if the lock is already held.

    The signature in the lock file also marks the folder as the folder of a run, because other programs use lock files of this
    name too. The kernel releases the lock when the process ends for any reason; the file remains.
    """
    with explained(folder), usable(folder):
        handle = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        _take(handle, folder)
        with suppress(OSError):  # on a full disk the lock counts all the same
            _sign(handle)
        yield
    finally:
        os.close(handle)


def is_signed_lock(path: Path) -> bool:
    """Return True if pellucid wrote the lock file at `path`, i.e. if the file contains a signature of the program."""
    return _lock_entry(path, "program") == PROGRAM


def is_own_lock(path: Path) -> bool:
    """Return True if this process was the last owner of the lock file at `path`."""
    return _lock_entry(path, "pid") == os.getpid() and _lock_entry(path, "host") == socket.gethostname()


def _lock_entry(path: Path, key: str) -> object:
    """Return the entry `key` ("program", "pid", "host" or "since") of the signature in a lock file; None if the entry
    cannot be read."""
    try:
        return _signature(path.read_bytes()[:MOST_OF_SIGNATURE])[key]
    except (OSError, ValueError, KeyError, TypeError):
        return None


def refuse_locked(folder: Path) -> None:
    """Raise `UsageError` if any process is writing to the run in `folder`, i.e. holds its lock."""
    if (folder / LOCK).is_file():
        with explained(folder), usable(folder):
            handle = os.open(folder / LOCK, os.O_RDWR)
        try:
            _take(handle, folder)
        finally:
            os.close(handle)


def _take(handle: int, folder: Path) -> None:
    if sys.platform == "win32":  # without locks
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        text = f"{_owner(handle)} is writing to {folder}"
        raise UsageError(f"{text}.\n    Wait until it has finished, or choose another folder.") from None
    except OSError as error:
        text = (
            f"the disk of {folder} does not support file locks ({error.strerror}); make "
            "sure that only one process writes to this folder"
        )
        warnings.warn(text, stacklevel=2)


def _sign(handle: int) -> None:
    signature = {
        "program": PROGRAM,
        "pid": os.getpid(),
        "host": socket.gethostname(),
        "since": datetime.now().astimezone().isoformat(" ", "seconds"),
    }
    line = f"{json.dumps(signature)}\n".encode()
    os.pwrite(handle, line, 0)  # over the one before, which on a full disk or in a killed process counts on
    os.ftruncate(handle, len(line))


def _owner(handle: int) -> str:
    """Describe the process that holds a lock for a message, from the open lock file with the descriptor `handle`. A process
    that has just acquired the lock may not have signed it yet."""
    try:
        found = _signature(os.pread(handle, MOST_OF_SIGNATURE, 0))
        return f"process {int(found['pid'])} on {found['host']!s}, since {found['since']!s},"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"


def _signature(data: bytes) -> Any:
    return json.loads(data.partition(b"\n")[0])


DRAWN_LIST = ".drawn"


@contextmanager
def drawing(path: Path) -> Iterator[Path]:
    """Yield a temporary path for a picture. If the block succeeds, add its name to the list of drawn pictures, then move it to
    `path`.

    The list keeps pictures of the user from being removed. It is a file in the folder of the figures.
    """
    with replacing(path) as temporary:
        yield temporary
        if path.name not in (known := _drawn_names(path.parent)):
            write_text(path.parent / DRAWN_LIST, "".join(f"{name}\n" for name in [*known, path.name]))


def drawn_files(folder: Path) -> list[Path]:
    """Return the paths of the pictures drawn by `drawing`, their drafts and their list."""
    pictures = [path for name in _drawn_names(folder) for path in (draft_of(folder / name), folder / name)]
    drafts = [path for path in folder.glob(f".*{DRAFT}") if path.with_suffix("").suffix in (".png", ".gif")]
    return [*pictures, *drafts, draft_of(folder / DRAWN_LIST), folder / DRAWN_LIST]


def _drawn_names(folder: Path) -> list[str]:
    try:
        return [name for name in (folder / DRAWN_LIST).read_text(encoding="utf-8").split("\n") if name == Path(name).name != ""]
    except (OSError, ValueError):
        return []
