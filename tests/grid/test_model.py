"""The grid as the user describes it: the thickness of plane problems."""

import pytest

from pellucid.case import loads
from pellucid.errors import CaseError
from pellucid.grid.model import GridCase

PLANE = {"lower": (0, 0, 0), "upper": (4, 3, 0), "cell": 1.0}


def test_a_plane_grid_has_a_thickness_of_its_own():
    assert GridCase(**PLANE).slice_thickness() == 1.0
    assert GridCase(**PLANE, thickness="2 mm").slice_thickness() == 0.002
    assert GridCase(**PLANE | {"upper": (4, 0, 1)}, thickness=0.5).slice_thickness() == 0.5


@pytest.mark.parametrize(
    ("upper", "thickness", "words"),
    [
        ((4, 3, 2), 0.5, r"thickness = 0.5 m applies to axes that are one cell thick, but this grid has none; remove it"),
        ((4, 3, 0), 0.0, "greater than 0"),
        ((4, 3, 0), "2 kg", "kg"),
    ],
)
def test_thicknesses_that_make_no_sense(upper, thickness, words):
    with pytest.raises(ValueError, match=words):
        GridCase(**PLANE | {"upper": upper}, thickness=thickness)


def test_an_error_of_the_thickness_says_where_it_stands():
    text = """schema = 1
title = "a cube"
[grid]
lower = [0, 0, 0]
upper = [1, 1, 1]
cell = 0.25
thickness = 0.1
[time]
end = 1.0
[[body]]
name = "block"
shape = { box = { lower = [0, 0, 0], upper = [1, 1, 1] } }
material = { kind = "linear-elastic", density = 1, young_modulus = 1, poisson_ratio = 0 }
"""
    with pytest.raises(CaseError) as caught:
        loads(text)
    (problem,) = caught.value.problems
    assert problem.key == "grid"
    assert problem.line == 3


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"periodic": ["z"]}, "periodic lists z, but the grid is one cell thick along z; remove z from it"),
        ({"periodic": ["x", "x"]}, "periodic lists the axis x twice; remove one"),
        ({"periodic": ["y"]}, "periodic along y with 3 cells; at least 4 are needed: use a smaller grid.cell"),
        ({"periodic": ["x"], "upper": (4.5, 3, 0)}, "4.5 cells of 1 m; it must be a whole number of cells"),
        ({"periodic": ["w"]}, "'x', 'y' or 'z'"),
    ],
)
def test_periods_that_cannot_be(given, words):
    with pytest.raises(ValueError, match=words):
        GridCase(**PLANE | given)


def test_a_period_is_the_length_of_the_grid():
    assert GridCase(**PLANE, periodic=["x"]).periods() == (4.0, 0.0, 0.0)


PERIODIC = """schema = 1
title = "a periodic channel"
[grid]
lower = [0, 0, 0]
upper = [2, 1, 0]
cell = 0.1
periodic = ["x"]
[time]
end = 1.0
"""
WATER = """[[body]]
name = "water"
shape = { box = { lower = [0, 0, 0], upper = [2, 1, 0] } }
material = { kind = "fluid", density = 1, eos = { kind = "tait", sound_speed = 10 } }
"""
BALL = """[[body]]
name = "ball"
field = "ball"
shape = { sphere = { centre = [CENTRE, 0.5, 0], radius = RADIUS } }
material = { kind = "neo-hookean", density = 1, young_modulus = 1e4, poisson_ratio = 0.3 }
"""
NET = """[[body]]
name = "net"
kind = "membrane-elements"
surface = { tube = { start = [1, 0.5, 0], end = [1, 0.5, 0.05], radius = 0.95, points = [90, 2] } }
thickness = 0.01
material = { kind = "linear-membrane", density = 1, young_modulus = 1, poisson_ratio = 0.3 }
"""


def ball(centre, radius):
    return BALL.replace("CENTRE", str(centre)).replace("RADIUS", str(radius))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (ball(1.0, 0.95), r"body.ball.shape.* 1.9 m of a period of 2 m: it would touch itself across the seam; at most 1.8 m"),
        (ball(2.3, 0.2), r"from 2.1 to 2.5 m, outside the periodic grid: 0 to 2 m"),
        (NET, r"body.net.surface.* it would touch itself across the seam; at most 1.8 m"),
        (WATER.replace("[2, 1, 0]", "[2.2, 1, 0]"), "2.2 m of a period of 2 m: it would touch itself"),
        (
            '[[support]]\nwhere = "x-lower"',
            "support.0.where.* the face x-lower is not a wall; points that cross it enter at x-upper",
        ),
        ('[[support]]\nwhere = "x-upper"\nfix = "normal"', "periodic along x: the face x-upper is not a wall"),
        ('[[outflow]]\nwhere = "x-upper"', "outflow.0.where.* the face x-upper is not a wall"),
        ('[[absorbing]]\nwhere = "x-lower"\nbody = "water"', "absorbing.0.where.* the face x-lower is not a wall"),
        ("[[wall]]\npoint = [1, 0, 0]\nnormal = [1, 1, 0]", "has the component 1 along x, along which the grid is periodic"),
        ('[[picture]]\nname = "p"\nmirror = ["x-lower"]', "picture.p.mirror.* the face x-lower is not a wall"),
    ],
)
def test_what_a_periodic_axis_does_not_let_pass(more, words):
    bodies = more if "[[body]]" in more else WATER + more
    with pytest.raises(CaseError, match=f"(?s){words}"):
        loads(PERIODIC + bodies)


def test_a_fluid_may_meet_itself_and_a_solid_may_go_on():
    loads(PERIODIC + WATER.replace("[2, 1, 0]", "[1.95, 1, 0]"))
    loads(PERIODIC + WATER.replace('kind = "fluid", density = 1, eos = { kind = "tait", sound_speed = 10 }', LAYER))
    loads(PERIODIC + ball(1.9, 0.4))


LAYER = 'kind = "neo-hookean", density = 1, young_modulus = 1e4, poisson_ratio = 0.3'
