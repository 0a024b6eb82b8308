"""Files that are either complete or absent, even if the process is killed."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

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
