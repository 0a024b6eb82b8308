"""Motions of a body as a whole that nothing prevents, and those on which loads do no work."""

import numpy as np
import pytest

from pellucid.bodies.own_nodes.twists import loose_twists, neutral_twists

PLACES = np.random.default_rng(1).uniform(-1.0, 1.0, (50, 3)) * [3.0, 2.0, 1.0] + 5.0
FREE = np.ones(PLACES.shape, bool)


def held(*nodes):
    free = FREE.copy()
    free[list(nodes)] = False
    return free


def distances(x):
    return np.linalg.norm(x[:, None] - x[None], axis=2)


@pytest.mark.parametrize(("nodes", "number"), [((), 6), ((0,), 3), ((0, 1), 1), ((0, 1, 2), 0)])
def test_held_nodes_leave_turns_about_them(nodes, number):
    twists = loose_twists(PLACES, held(*nodes))
    assert len(twists) == number
    for motion in twists.displacements(PLACES):
        assert abs(motion[list(nodes)]).max(initial=0.0) < 1e-7
        arms, moved = np.diff(PLACES, axis=0), np.diff(motion, axis=0)
        assert np.sum(arms * moved, axis=1) == pytest.approx(0.0, abs=1e-12), "distances stay"


def test_a_plane_of_symmetry_leaves_motions_along_it():
    free = FREE.copy()
    free[::2, 2] = False
    free[::2, :2] = True
    flat = PLACES.copy()
    flat[::2, 2] = 0.0
    assert len(loose_twists(flat, free)) == 3


def test_held_nodes_stay_in_a_motion_of_any_size():
    twists = loose_twists(PLACES, held(0, 1))
    there = twists.moved(np.array([2.0]), PLACES)
    assert there[:2] == pytest.approx(PLACES[:2], abs=1e-9)
    assert abs(there - PLACES).max() > 1.0
    assert distances(there) == pytest.approx(distances(PLACES), abs=1e-12)


@pytest.mark.parametrize("nodes", [(), (0,), (0, 1)])
def test_a_body_is_turned_back(nodes):
    twists = loose_twists(PLACES, held(*nodes))
    there = twists.moved(np.linspace(0.5, -0.4, len(twists)), PLACES)
    assert abs(there - PLACES).max() > 0.1
    assert twists.aligned(there, PLACES) == pytest.approx(PLACES, abs=1e-9)


def test_without_loads_every_motion_is_neutral():
    assert len(neutral_twists(loose_twists(PLACES, FREE), PLACES, np.zeros_like)) == 6


def test_two_opposite_loads_leave_the_turn_about_their_line():
    ends = PLACES[:, 0].argmin(), PLACES[:, 0].argmax()
    along = PLACES[ends[1]] - PLACES[ends[0]]
    force = np.zeros_like(PLACES)
    force[ends[1]], force[ends[0]] = along, -along
    neutral = neutral_twists(loose_twists(PLACES, FREE), PLACES, lambda x: force)
    assert len(neutral) == 4, "three shifts and the turn"
    turns = np.linalg.svd(neutral.values[:, 3:])
    assert turns[1][1:] == pytest.approx(0.0, abs=1e-6)
    assert abs(turns[2][0] @ along) == pytest.approx(np.linalg.norm(along), rel=1e-9)


def test_a_torque_is_not_neutral_and_forces_that_turn_with_the_body_are():
    force = np.zeros_like(PLACES)
    force[:2] = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]
    assert len(neutral_twists(loose_twists(PLACES, FREE), PLACES, lambda x: force)) < 5

    def pulled(x):  # along the lines between three pairs of nodes
        found = np.zeros_like(x)
        for one, other in ((0, 1), (2, 3), (4, 5)):
            found[one] += x[other] - x[one]
            found[other] -= x[other] - x[one]
        return found

    assert len(neutral_twists(loose_twists(PLACES, FREE), PLACES, pulled)) == 6


def test_motions_are_taken_out():
    rng = np.random.default_rng(2)
    twists = loose_twists(PLACES, FREE)
    strained = twists.without(rng.normal(size=PLACES.shape), PLACES)
    motions = twists.displacements(PLACES)
    mixed = strained + np.einsum("m,mni->ni", rng.normal(size=6), motions)
    assert twists.without(mixed, PLACES) == pytest.approx(strained, abs=1e-12)
    for motion in motions:
        assert abs(np.sum(motion * strained)) < 1e-12 * np.abs(strained).sum()
