"""Surfaces that cross, touch, or do neither."""

import time
import tracemalloc

import numpy as np
import pytest

from pellucid.geometry.meshes.crossing import BoundingTree, crossing, self_crossing
from pellucid.geometry.meshes.triangulation import Triangulation
from pellucid.geometry.surfaces.surface import Surface


def sheet(corner, first, second, points=(6, 7)):
    """Triangles of a rectangle."""
    table = {"rectangle": {"corner": corner, "first_edge": first, "second_edge": second, "points": points}}
    return Surface.model_validate(table).triangulate()


def ball(radius):
    """Triangles of a sphere about the origin."""
    return Surface.model_validate({"sphere": {"centre": (0, 0, 0), "radius": radius, "divisions": 5}}).triangulate()


FLAT = sheet((-1, -1, 0), (2, 0, 0), (0, 2, 0))


@pytest.mark.parametrize(
    "other",
    [
        sheet((-0.31, -0.5, -0.6), (0, 1, 0), (0, 0, 1.1)),  # upright, through it
        sheet((-0.03, -0.02, -0.01), (0.02, 0, 0), (0, 0, 0.02), (2, 2)),  # smaller than a triangle
        sheet((-0.31, -0.5, 0), (0, 1, 0), (0, 0, 1.1)),  # stands on it
        sheet((-0.43, -0.57, 0), (1, 0, 0), (0, 1, 0), (4, 3)),  # lies in it
        ball(0.7),
    ],
)
def test_surfaces_that_meet_are_found_with_a_place_on_both(other):
    for one, two in ((FLAT, other), (other, FLAT)):
        place = crossing(one, two)
        assert place is not None
        assert place[2] == pytest.approx(0.0, abs=1e-9)
        assert np.abs(place).max() <= 1.0


@pytest.mark.parametrize(
    "other",
    [
        sheet((-1, -1, 1e-3), (2, 0, 0), (0, 2, 0)),
        sheet((1.01, -1, -0.5), (0, 2, 0), (0, 0, 1)),
        sheet((0.5, 0.5, 1e-3), (0.3, 0, 0), (0, 0, 0.5)),
    ],
)
def test_surfaces_that_stay_apart_are_not(other):
    assert crossing(FLAT, other) is None
    assert crossing(other, FLAT) is None


def test_one_inside_another_is_no_crossing():
    assert crossing(ball(0.5), ball(0.7)) is None
    assert crossing(ball(0.7), ball(0.71)) is None


TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]


def rod(n, fan):
    """A rod of n long facets in halves, oblique in space; lids of triangles about the centre or about a vertex of the rim."""
    angle = 2.0 * np.pi * np.arange(n) / n
    ring = 0.1 * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    i, j, k = np.arange(n), (np.arange(n) + 1) % n, np.arange(1, n - 1)
    sides = [np.column_stack([i, j, n + j]), np.column_stack([i, n + j, n + i])]
    if fan == "centre":
        lids = [np.column_stack([j, i, np.full(n, 2 * n)]), np.column_stack([n + i, n + j, np.full(n, 2 * n + 1)])]
    else:
        lids = [np.column_stack([0 * k, k + 1, k]), np.column_stack([0 * k + n, n + k, n + k + 1])]
    ends = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)] if fan == "centre" else []
    places = np.concatenate([ring, ring + np.array([0.0, 0.0, 1.0]), np.array(ends).reshape(-1, 3)])
    return Triangulation(places @ TURN, np.concatenate(sides + lids))


@pytest.mark.parametrize("fan", ["centre", "rim"])
def test_crossings_of_many_long_facets_take_seconds_and_little_memory(fan):
    """Time and memory grow with the number of facets, not with its square: all pairs would be 2e8 rows."""
    surface = rod(3125, fan)
    tracemalloc.start()
    start = time.monotonic()
    assert self_crossing(surface) is None
    assert time.monotonic() - start < 20.0  # 1 s on one core of 2024
    assert tracemalloc.get_traced_memory()[1] < 300e6
    tracemalloc.stop()


def test_a_long_needle_through_the_side_of_a_rod_is_found():
    surface = rod(400, "centre")
    needle = np.array([(0.05, 0.0, 0.31), (0.15, 0.01, 0.3), (0.15, -0.01, 0.3)]) @ TURN
    n = len(surface.vertices)
    both = Triangulation(np.concatenate([surface.vertices, needle]), np.concatenate([surface.triangles, [(n, n + 1, n + 2)]]))
    place = self_crossing(both)
    assert place is not None
    assert np.linalg.norm((place @ TURN.T)[:2]) == pytest.approx(0.1, rel=1e-3)


def test_near_pairs_hold_all_that_meet():
    """Against all pairs: an edge and a triangle that meet are near, whatever their shapes."""
    dice = np.random.default_rng(7)
    stretch = dice.uniform(0.02, 3.0, (60, 1, 3))
    corners = dice.uniform(-1.0, 1.0, (60, 1, 3)) + stretch * dice.uniform(-0.5, 0.5, (60, 3, 3))
    start = dice.uniform(-1.0, 1.0, (200, 3))
    end = start + dice.uniform(-1.0, 1.0, (200, 3))
    numbers, ends = np.arange(180).reshape(60, 3), np.arange(1000, 1400).reshape(200, 2)
    found = set()
    for e, t in BoundingTree(corners, numbers, 1e-9).near(ends, start, end):
        found |= set(zip(e.tolist(), t.tolist(), strict=True))
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(u, v)
    met = 0
    for e in range(200):
        height = np.einsum("tj,tj->t", start[e] - corners[:, 0], normal)
        rise = normal @ (end[e] - start[e])
        at = -height / rise
        hit = start[e] + at[:, None] * (end[e] - start[e]) - corners[:, 0]
        weights = np.array([np.linalg.lstsq(np.column_stack([u[t], v[t]]), hit[t], rcond=None)[0] for t in range(60)])
        meets = (at > 0) & (at < 1) & (weights > 0).all(axis=1) & (weights.sum(axis=1) < 1)
        met += int(meets.sum())
        assert all((e, t) in found for t in np.flatnonzero(meets).tolist())
    assert met > 50
    assert len(found) < 0.5 * 200 * 60


def test_layers_on_each_other_do_not_cross():
    flat = sheet((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    n = len(flat.vertices)
    other = np.concatenate([flat.triangles, n + flat.triangles[:, ::-1]])
    both = Triangulation(np.concatenate([flat.vertices, flat.vertices]), other)
    assert self_crossing(both, in_plane=False) is None
    folded = both._replace(vertices=both.vertices + np.concatenate([np.zeros((n, 3)), np.tile([0.05, 0.03, 0.0], (n, 1))]))
    assert self_crossing(folded) is not None
    assert self_crossing(folded, in_plane=False) is None
