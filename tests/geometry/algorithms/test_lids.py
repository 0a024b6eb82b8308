"""Lids over the rims of open surfaces."""

import numpy as np
import pytest

from pellucid.geometry.algorithms.enclosure import signed_volume
from pellucid.geometry.algorithms.lids import Lids
from pellucid.geometry.surfaces.icosphere import Icosphere
from pellucid.geometry.surfaces.surface import Surface


def test_a_closed_surface_has_none():
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=1).triangulate()
    lids = Lids(triangles)
    assert len(lids.edges) == 0
    assert lids.volume(vertices) == 0.0


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (3.0, -2.0, 5.0)])
def test_two_rims_get_a_lid_each(shift):
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=3).triangulate()
    places = vertices + shift
    # planes between the rings of nodes about z = ±1/2 would cut triangles: take away those that reach beyond
    open_ones = triangles[np.abs(vertices[:, 2])[triangles].max(axis=1) < 0.6]
    lids = Lids(open_ones)
    assert len(np.unique(lids._rim)) == 2
    flux = signed = lids.volume(places)
    a, b, c = places[open_ones.T]
    signed = flux + float(np.sum(a * np.cross(b, c)) / 6.0)
    slab = np.pi * 1.1 * (1.0 - 1.1**2 / 12.0)  # between the mean heights of the rims
    assert signed == pytest.approx(slab, rel=0.05)
    assert 0.0 < signed < signed_volume(vertices, triangles)


@pytest.mark.parametrize(("lower", "parts"), [((-2, -2, 0), 2), ((-2, 0, 0), 4), ((0, 0, 0), 8)])
def test_a_part_in_planes_of_symmetry_is_closed_by_these(lower, parts):
    """With the mean of its rim as the point in common a quarter had 68 % of its volume, an eighth 36 %."""
    ball = {"centre": [0, 0, 0], "radius": 1, "divisions": 16}
    whole = signed_volume(*Surface(sphere=ball).triangulate())
    places, triangles = Surface(sphere={**ball, "part": {"lower": lower, "upper": [2, 2, 2]}}).triangulate()
    shift = np.array([3.3, -2.1, 5.7])
    for moved in (places, places + shift):
        centre = Lids(triangles).centres(moved)[0] - (moved - places)[0]
        held = np.array(lower) == 0
        assert centre[held] == pytest.approx(0.0, abs=1e-12)
        # diagonals of squares that a plane cuts in two differ from those of the whole ball: 1e-4 of an eighth
        assert parts * signed_volume(*Lids(triangles).closing(moved, triangles)) == pytest.approx(whole, rel=2e-4)


def test_a_bent_rim_keeps_its_mean():
    places, triangles = Surface(disc={"centre": [0, 0, 0], "normal": [0, 0, 1], "radius": 1, "rings": 4}).triangulate()
    places[:, 2] += 0.1 * places[:, 0] * places[:, 1]
    lids = Lids(triangles)
    assert lids.centres(places)[0] == pytest.approx(places[np.unique(lids.edges)].mean(axis=0), abs=1e-12)
