"""Compiled kernels: their cache, their pointwise functions, and the same in plain Python."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest

from pellucid import jit
from pellucid.errors import UsageError
from pellucid.jit import MissingFunction, generic, kernel, point_function, pointwise, set_threads

TESTS = Path(__file__).parent.parent


class Circle(NamedTuple):
    radius: float


class Square(NamedTuple):
    side: float
    factor: float = 1.0


class Hexagon(NamedTuple):
    side: float


@generic
def area(shape, scale):
    """Area of a shape."""


@point_function(area, Circle)
def _circle(shape, scale):
    return scale * _squared(3.0 * shape.radius)


@point_function(area, Square)
def _square(shape, scale):
    return scale * shape.factor * _squared(shape.side)


@pointwise
def _squared(x):
    return x * x


@kernel()
def total(shape, n):
    result = 0.0
    for i in range(n):
        result += area(shape, 1.0 + i)
    return result


@pytest.mark.parametrize(("shape", "expected"), [(Circle(1.0), 9.0), (Square(2.0), 4.0), (Square(2.0, 0.5), 2.0)])
def test_the_type_of_the_first_argument_chooses(shape, expected):
    assert area(shape, 1.0) == expected
    assert total(shape, 3) == 6.0 * expected


def test_a_type_without_implementation_is_an_error():
    with pytest.raises(MissingFunction, match=r"Hexagon has no `area`: register one with `@point_function\(area, Hexagon\)`"):
        area(Hexagon(1.0), 1.0)
    with pytest.raises(numba.TypingError, match="area"):
        total(Hexagon(1.0), 1)


def test_where_the_cache_lies(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "own"))
    assert jit.cache_folder() == tmp_path / "own" / "kernels"
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert jit.cache_folder() == tmp_path / "xdg" / "pellucid" / "kernels"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert jit.cache_folder() == Path.home() / ".cache" / "pellucid" / "kernels"


def test_inner_kernels_are_called_by_kernels_alone():
    @kernel(inner=True)
    def twice(x):
        return 2.0 * x

    @kernel()
    def four_times(x):
        return twice(twice(x))

    assert four_times(1.5) == 6.0
    with pytest.raises(TypeError, match="twice is an inner kernel"):
        twice(1.5)


def test_kernels_leave_numba_s_settings_alone():
    before = numba.config.CACHE_DIR

    @kernel()
    def nothing():
        return 0

    assert nothing() == 0
    assert before == numba.config.CACHE_DIR


def test_threads_are_within_what_there_is():
    most = numba.config.NUMBA_NUM_THREADS
    now = numba.get_num_threads()
    try:
        assert set_threads(1) == 1
        assert set_threads(None) == most
        with pytest.raises(UsageError, match="threads = 10000 must be a whole number from 1 to"):
            set_threads(10_000)
    finally:
        numba.set_num_threads(now)


SMALL = """
import json
import numpy as np
from small_cases import GAS, RATE_SOLID, SLIP, SOLID, advance, box, simulation

gas = GAS | {"viscosity": 0.1, "artificial_viscosity": {"quadratic": 2.0, "linear": 1.0}}
frames = []
plane = {"counts": (5, 3, 1), "functions": "quadratic-bspline"}
space = {"counts": (5, 3, 2), "scheme": "usf", "transfer": "apic"}
for settings in (plane, space):
    bodies = [
        box((0, 0, 0), (2, 2, 1), gas, (2, 2, 1), name="gas", velocity=(0.5, 0, 0)),
        box((2, 0, 0), (3, 2, 1), SOLID, (2, 2, 1), name="solid", angular_velocity=(0, 0, 0.2)),
        box((3, 0, 0), (4, 2, 1), RATE_SOLID, (2, 2, 1), name="rate", velocity=(0, 0.1, 0)),
    ]
    sim = simulation(*bodies, support=SLIP, end=10.0, gravity=(0, -0.1, 0), **settings)
    advance(sim, 6)
    for body in sim.bodies:
        frame = body.frame()
        frames += [frame[name].ravel().tolist() for name in ("position", "velocity", "stress", "density")]
    frames.append(list(sim.budget.energies().values()))
print(json.dumps(frames))
"""


def small(**settings):
    """Fields of a small run with gas, two solids and walls, in a process of its own."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path])} | settings
    done = subprocess.run([sys.executable, "-c", SMALL], env=environment, capture_output=True, text=True, timeout=250)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_without_compiler_the_physics_is_the_same():
    """NUMBA_DISABLE_JIT=1, to debug kernels and count their lines."""
    compiled, plain = small(), small(NUMBA_DISABLE_JIT="1")
    for one, other in zip(compiled, plain, strict=True):
        # fused multiplications round differently; relative to the largest number of the field, over six steps
        assert np.abs(np.array(one) - other).max() <= 1e-12 * np.abs(one).max()
