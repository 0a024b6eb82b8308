"""Points that may touch are found through boxes and followed; feet gather and spread by the same shares."""

import numpy as np
import pytest

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.following import Following
from pellucid.contact.images import Feet, Images, describe

STANDS = (False, False)


class Plane(ContactSurface):
    """Points of a square lattice of a width of 0.1 m, with normals up or down."""

    def __init__(self, n, height, up=1.0):
        i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
        self.place = np.column_stack([0.1 * i.ravel(), 0.1 * j.ravel(), np.full(n * n, height)])
        self.area = np.tile([0.0, 0.0, 0.01 * up], (n * n, 1))
        self.velocity, self.slip = np.zeros((n * n, 3)), np.zeros((n * n, 3))
        self.reach = np.full(n * n, 0.25)

    def add_forces(self, force):
        raise NotImplementedError


def listed(following):
    asks, first, near = following.candidates
    return {int(p): near[first[e] : first[e + 1]].tolist() for e, p in enumerate(asks)}


def found(following, one, other):
    following.find(len(one.place), describe(one, []), describe(other, []), STANDS)
    return listed(following)


def test_all_points_within_sight_are_listed_in_order():
    one, other = Plane(6, 0.05, -1.0), Plane(9, 0.0)
    near = found(Following(other, 0.0), one, other)
    assert sorted(near) == list(range(36))
    for p, points in near.items():
        away = np.linalg.norm(other.place - one.place[p], axis=1)
        assert points == sorted(points)
        assert set(np.flatnonzero(away < np.sqrt(2.0) * 0.25)) <= set(points)


def test_points_far_above_are_left_out():
    other = Plane(9, 0.0)
    assert found(Following(other, 0.0), Plane(6, 0.3, -1.0), other) == {}
    assert found(Following(other, 0.25), Plane(6, 0.3, -1.0), other) != {}


def test_a_search_serves_until_surfaces_have_moved_by_the_margin():
    one, other = Plane(6, 0.2, -1.0), Plane(9, 0.0)
    following = Following(other, 0.0)
    found(following, one, other)
    before = following.candidates
    one.place = one.place - np.array((0.0, 0.0, 0.04))
    other.place = other.place + np.array((0.0, 0.0, 0.02))
    found(following, one, other)
    assert following.candidates is before, "together they moved by less than a quarter of the reach"
    one.place = one.place - np.array((0.0, 0.0, 0.01))
    assert sorted(found(following, one, other)) == list(range(36))
    assert following.candidates is not before


def test_feet_gather_and_spread_by_the_same_shares():
    rng = np.random.default_rng(3)
    feet = Feet(np.array([0, 2, 5]), np.array([1, 3, 0, 1, 2]), np.array([0.25, 0.75, 0.5, 0.2, 0.3]))
    values, force, into = rng.random((4, 3)), rng.random((2, 3)), np.zeros((4, 3))
    feet.spread(force, into)
    assert np.sum(into * values) == pytest.approx(np.sum(force * feet.gather(values)))
    assert into.sum(axis=0) == pytest.approx(force.sum(axis=0))
    assert feet.gather(values)[0] == pytest.approx(0.25 * values[1] + 0.75 * values[3])


def test_feet_gather_from_images_what_their_points_have_mirrored():
    values, mirror = np.random.default_rng(4).random((3, 3)), np.array([-1.0, 1.0, 1.0])
    feet, images = Feet(np.array([0, 2]), np.array([1, 3]), np.array([0.25, 0.75])), Images(np.array([2]), mirror[None])
    assert feet.gather(values, images)[0] == pytest.approx(0.25 * values[1] + 0.75 * mirror * values[2])
