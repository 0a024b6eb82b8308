"""Points of surfaces beside the seams of periodic grids."""

from types import SimpleNamespace

import numpy as np
import pytest

from pellucid.contact.images import Plane, Seam, describe


def surface(place):
    n = len(place)
    area = np.tile([0.0, 2.0, 0.0], (n, 1))

    def find_directions(normal, size):
        normal[...], size[...] = area / 2.0, 2.0

    return SimpleNamespace(
        place=np.array(place),
        reach=np.full(n, 0.1),
        find_directions=find_directions,
    )


def test_points_that_crossed_a_seam_are_seen_within_the_box():
    found = describe(surface([(7.5, 0.3, 0.0), (-0.4, 0.2, 0.0)]), [], [Seam(0, 0.0, 1.0)])
    assert found.place == pytest.approx(np.array([(0.5, 0.3, 0.0), (0.6, 0.2, 0.0)]))
    assert len(found.images.point) == 0


def test_points_near_a_seam_have_images_beyond_it():
    found = describe(surface([(0.05, 0.5, 0.0), (0.93, 0.5, 0.0), (0.5, 0.5, 0.0)]), [], [Seam(0, 0.0, 1.0)])
    assert found.place[3:] == pytest.approx(np.array([(1.05, 0.5, 0.0), (-0.07, 0.5, 0.0)]))
    assert found.images.point.tolist() == [0, 1]
    force = np.arange(15.0).reshape(5, 3)
    assert found.fold(force).tolist() == (force[:3] + np.array([force[3], force[4], np.zeros(3)])).tolist()


def test_a_point_in_a_corner_has_an_image_across_each_seam_and_both():
    found = describe(surface([(0.05, 0.98, 0.0)]), [], [Seam(0, 0.0, 1.0), Seam(1, 0.0, 1.0)])
    assert sorted(map(tuple, found.place.round(12).tolist())) == [
        (0.05, -0.02, 0),
        (0.05, 0.98, 0),
        (1.05, -0.02, 0),
        (1.05, 0.98, 0),
    ]


def test_images_across_a_seam_have_mirror_images():
    found = describe(surface([(0.05, 0.02, 0.0)]), [Plane(1, 0.0)], [Seam(0, 0.0, 1.0)])
    assert sorted(map(tuple, found.place.round(12).tolist())) == [
        (0.05, -0.02, 0),
        (0.05, 0.02, 0),
        (1.05, -0.02, 0),
        (1.05, 0.02, 0),
    ]
    force = np.ones((4, 3))
    assert found.fold(force).tolist() == [[4.0, 0.0, 4.0]]
