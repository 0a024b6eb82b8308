"""Meshes are not made where they would have more points than can be held; estimates are those of what is made."""

import time

import pytest
from pydantic import ValidationError

from pellucid.geometry.solid_meshes.box import BoxMesh, CylinderMesh
from pellucid.geometry.solid_meshes.fill import FillMesh
from pellucid.geometry.solid_meshes.heart import HeartMesh
from pellucid.geometry.surfaces.quadrilaterals import (
    BoxSurface,
    CushionSurface,
    CylinderSurface,
    Lid,
    Rectangle,
    SphereSurface,
    Tube,
)
from pellucid.geometry.surfaces.triangles import Disc, EllipsoidSurface, Icosphere

ZERO, ONE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
BOX = {"lower": ZERO, "upper": ONE}
# kind, its keys but for the one that makes it fine, that key, a moderate value, one that no machine can hold
SURFACES = [
    (Rectangle, {"corner": ZERO, "first_edge": (1, 0, 0), "second_edge": (0, 1, 0)}, "points", (40, 50), (20_000, 20_000)),
    (Tube, {"start": ZERO, "end": ONE, "radius": 1}, "points", (40, 50), (20_000, 20_000)),
    (Lid, {"box": BOX, "face": "z-upper"}, "points", (40, 50), (20_000, 20_000)),
    (Icosphere, {"centre": ZERO, "radius": 1}, "refinements", 4, None),
    (EllipsoidSurface, {"radii": (1, 2, 3)}, "refinements", 4, None),
    (Disc, {"centre": ZERO, "normal": ONE, "radius": 1}, "rings", 20, 1000),
    (SphereSurface, {"centre": ZERO, "radius": 1}, "divisions", 20, 2000),
    (SphereSurface, {"centre": ZERO, "radius": 1, "part": BOX}, "divisions", 20, 2000),
    (CylinderSurface, {"start": ZERO, "end": ONE, "radius": 1, "rings": 20}, "along", 30, 10**9),
    (BoxSurface, BOX, "points", (40, 50, 60), (10**9, 10**9, 10**9)),
    (CushionSurface, {"centre": ZERO, "sides": (1, 1), "height": 0.1}, "points", (40, 50), (20_000, 20_000)),
]
SOLIDS = [
    (BoxMesh, BOX, "cells", (10, 20, 10), (300, 300, 300)),
    (CylinderMesh, {"base": ZERO, "radius": 1, "height": 1, "along": 20}, "across", 20, 10**9),
    (FillMesh, {"shape": {"sphere": {"centre": ZERO, "radius": 1}}}, "size", 0.1, 1e-300),
    (HeartMesh, {}, "size", 0.0025, 1e-300),
]


@pytest.mark.parametrize(("kind", "keys", "key", "moderate", "_"), SURFACES + SOLIDS)
def test_the_estimate_is_that_of_the_mesh(kind, keys, key, moderate, _):
    model = kind(**keys, **{key: moderate})
    made = model.mesh()
    n = len(made.vertices if hasattr(made, "vertices") else made.nodes)
    share = n / model.expected_points()
    if "part" in keys:
        assert share < 1.0
    elif kind in (FillMesh, HeartMesh):  # of the box about them, with half a cube at each end
        assert 0.1 < share < 1.0
    else:
        assert share == pytest.approx(1.0, abs=0.15)  # rims, edges and the outer layer of corners


@pytest.mark.parametrize(("kind", "keys", "key", "_", "huge"), [case for case in SURFACES + SOLIDS if case[-1] is not None])
def test_too_many_points_are_refused_before_any_is_made(kind, keys, key, _, huge):
    start = time.perf_counter()
    with pytest.raises(
        ValidationError, match=r"the mesh would have about .* points, but at most 2e\+06 are allowed; make the mesh coarser"
    ):
        kind(**keys, **{key: huge})
    assert time.perf_counter() - start < 1.0
