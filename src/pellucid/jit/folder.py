"""The folder of compiled kernels."""

import os
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
