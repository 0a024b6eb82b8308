"""Lids over the rims of open surfaces."""

import numpy as np
import pytest

from pellucid.geometry.algorithms.enclosure import signed_volume
from pellucid.geometry.algorithms.lids import Lids
from pellucid.geometry.surfaces.icosphere import Icosphere


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
