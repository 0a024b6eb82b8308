"""What an overlap exerts: the overlap of the start, which exerts nothing."""

import numpy as np
import pytest

from pellucid.contact.overlap import OUT, StartOverlap


def test_contact_acts_later_by_the_largest_depth_of_the_start():
    start = StartOverlap(1.0)
    assert start.reduce(np.array([0.3, 0.1, -0.2])) == pytest.approx([0.0, -0.2, -0.5])
    assert start.depth == 0.3
    assert start.reduce(np.array([0.5, 0.3, 0.0])) == pytest.approx([0.2, 0.0, -0.3]), "as if the bodies were thinner"


def test_what_came_apart_presses_wholly():
    start, start_of_all = StartOverlap(1.0), np.array([0.3, 0.1])
    start.reduce(start_of_all)
    for _ in range(OUT):
        assert start.reduce(np.array([0.2, 0.1])).max() <= 0.0, "nothing presses on the way"
    assert start.reduce(start_of_all) == pytest.approx([0.1, -0.1]), "and what came out presses"
    for _ in range(OUT):
        start.reduce(np.zeros(0))
    assert start.reduce(start_of_all) is start_of_all


def test_points_that_are_not_found_for_some_steps_are_not_thrown_off():
    start = StartOverlap(1.0)
    start.reduce(np.array([0.3, 0.1]))
    for _ in range(OUT - 1):
        start.reduce(np.zeros(0))
    assert start.reduce(np.array([0.3, 0.1])) == pytest.approx([0.0, -0.2])


def test_rounding_and_what_begins_apart_change_no_bit():
    for first in ([1e-12, -1.0], [-1e-3, -1.0], []):
        start = StartOverlap(1.0)
        start.reduce(np.array(first))
        depth = np.array([0.1, 0.2])
        assert start.reduce(depth) is depth


def test_a_checkpoint_keeps_it_and_a_run_that_goes_on_has_none():
    start, again, later = StartOverlap(1.0), StartOverlap(1.0), StartOverlap(1.0)
    start.reduce(np.array([0.3]))
    again.restore(start.state_numbers())
    later.skip()
    assert again.reduce(np.array([0.4])) == pytest.approx([0.1])
    assert later.reduce(np.array([0.4])) == pytest.approx([0.4])
