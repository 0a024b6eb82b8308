"""What a case may say of membrane elements."""

import numpy as np
import pytest
from elements import element_sheet
from pydantic import ValidationError
from small_cases import box, case

from pellucid.bodies.membrane_elements.model import MembraneElementsCase, _remoteness

BLOCK = box((-1, -1, -2), (1, 1, -1), field="solid")


def of(*others, **more):
    return case(element_sheet(**more), *others, counts=(16, 16, 16), cell=0.25, lower=(-2.0, -2.0, -2.0))


def test_quadrilaterals_where_the_surface_has_them_or_triangles():
    body = of(points=(5, 5)).body[0]
    assert isinstance(body, MembraneElementsCase)
    assert len(body.mesh().quads) == 16
    assert len(body.mesh().triangles) == 0
    assert len(of(points=(5, 5), elements="triangles").body[0].mesh().triangles) == 32


@pytest.mark.parametrize("elements", ["quads", "triangles"])
def test_elements_as_large_as_a_cell_fit_and_larger_ones_do_not(elements):
    """The same nodes whether squares are cut in two or not: the middle of a square is as far from them."""
    of(BLOCK, points=(5, 5), elements=elements)  # edges of a quarter, as the cells
    with pytest.raises(ValidationError, match="other bodies would pass through the membrane"):
        of(BLOCK, points=(4, 5), elements=elements)


@pytest.mark.parametrize("elements", ["quads", "triangles"])
def test_alone_a_membrane_meets_nothing_and_its_elements_may_be_of_any_size(elements):
    assert of(points=(3, 3), elements=elements).body[0].n_points(None) == 9


def test_how_far_triangles_reach_from_their_corners():
    """Right, equilateral, and obtuse with angles of 30° at its base, against the distances of many points in them."""
    third = np.sqrt(3.0)
    shapes = np.array([[(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 0, 0), (1, 0, 0), (0.5, 0.5 * third, 0)],
                       [(0, 0, 0), (1, 0, 0), (0.5, 0.5 / third, 0)], [(0, 0, 0), (1, 0, 0), (0.2, 0.3, 0)]])  # fmt: skip
    s, t = (axis.ravel() for axis in np.meshgrid(*[np.linspace(0.0, 1.0, 1001)] * 2))
    inside = s + t <= 1.0
    for corners, found in zip(shapes, _remoteness(shapes), strict=True):
        points = corners[0] + np.outer(s, corners[1] - corners[0]) + np.outer(t, corners[2] - corners[0])
        nearest = np.min([np.linalg.norm(points[inside] - corner, axis=1) for corner in corners], axis=0)
        assert found == pytest.approx(nearest.max(), rel=2e-3)


def test_damage_is_refused():
    damage = {"elastic_limit": 0.1, "stiffness_loss": 1.0, "rate": 1.0, "failure_strain": 0.2}
    with pytest.raises(ValidationError, match="no law of damage"):
        of(material=element_sheet()["material"] | {"damage": damage})


@pytest.mark.parametrize("hourglass", [{"kind": "springs"}, {"coefficient": -0.1}, {"coefficient": 0.6}])
def test_strange_hourglass_controls_are_refused(hourglass):
    with pytest.raises(ValidationError):
        of(hourglass=hourglass)
