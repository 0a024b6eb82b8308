"""What is chosen, filled and refused at the start of a run on a periodic grid: bodies and regions reach across the seams."""

import numpy as np
import pytest
from small_cases import GAS, SOLID, box

from pellucid.case import Case
from pellucid.conditions.constrained_nodes import constrain_nodes
from pellucid.errors import CaseError
from pellucid.grid.lattice import Grid
from pellucid.set_up.first_look import stand
from pellucid.set_up.overlap import refuse_overlaps


def case(*bodies, **more):
    grid = {"lower": (0, 0, 0), "upper": (8, 8, 0), "cell": 1.0, "functions": "trilinear", "periodic": ["x"]}
    return Case.model_validate({"title": "a test", "grid": grid, "time": {"end": 1.0}, "body": bodies} | more)


def drop(centre, radius=1.5, **more):
    return {"name": "drop", "shape": {"sphere": {"centre": centre, "radius": radius}}, "material": GAS} | more


def seeds(whole, name):
    model = next(body for body in whole.body if body.name == name)
    return model.with_others(whole.body).seeded(whole.grid)


@pytest.mark.parametrize("x", [4.0, 0.5, 7.5])
def test_a_fluid_leaves_out_what_lies_across_the_seam(x):
    whole = case(box((0, 0, 0), (8, 8, 0), GAS, 9, "gas", outside=["drop"]), drop((x, 4, 0), points_per_cell=9))
    gas, inner = seeds(whole, "gas"), seeds(whole, "drop")
    assert gas.volume.sum() + inner.volume.sum() == pytest.approx(64.0, rel=1e-3)
    way = gas.position - [x, 4.0, 0.0]
    way[:, 0] -= 8.0 * np.rint(way[:, 0] / 8.0)
    assert np.linalg.norm(way[:, :2], axis=1).min() > 1.5 - 0.25
    assert gas.n + inner.n == pytest.approx(576, abs=12)


def test_a_shape_across_the_seam_is_whole():
    whole, moved = (seeds(case(drop((x, 4, 0))), "drop") for x in (4.0, 7.0))
    assert moved.position - [3.0, 0.0, 0.0] == pytest.approx(whole.position, abs=1e-12)


@pytest.mark.parametrize(
    ("lower", "upper", "chosen"), [(7, 9, [0, 1, 7]), (-1, 0, [0, 7]), (2, 3, [2, 3]), (4, 8, [0, 4, 5, 6, 7])]
)
def test_a_support_holds_nodes_across_the_seam(lower, upper, chosen):
    region = {"box": {"lower": (lower, 3, 0), "upper": (upper, 3, 0)}}
    whole = case(box((0, 0, 0), (8, 8, 0), GAS, name="gas"), support=[{"where": region}])
    grid = Grid(whole.grid)
    constrain_nodes(grid, whole.support)
    index, position = grid.where()
    assert position[grid.nodes.constrained[index, 0] == 1][:, 0].tolist() == chosen


def test_bodies_that_overlap_across_the_seam_are_refused():
    solid = {"material": SOLID, "points_per_cell": 9}
    whole = case(drop((7.5, 4, 0), **solid), drop((0.5, 4, 0), name="other", field="other", **solid))
    with pytest.raises(CaseError, match=r"points of this body start inside body other"):
        refuse_overlaps(whole.body, stand(whole), whole.grid)
    apart = case(drop((7.5, 4, 0), 1.0, **solid), drop((2.5, 4, 0), 1.0, name="other", field="other", **solid))
    refuse_overlaps(apart.body, stand(apart), apart.grid)


def test_membranes_that_cross_across_the_seam_are_refused():
    law = {"kind": "linear-membrane", "density": 1.0, "young_modulus": 1.0, "poisson_ratio": 0.3}
    net = {"kind": "membrane-elements", "thickness": 0.01, "material": law}
    ends = [{"start": (x, 4, 0), "end": (x, 4, 1), "radius": 0.7, "points": (12, 2)} for x in (0.6, 7.6)]
    one, two = (net | {"name": name, "field": name, "surface": {"tube": end}} for name, end in zip("ab", ends, strict=True))
    whole = case(one, two)
    with pytest.raises(CaseError, match="intersects or touches body b"):
        refuse_overlaps(whole.body, stand(whole), whole.grid)


def test_a_layer_that_goes_on_has_no_surface_at_the_seam():
    whole = case(box((0, 2, 0), (8, 4, 0), SOLID, name="layer"))
    place, area = whole.body[0].boundary(whole.grid, hard=False)
    assert area.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.abs(area[:, 0]).max() == 0.0
    assert np.abs(area[:, 1]).sum() == pytest.approx(16.0)
    assert set(place[:, 1].round(9)) == {2.0, 4.0}
