"""Which support prescribes the velocity of a node, where several constrain it."""

from itertools import permutations
from math import inf

import numpy as np
import pytest

from pellucid.parts.capabilities import NodalSupport
from pellucid.parts.support_precedence import find_owners

ALL = (True, True, True)
LID, SIDE, FLOOR, BACK = (1, 1), (0, 1), (1, 0), (2, 0)
ONE = np.ones(1, bool)


def support(face=None, velocity=(0.0, 0.0, 0.0), axes=ALL, until=inf):
    """On a single node."""
    return NodalSupport(ONE, axes, velocity, face, face=face, until=until)


def velocity_at_node(*supports, **more):
    """Of every order of the supports."""
    found = set()
    for order in permutations(supports):
        owner = find_owners(order, 1, **more)[0]
        found.add(tuple(None if row == 0 else order[row - 1].velocity[axis] for axis, row in enumerate(owner)))
    return found


def test_a_face_across_the_axis_counts_before_faces_along_it():
    assert velocity_at_node(support(LID, (1.0, 0.0, 0.5)), support(SIDE, (0.0, 2.0, 0.5))) == {(0.0, 0.0, 0.5)}


def test_of_faces_along_an_axis_the_slowest_counts():
    lids = [support(face, (0.0, 0.0, speed)) for face, speed in ((LID, -3.0), (SIDE, 2.0), (FLOOR, -1.0))]
    assert velocity_at_node(*lids) == {(0.0, 0.0, -1.0)}
    assert velocity_at_node(support(LID, (0.0, 0.0, 1.0)), support(SIDE, (0.0, 0.0, -1.0))) == {(0.0, 0.0, 1.0)}


def test_a_smooth_face_leaves_the_other_axes_to_others():
    smooth = support(SIDE, axes=(True, False, False))
    assert velocity_at_node(smooth, support(LID, (1.0, 0.0, 4.0))) == {(0.0, 0.0, 4.0)}
    assert velocity_at_node(smooth) == {(0.0, None, None)}


def test_a_region_counts_before_faces_but_moves_nothing_through_one():
    lid = support(None, (1.0, 0.0, 0.0))
    assert velocity_at_node(lid, support(FLOOR)) == {(1.0, 0.0, 0.0)}
    assert velocity_at_node(lid, support(SIDE), support(FLOOR)) == {(0.0, 0.0, 0.0)}


@pytest.mark.parametrize(("speed", "counts"), [(-1.0, -1.0), (1.0, 0.0)])
def test_nodes_of_a_body_may_be_moved_away_from_a_face(speed, counts):
    pull = support(None, (0.0, speed, 0.0))
    assert velocity_at_node(pull, support(LID), may_leave=True) == {(0.0, counts, 0.0)}


def test_of_regions_the_later_one_counts():
    regions = [support(None, (1.0, 0.0, 0.0)), support(None, (2.0, 0.0, 0.0))]
    assert find_owners(regions, 1).tolist() == [[2, 2, 2]]
    assert find_owners(regions, 1, gone={1}).tolist() == [[1, 1, 1]]


def test_of_supports_on_a_face_the_one_that_ends_first_counts():
    gate, wall = support(SIDE, (1.0, 0.0, 0.0), until=2.0), support(SIDE)
    assert velocity_at_node(gate, wall) == {(1.0, 0.0, 0.0)}
