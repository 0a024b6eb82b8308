"""A run warns when parts of one body of material points approach each other, and only then."""

import warnings

import numpy as np
import pytest
from forked_blocks import forked_block
from small_cases import SOLID, box, case, to_the_end

from pellucid.bodies.material_points.surface import SurfaceParts


def ring(**more):
    shape = {"shell": {"centre": (2, 2, 0.05), "inner_radius": 0.6, "outer_radius": 0.8}}
    return {"name": "ring", "shape": shape, "material": SOLID, "points_per_cell": (2, 2, 1)} | more


def walls(speed):
    """Two walls at 2 ± 0.8 m that approach each other."""
    low = {"name": "low", "point": (0, 1.2, 0), "normal": (0, 1, 0), "velocity": (0, speed, 0)}
    return [low, {"name": "high", "point": (0, 2.8, 0), "normal": (0, -1, 0), "velocity": (0, -speed, 0)}]


def approaches(*bodies, counts=(40, 40, 1), **more):
    """Warnings of a run about parts that approach each other."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        to_the_end(case(*bodies, counts=counts, cell=0.1, **more))
    return [text for text in (str(each.message) for each in told) if "approach each other" in text]


def test_a_ring_that_is_pressed_flat_is_warned_of_once():
    (text,) = approaches(ring(), wall=walls(0.3), end=2.4)
    assert "parts of the surface of body ring approach each other: at (" in text
    place = [float(value) for value in text.split("at (")[1].split(")")[0].split(", ")]
    np.testing.assert_allclose(place[:2], (2, 2), atol=0.6)
    assert "cells (0.1" in text
    before = float(text.split("remain of a gap of ")[1].split(" cells; below 1.5 cells they stick to each other")[0])
    chord = 20.0 * np.sqrt(0.6**2 - (place[0] - 2.0) ** 2)  # of the hole, where the gap is now; material there came from within
    assert round(chord) <= before <= 12.0
    assert '[[contact]] `between = ["ring"]`' in text


def test_a_ring_that_is_pressed_to_half_of_its_height_is_not():
    assert approaches(ring(), wall=walls(0.3), end=1.2) == []


def test_a_ring_that_rebounds_is_not():
    assert approaches(ring(velocity=(0, -0.15, 0)), wall=walls(0.0), end=2.0) == []


def test_a_solid_that_is_pressed_flat_is_not():
    disc = {"shell": {"centre": (2, 2, 0.05), "inner_radius": 0.01, "outer_radius": 0.8}}
    assert approaches(ring(shape=disc), wall=walls(0.2), end=1.6) == []
    assert approaches(box((1.5, 1.2, 0), (2.5, 2.8, 0.1), per_cell=(2, 2, 1)), wall=walls(0.2), end=1.6) == []


def test_a_slit_that_closes_is_warned_of_before_its_sides_meet(tmp_path):
    forked_block(tmp_path / "fork.obj", (0.2, 0.1, 0.2), (1.2, 0.3, 0.8), 0.35, 0.8)
    shape = {"inside": {"surface": {"file": {"path": str(tmp_path / "fork.obj"), "closed": True}}}}
    above = {"name": "press", "point": (0, 0, 1.0), "normal": (0, 0, -1), "velocity": (0, 0, -0.2)}
    below = {"name": "table", "point": (0, 0, 0.2), "normal": (0, 0, 1)}
    fork = {"name": "fork", "shape": shape, "material": SOLID}
    (text,) = approaches(fork, counts=(17, 5, 14), wall=[above, below], end=1.0)
    assert 0.5 < float(text.split(") m ")[1].split(" cells")[0]) < 1.5
    assert "remain of a gap of 3.5 cells;" in text


def parts(periodic=()):
    """A ring of two arms about a gap of four cells, and the places of its points."""
    model = case(ring(), counts=(40, 40, 1), cell=0.1, periodic=periodic)
    begun = model.body[0].seeded(model.grid).position
    return SurfaceParts(model.body[0], model.grid, begun), begun


def nothing(places, distance):
    return np.zeros(len(places), bool)


def moved(surface, position):
    return surface.has_deformed(position[surface.hosts])


def test_a_rigid_motion_is_no_deformation():
    surface, begun = parts()
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    assert not moved(surface, (begun - 2.0) @ turn + (1.7, 2.2, 2.0))
    assert surface.find_closing_gap((begun - 2.0) @ turn + (1.7, 2.2, 2.0), nothing) is None


@pytest.mark.parametrize(("periodic", "shift"), [((), 0.0), (["y"], 1.5), (["y"], 2.1), (["y"], -2.0)])
def test_the_gap_is_that_of_the_surface_and_seams_do_not_matter(periodic, shift):
    """Pressed to a tenth of its height, the hole of the ring is 1.2 cells high and its wall 0.2 cells thick."""
    surface, begun = parts(periodic)
    pressed = begun.copy()
    pressed[:, 1] = 2.0 + 0.1 * (begun[:, 1] - 2.0) + shift
    for share in np.linspace(0.25, 1.0, 4):
        now = begun + share * (pressed - begun)
        if periodic:
            now[:, 1] %= 4.0
        assert moved(surface, now)
    gap = surface.find_closing_gap(now, nothing)
    x = gap.place[0] - 2.0
    height = 0.1 * 2.0 * np.sqrt(0.6**2 - x**2)
    assert gap.width == pytest.approx(height, abs=0.03), "of an ellipse at this place"
    assert gap.before == pytest.approx(10.0 * height, rel=0.2)
    assert surface.find_closing_gap(now, lambda places, distance: np.ones(len(places), bool)) is None
