"""Nodes at one place."""

import numpy as np

from pellucid.geometry.meshes.points import coincident


def ring(n):
    angle = 2.0 * np.pi * np.arange(n) / n
    first = np.arange(n)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1), np.stack([first, np.roll(first, -1)], axis=1)


def test_nodes_at_one_place_are_found_be_they_neighbours_or_not():
    places, sides = ring(40)
    assert coincident(places, sides) is None
    for other in (6, 20):
        near = places.copy()
        near[5] = places[other] + 1e-9
        assert coincident(near, sides) == (5, other)


def test_the_opposite_sides_of_a_flat_film_touch():
    places, sides = ring(41)
    assert coincident(places * [1.0, 1e-3], sides) is None
    assert coincident(np.concatenate([places, places[::-1] + 1e-9]), np.concatenate([sides, sides + 41])) == (0, 81)
