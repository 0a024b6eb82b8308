"""Check of a machine: features that pellucid uses, and remedies for missing ones."""

import os
import platform
import re
import shutil
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile

from pellucid.system.extras import install_command, pip

FOR_USERS = "mesh", "sweep", "notebook", "mpi"
"""Extras for users, without the extras for development."""
BROWSERS = "chromium", "google-chrome", "chrome", "chromium-browser", "msedge"
"""Browsers that can render a page without a screen and print its content."""
FLAGS = "--headless", "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-sync", "--dump-dom"
SOFTWARE = "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"
PAGE = """<p id="told"></p><script>
const context = document.createElement("canvas").getContext("webgl2");
document.getElementById("told").textContent = context ? "WebGL 2: " + context.getParameter(context.VERSION) : "no WebGL 2";
</script>"""
TRIAD, REPEATS = 4_000_000, 3  # length of the arrays, and repetitions, in the measurement of the memory bandwidth

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
import io, time
import numpy as np
from pellucid.results.pictures.camera import show
from pellucid.results.pictures.camera import View, camera_for
from pellucid.results.pictures.drawables import Balls
from pellucid.results.pictures.render import render
from pellucid.results.pictures.style import new_figure
begun, places = time.perf_counter(), np.random.default_rng(1).uniform(size=(2000, 3))
camera, figure = camera_for(View(-50.0, 22.0), places, 400), new_figure()
picture = render([Balls(places, np.full(2000, 0.02), np.full((2000, 3), 0.5))], camera, None)
show(figure.subplots(), picture, camera)
figure.savefig(io.BytesIO(), format="png")
assert 0.1 < np.mean(picture[..., 3] > 0.0) <= 1.0, "the picture is blank"
print(f"{time.perf_counter() - begun:.1f}")
"""

Row = tuple[str, str, str]


def examine() -> list[Row]:
    """Return the rows of the check of this machine: item, result, and advice if there is a problem."""
    return [
        ("python", f"{platform.python_version()} ({sys.executable})", ""),
        ("system", f"{platform.platform()}, {os.cpu_count()} cores", ""),
        ("pellucid", _version("pellucid") or "missing", ""),
        *(
            (name, _version(name) or "missing", "" if _version(name) else f"run `{pip()} install .` in the clone of pellucid")
            for name, _ in _packages("")
        ),
        *(_optional(name, extra) for name, extra in _optional_packages().items()),
        _threading(),
        _kernel_cache(),
        _drawing(),
        _browser(),
        _memory(),
        _bandwidth(),
        _disk(),
    ]


def _packages(extra: str) -> list[tuple[str, str]]:
    """Return name and further requirements, such as a version, of each package of an extra of pellucid (an optional group of
    dependencies); for an empty name, of the required packages."""
    found = [re.split(r"(?<=[\w\]])(?=[^\w.\-\[\]])", line, maxsplit=1) for line in requires("pellucid") or []]
    named = [(name.partition("[")[0], rest[0] if rest else "") for name, *rest in found]
    return [(name, rest) for name, rest in named if (f"extra == '{extra}'" in rest if extra else "extra ==" not in rest)]


def _optional_packages() -> dict[str, str]:
    """Return the packages of the extras for users, each with the first extra that contains it."""
    return {name: extra for extra in reversed(FOR_USERS) for name, _ in _packages(extra)}


def _optional(name: str, extra: str) -> Row:
    found = _version(name)
    return name, found or "not installed", "" if found else f"optional; to install it, run {install_command(extra)}"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def _threading() -> Row:
    status, text = _in_own_process(_THREADING)
    if status != 0:
        return "threads", f"a parallel kernel failed: {text}", "reinstall numba"
    layer, count = text.split()
    return "threads", f"numba threading layer {layer}, {count} threads", ""


def _kernel_cache() -> Row:
    from pellucid.jit import cache_folder

    folder = cache_folder()
    if not _writable(folder):
        return (
            "kernel cache",
            f"{folder} is not writable",
            "set the environment variable NUMBA_CACHE_DIR to a writable folder; otherwise every run compiles its kernels again",
        )
    found = "contains compiled kernels" if any(cache_folder().rglob("*.nbc")) else "empty: the first run compiles the kernels"
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
        return "stills and films", f"a test picture was drawn in {text} s, without a display", ""
    return "stills and films", f"a test picture could not be drawn: {text}", "reinstall matplotlib"


def _browser() -> Row:
    """Return the row about the interactive view of reports: whether a browser of this machine renders it (WebGL 2 with
    three.js)."""
    what, command = "interactive 3-D view", next(filter(None, map(shutil.which, BROWSERS)), None)
    if command is None:
        return what, "no browser for a test was found", "open report.html in any browser, also on another machine"
    with TemporaryDirectory(prefix="pellucid-") as folder:
        page = Path(folder) / "page.html"
        page.write_text(PAGE, encoding="utf-8")
        told = ""
        for more in ((), SOFTWARE):  # without a graphics card the browser draws itself, if it is told to
            call = [command, *FLAGS, *more, f"--user-data-dir={folder}/profile", page.as_uri()]
            try:
                done = subprocess.run(call, capture_output=True, text=True, timeout=60, check=False)
            except (OSError, subprocess.TimeoutExpired) as error:
                return what, f"{command} did not open a test page ({type(error).__name__})", "use another browser"
            told = next(iter(re.findall(r'<p id="told">(.+?)</p>', done.stdout)), "the test page printed nothing")
            if told.startswith("WebGL 2"):
                return what, f"{Path(command).name}: {told}{', software rendering' if more else ''}", ""
    return what, f"{Path(command).name}: {told}", "enable WebGL 2 in the browser, or open report.html on another machine"


def _memory() -> Row:
    try:
        page = os.sysconf("SC_PAGE_SIZE")
        total, free = os.sysconf("SC_PHYS_PAGES") * page, os.sysconf("SC_AVPHYS_PAGES") * page
    except (AttributeError, ValueError, OSError):
        return "memory", "unknown on this system", ""
    return "memory", f"{total / 2**30:.1f} GiB, {free / 2**30:.1f} GiB free", ""


def _bandwidth() -> Row:
    from pellucid.bench.machine import triad_bandwidth

    cores = os.cpu_count() or 1
    speeds = [triad_bandwidth(threads, TRIAD, REPEATS) / 1e9 for threads in dict.fromkeys((1, cores))]
    told = " and ".join(f"{speed:.1f} GB/s" for speed in speeds)
    return "memory bandwidth", f"{told} with {' and '.join(map(str, dict.fromkeys((1, cores))))} threads", ""


def _disk() -> Row:
    free = shutil.disk_usage(Path.cwd()).free / 2**30
    return "disk", f"{free:.1f} GiB free in {Path.cwd()}", "" if free > 1 else "free disk space before a long run"


def _in_own_process(source: str) -> tuple[int, str]:
    """Run Python source in a separate process; return its exit status and the last line of its output."""
    try:
        done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        return -1, "the test did not finish within 120 s"
    lines = (done.stdout if done.returncode == 0 else done.stderr).strip().splitlines()
    return done.returncode, lines[-1] if lines else ""
