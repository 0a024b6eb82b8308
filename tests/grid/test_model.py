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
        ((4, 3, 2), 0.5, r"thickness = 0.5 m is for axes that are one cell thick, and this grid has none; leave it out"),
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
