"""Reading of files given by users."""

import errno
import stat
from pathlib import Path


def file_bytes(path: Path | str) -> bytes:
    """Return the bytes of a file. Raises OSError, also for an empty path or for a path that is no regular file, e.g. a
    pipe, which may never end."""
    try:
        mode = Path(path).stat().st_mode
    except ValueError as error:  # a null character within it
        raise OSError(errno.EINVAL, f"the path has an {error}") from None
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise OSError(errno.EINVAL, "it is a pipe or a device, not a file")
    return Path(path).read_bytes()
