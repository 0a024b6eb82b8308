"""Compiled kernels come back in the next process where nothing that they depend on has changed, and only there."""

import json
import os
import subprocess
import sys
from shutil import copytree

import pytest

from pellucid.errors import UsageError
from pellucid.jit import cache_folder

SHAPES = '''
from typing import NamedTuple
from pellucid.jit import default_function, generic, kernel, pointwise

FACTOR = 1.0

class Slice(NamedTuple):
    first: float
    last: float

@generic
def area(shape, scale):
    """Area of a shape."""

@generic
def unused(shape):
    """Nothing calls this."""

@generic
def excess(shape):
    """What is added."""

@default_function(excess)
def _no_excess(shape):
    return 0.0

@pointwise
def scaled(x):
    """A caption."""
    return FACTOR * x

@kernel(inner=True)
def share(shape, i):
    return scaled(area(shape, 1.0 + i)) + excess(shape)

@kernel()
def total(shape, n):
    result = 0.0
    for i in range(n):
        result += share(shape, i)
    return result
'''

LAW = '''
from typing import NamedTuple
from pellucid.jit import point_function, pointwise
from shapes import Slice, area, unused

class Hexagon(NamedTuple):
    side: float
    height: float

@pointwise
def product(a, b):
    """A caption."""
    return 1.0 * a * b

@point_function(area, Hexagon)
def _area(shape, scale):
    return scale * product(shape.side, 3.0)

@point_function(unused, Hexagon)
def _unused(shape):
    return 0.0
'''

RUN = """
import json
from shapes import total
print(json.dumps([total(Hexagon(2.0, 5.0), 3), sum(total.stats.cache_hits.values()), sum(total.stats.cache_misses.values())]))
"""


@pytest.fixture
def run(tmp_path):
    """Runs a script with its own modules in a new process: the result, and whether the kernel came from the cache."""
    return runner_in(tmp_path)


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    """A folder of modules whose kernel was compiled in it, in another process."""
    folder = tmp_path_factory.mktemp("warm")
    assert runner_in(folder)() == (36.0, False)
    return folder


@pytest.fixture
def run_again(warm, tmp_path):
    """The same as `run` where that was done."""
    copytree(warm, tmp_path, dirs_exist_ok=True)
    return runner_in(tmp_path)


def runner_in(tmp_path):
    (tmp_path / "shapes.py").write_text(SHAPES)
    (tmp_path / "law.py").write_text(LAW)

    def call(script="from law import Hexagon" + RUN):
        (tmp_path / "script.py").write_text(script)
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": os.pathsep.join(sys.path)}
        done = subprocess.run(
            [sys.executable, "script.py"], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=100
        )
        assert done.returncode == 0, done.stderr
        value, *found = json.loads(done.stdout)
        assert found in ([0, 1], [1, 0])
        call.said = done.stderr
        return value, found == [1, 0]

    def edit(name, old, new):
        text = (tmp_path / name).read_text()
        assert old in text
        (tmp_path / name).write_text(text.replace(old, new))

    call.edit = edit
    return call


def test_the_next_process_finds_the_kernel(run_again):
    assert run_again() == (36.0, True)


def test_captions_comments_and_places_do_not_matter(run_again):
    run_again.edit("law.py", "A caption", "Another caption")
    run_again.edit("shapes.py", "A caption", "Another caption")
    run_again.edit("shapes.py", "FACTOR = 1.0", "# a comment\n\nFACTOR = 1.0\nOTHER = 2.0")
    run_again.edit("law.py", "return 0.0", "return 1.0")  # an operation that the kernel does not call
    assert run_again() == (36.0, True)


@pytest.mark.parametrize(
    ("name", "old", "new", "value"),
    [
        ("law.py", "scale * product", "2.0 * scale * product", 72.0),  # the implementation
        ("law.py", "1.0 * a * b", "3.0 * a * b", 108.0),  # its helper
        ("law.py", "side: float\n    height: float", "height: float\n    side: float", 90.0),  # the order of its parameters
        ("shapes.py", "FACTOR = 1.0", "FACTOR = 0.5", 18.0),  # a constant
        ("shapes.py", "return 0.0", "return 1.0", 39.0),  # the function for types that register none
        ("shapes.py", "1.0 + i", "2.0 + i", 54.0),  # an inner kernel
        ("shapes.py", "result = 0.0", "result = 1.0", 37.0),  # the kernel
    ],
)
def test_what_the_kernel_depends_on_matters(run_again, name, old, new, value):
    run_again.edit(name, old, new)
    assert run_again() == (value, False)
    assert run_again() == (value, True)


def test_a_law_in_a_script_is_found_again(run):
    script = LAW + RUN
    assert run(script) == (36.0, False)
    assert run(script) == (36.0, True)
    assert run(script.replace("1.0 * a * b", "3.0 * a * b")) == (108.0, False)
    assert run(script) == (36.0, True)


def test_a_law_that_is_not_there_does_not_stand_in_the_way(run_again, tmp_path):
    """Kernels compiled for a user's class lie beside those of others who do not have it."""
    (tmp_path / "law.py").rename(tmp_path / "mine.py")
    assert run_again("from mine import Hexagon" + RUN) == (36.0, False)
    assert run_again(LAW + RUN) == (36.0, False)


@pytest.mark.parametrize("damage", [lambda data: data[:100], lambda data: b"", lambda data: data[:-9] + b"x" + data[-8:]])
def test_a_damaged_file_is_compiled_anew_and_told_once(run_again, tmp_path, damage):
    files = list((tmp_path / "cache").rglob("*.nbc"))
    for file in files:
        file.write_bytes(damage(file.read_bytes()))
    assert run_again() == (36.0, False)
    assert len(files) > 1
    assert run_again.said.count("its bytes do not match its digest): it is compiled again") == 1
    assert run_again() == (36.0, True)
    assert not run_again.said


def test_without_a_place_to_write_kernels_are_compiled_and_that_is_told_once(run, tmp_path):
    (tmp_path / "cache").write_text("a file where the folder would be")
    for _ in range(2):
        assert run() == (36.0, False)
        assert run.said.count("compiled kernels cannot be stored in") == 1


def test_on_a_full_disk_kernels_are_compiled_and_nothing_half_written_stays(run, tmp_path):
    full = "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    full += "resource.setrlimit(resource.RLIMIT_FSIZE, (600, 600))\nfrom law import Hexagon\n"  # bytes, of a file
    assert run(full + RUN) == (36.0, False)
    assert run.said.count("compiled kernels cannot be stored in") == 1
    assert "File too large" in run.said
    assert not [
        path
        for path in (tmp_path / "cache").rglob("*")
        if path.is_file() and path.stat().st_size and "counts" not in path.parts
    ]


def test_without_a_home_the_folder_must_be_named(monkeypatch):
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pellucid.jit.kernel_folder.Path.home", lambda: (_ for _ in ()).throw(RuntimeError))
    with pytest.raises(UsageError, match="no home folder for compiled kernels: set the environment"):
        cache_folder()


DRIVER = """
import json
import numpy as np
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_for

@kernel()
def other(x):
    x[0] = 0.0

@kernel(inner=True)
def _part(s, x):
    x[s] += 2.0 * s

@kernel()
def add(n, x):
    parallel_for(_part, n, x)

x = np.zeros(10)
# compiled first
add(10, x)
print(json.dumps([float(x.sum()), sum(add.stats.cache_hits.values()), sum(add.stats.cache_misses.values())]))
"""


def test_a_driver_comes_back_with_the_kernel_of_its_chunks(run, tmp_path):
    assert run(DRIVER) == (90.0, False)
    assert run(DRIVER) == (90.0, True)
    assert run(DRIVER.replace("2.0 * s", "3.0 * s")) == (135.0, False)


def test_a_driver_without_the_kernel_of_its_chunks_is_compiled_anew(run, tmp_path):
    """The kernel compiled in its place has a name of its own, to which the driver of before does not refer."""
    assert run(DRIVER) == (90.0, False)
    (part,) = (tmp_path / "cache").rglob("_part*.nbc")
    part.unlink()
    assert run(DRIVER.replace("# compiled first", "other(x); other(x[::2]); other(x.copy()[1:])")) == (90.0, False)
    assert run(DRIVER) == (90.0, True)
