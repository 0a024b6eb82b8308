"""Lids over the rims of open surfaces."""

import numpy as np
import pytest

from pellucid.geometry.meshes.cells import corner_areas
from pellucid.geometry.meshes.enclosure import BENT, Lids, capped, rims_of, signed_volume, volume_with_lids
from pellucid.geometry.surfaces.surface import Surface
from pellucid.geometry.surfaces.triangles import Icosphere

SHIFT = np.array([3.3, -2.1, 5.7])
BALL = {"centre": [0, 0, 0], "radius": 1, "divisions": 16}
FACES = [f"{axis}-{side}" for axis in "xyz" for side in ("lower", "upper")]


def test_a_closed_surface_has_none():
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=1).triangulate()
    assert len(rims_of(triangles).edges) == 0
    assert volume_with_lids(vertices, triangles) == pytest.approx(signed_volume(vertices, triangles), rel=1e-14)


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (3.0, -2.0, 5.0)])
def test_two_rims_get_a_lid_each(shift):
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=3).triangulate()
    places = vertices + shift
    # planes between the rings of nodes about z = ±1/2 would cut triangles: take away those that reach beyond
    open_ones = triangles[np.abs(vertices[:, 2])[triangles].max(axis=1) < 0.6]
    assert len(np.unique(rims_of(open_ones).number)) == 2
    assert Lids(places, open_ones).bend < BENT
    found = volume_with_lids(places, open_ones)
    assert found == pytest.approx(signed_volume(*capped(places, open_ones)), rel=1e-12)
    slab = np.pi * 1.1 * (1.0 - 1.1**2 / 12.0)  # between the mean heights of the rims
    assert found == pytest.approx(slab, rel=0.05)
    assert 0.0 < found < signed_volume(vertices, triangles)


@pytest.mark.parametrize(("lower", "parts"), [((-2, -2, 0), 2), ((-2, 0, 0), 4), ((0, 0, 0), 8)])
def test_a_part_of_a_ball_in_planes_of_symmetry_is_closed_by_these(lower, parts):
    """With the mean of its rim as the point in common a quarter had 68 % of its volume, an eighth 36 %."""
    whole = signed_volume(*Surface(sphere=BALL).triangulate())
    places, triangles = Surface(sphere={**BALL, "part": {"lower": lower, "upper": [2, 2, 2]}}).triangulate()
    for moved in (places, places + SHIFT, 1e-6 * places):
        scale = np.ptp(moved[:, 2]) / np.ptp(places[:, 2])
        # diagonals of squares that a plane cuts in two differ from those of the whole ball: 1e-4 of an eighth
        assert parts * volume_with_lids(moved, triangles) == pytest.approx(whole * scale**3, rel=2e-4)
        assert Lids(moved, triangles).bend < BENT


@pytest.mark.parametrize("noise", [0.0, 1e-15])
@pytest.mark.parametrize("first", FACES)
@pytest.mark.parametrize("second", FACES)
def test_boxes_open_at_sides_and_corners(first, second, noise):
    """Edges of a box lie in the plane of what is open and in that of the face beside them."""
    for third in FACES:
        open_ones = sorted({first, second, third})
        if all(f"{axis}-{side}" in open_ones for axis in "xyz" for side in ("lower", "upper")):
            continue
        box = {"lower": [0, 0, 0], "upper": [1, 2, 3], "points": [4, 5, 6], "open": open_ones}
        places, triangles = Surface(box=box).triangulate()
        places = places + noise * np.random.default_rng(7).standard_normal(places.shape)
        assert volume_with_lids(places, triangles) == pytest.approx(6.0, rel=1e-9), open_ones


@pytest.mark.parametrize("lower", [(-1, -2, -2), (-1, 0, -2), (-1, 0, 0)])
def test_a_part_of_a_tube_between_planes_of_symmetry_is_closed_by_four(lower):
    n = 32
    tube = {"start": [-1, 0, 0], "end": [1, 0, 0], "radius": 1, "points": [n, 5]}
    places, triangles = Surface(tube=tube).triangulate()
    kept = triangles[(places[triangles] >= np.array(lower) - 1e-9).all(axis=(1, 2))]
    places = np.where(np.abs(places) < 1e-12, 0.0, places) + SHIFT
    share = 0.5 ** sum(edge == 0 for edge in lower)
    assert volume_with_lids(places, kept) == pytest.approx(share * n * np.sin(2 * np.pi / n), rel=1e-9)


def test_a_rim_that_leaves_its_planes_closes_as_they_move():
    """A pressure follows the volume of a body: it does not jump where nodes are not held."""
    places, triangles = Surface(sphere={**BALL, "part": {"lower": [-2, 0, 0], "upper": [2, 2, 2]}}).triangulate()
    lids = Lids(places, triangles)
    areas = corner_areas(places, triangles)
    start = lids.volume(places, areas)
    for size in (1e-9, 1e-6, 1e-3):
        moved = places + size * np.random.default_rng(3).standard_normal(places.shape)
        assert lids.volume(moved, areas) == pytest.approx(start, abs=3.0 * size)


def test_a_rim_that_is_bent_elsewhere_says_so():
    places, triangles = Surface(sphere={**BALL, "part": {"lower": [-2, 0, 0], "upper": [2, 2, 2]}}).triangulate()
    turn = np.array([[1, 0, 0], [0, np.cos(0.5), -np.sin(0.5)], [0, np.sin(0.5), np.cos(0.5)]])
    assert Lids(places @ turn.T, triangles).bend > BENT
    disc = Surface(disc={"centre": [0, 0, 0], "normal": [0, 0, 1], "radius": 1, "rings": 4}).triangulate()
    assert Lids(disc[0] @ turn.T, disc[1]).bend < 1e-12
