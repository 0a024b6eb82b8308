"""What a machine offers to pellucid, and what to do where something is missing."""

import os
import platform
import shutil
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from tempfile import TemporaryFile

PACKAGES = ("pellucid", "numpy", "scipy", "numba", "h5py", "pydantic", "tomlkit", "pint", "typer", "rich", "matplotlib")
EXTRAS = {"meshlane": "mesh", "tetgen": "mesh", "distributed": "sweep", "optuna": "sweep", "SALib": "sweep"}

_THREADING = """
import numba, numpy
@numba.njit(parallel=True)
def total(x):
    s = 0.0
    for i in numba.prange(len(x)):
        s += x[i]
    return s
total(numpy.ones(8))
print(numba.threading_layer(), numba.get_num_threads())
"""

_DRAWING = """
import io
from pellucid.results.pictures.style import new_figure
new_figure().savefig(io.BytesIO(), format="png")
"""

Row = tuple[str, str, str]


def examine() -> list[Row]:
    """Rows of what was looked at, what was found, and advice where something is amiss."""
    return [
        ("python", f"{platform.python_version()} ({sys.executable})", ""),
        ("system", f"{platform.platform()}, {os.cpu_count()} cores", ""),
        *((name, _version(name) or "missing", "" if _version(name) else "pip install . in the clone") for name in PACKAGES),
        *(
            (name, _version(name) or "not installed", f"optional: pip install '.[{extra}]' in the clone")
            for name, extra in EXTRAS.items()
        ),
        _threading(),
        _kernel_cache(),
        _drawing(),
        _memory(),
        _disk(),
    ]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def _threading() -> Row:
    status, text = _in_own_process(_THREADING)
    if status != 0:
        return "threads", "a parallel kernel failed", f"reinstall numba: {text}"
    layer, count = text.split()
    return "threads", f"numba's layer {layer}, {count} threads", ""


def _kernel_cache() -> Row:
    from pellucid.jit import cache_folder

    folder = cache_folder()
    if not _writable(folder):
        return (
            "kernel cache",
            f"{folder} cannot be written",
            "name a folder in NUMBA_CACHE_DIR, else every run compiles anew",
        )
    found = "kernels are there" if any(cache_folder().rglob("*.nbc")) else "empty: the first run compiles"
    return "kernel cache", f"{folder}, writable; {found}", ""


def _writable(folder: Path) -> bool:
    while not folder.exists():
        folder = folder.parent
    try:
        with TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _drawing() -> Row:
    status, text = _in_own_process(_DRAWING)
    if status == 0:
        return "drawing in 3-D", "pellucid's own renderer draws into figures of matplotlib, without a screen", ""
    return "drawing in 3-D", "no figure can be written", f"reinstall matplotlib: {text}"


def _memory() -> Row:
    try:
        page = os.sysconf("SC_PAGE_SIZE")
        total, free = os.sysconf("SC_PHYS_PAGES") * page, os.sysconf("SC_AVPHYS_PAGES") * page
    except (AttributeError, ValueError, OSError):
        return "memory", "unknown on this system", ""
    return "memory", f"{total / 2**30:.1f} GiB, {free / 2**30:.1f} GiB free", ""


def _disk() -> Row:
    free = shutil.disk_usage(Path.cwd()).free / 2**30
    return "disk", f"{free:.1f} GiB free in {Path.cwd()}", "" if free > 1 else "make room before a long run"


def _in_own_process(source: str) -> tuple[int, str]:
    """Exit status and the last line that a piece of Python printed."""
    try:
        done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        return -1, "it did not end within 120 s"
    lines = (done.stdout if done.returncode == 0 else done.stderr).strip().splitlines()
    return done.returncode, lines[-1] if lines else ""
