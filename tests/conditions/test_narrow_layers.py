"""Warning about layers of liquid between membranes and walls that are too thin for the grid."""

import pytest
from small_cases import box, simulation

from pellucid.conditions.narrow_layers import NarrowLayers

OIL = {"kind": "fluid", "density": 1.0, "viscosity": 1.0, "eos": {"kind": "tait", "sound_speed": 10.0}}
SKIN = {"kind": "skalak-membrane", "density": 1.0, "shear_modulus": 1.0, "area_coefficient": 1.0}
WALL = {"name": "block", "where": {"box": {"lower": [6, 0, 0], "upper": [9, 9, 9]}}}


def beside_walls(functions="quadratic-bspline", kind="membrane-elements", support=(WALL,), **more):
    """A drop with a skin of radius 1 around (3, 4) beside a block that begins at x = 6."""
    surface = {"tube": {"start": [3, 4, 0], "end": [3, 4, 1], "radius": 1.0, "points": [12, 2]}}
    skin = {"kind": kind, "name": "skin", "surface": surface, "thickness": 0.1, "material": SKIN}
    oil = box((0, 0, 0), (6, 8, 0), OIL | more, (2, 2, 1), "oil")
    sim = simulation(oil, skin, counts=(8, 8, 1), support=list(support), functions=functions)
    (part,) = sim.parts.of(NarrowLayers)
    return sim.bodies[1].arrays["position"], part


@pytest.mark.parametrize(("functions", "least"), [("quadratic-bspline", 0.5), ("gimp", 1.5), ("trilinear", 1.5)])
@pytest.mark.parametrize("kind", ["membrane-elements", "membrane-points"])
def test_a_membrane_that_comes_near_a_wall_is_named(kind, functions, least):
    position, part = beside_walls(functions, kind)
    position[:, 0] += 6.0 - least - position[:, 0].max() - 0.01
    assert not part.warnings(1.0)
    position[:, 0] += 0.02
    (text,) = part.warnings(1.0).values()
    assert text.startswith(
        f"the membrane skin has come within {least:g} cells of the support `block`. The grid is too coarse for"
    )
    assert ("quadratic-bspline" in text) == (least == 1.5)
    assert text.endswith("a smaller grid.cell.")


def test_walls_without_names_are_told_apart():
    left = {"where": {"box": {"lower": [-9, 0, 0], "upper": [0.5, 9, 9]}}}
    position, part = beside_walls(support=[left, {"where": WALL["where"]}])
    position[:, 0] += 0.9 - position[:, 0].min()
    assert list(part.warnings(1.0)) == ["layer between skin and the wall of a support"]


def test_a_convex_edge_of_a_wall_counts():
    edge = {"name": "edge", "where": {"box": {"lower": [6, 6, 0], "upper": [9, 9, 9]}}}
    position, part = beside_walls(support=[edge])
    position[0, :2] = 5.4, 5.6
    assert not part.warnings(1.0)
    position[0, :2] = 5.55, 5.6
    assert list(part.warnings(1.0)) == ["layer between skin and the support `edge`"]


def test_clamped_faces_are_walls():
    position, part = beside_walls(support=[{"where": "y-lower"}, {"where": "y-upper", "fix": "normal"}])
    position[0, 1], position[1, 1] = 0.6, 7.6  # liquid slips on the upper face
    assert not part.warnings(1.0)
    position[0, 1] = 0.4
    assert list(part.warnings(1.0)) == ["layer between skin and the face y-lower"]


def test_membranes_that_begin_at_a_wall_are_not_named():
    near = WALL | {"where": {"box": {"lower": [3.5, 0, 0], "upper": [9, 9, 9]}}}
    position, part = beside_walls(support=[near])
    assert not part.warnings(1.0)
    position[:, 0] += 1.0
    assert part.warnings(1.0)
