"""The folder of compiled kernels."""

import os
from pathlib import Path


def cache_folder() -> Path:
    """Where compiled kernels are kept."""
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        root = os.environ.get("XDG_CACHE_HOME")
        base = str((Path(root) if root else Path.home() / ".cache") / "pellucid")
    return Path(base) / "kernels"
