"""The folder of compiled kernels, and what is known of it without a look at every kernel."""

import contextlib
import os
from pathlib import Path


def cache_folder() -> Path:
    """Where compiled kernels are kept."""
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        root = os.environ.get("XDG_CACHE_HOME")
        base = str((Path(root) if root else Path.home() / ".cache") / "pellucid")
    return Path(base) / "kernels"


def kernels_are_cached(key: str) -> bool:
    """Whether the kernels that `key` stands for were compiled before on this machine."""
    return (cache_folder() / f"{key}.ready").exists()


def mark_cached(key: str) -> None:
    """Remember that the kernels that `key` stands for are compiled; silent where the cache cannot be written."""
    with contextlib.suppress(OSError):
        (cache_folder() / f"{key}.ready").touch()
