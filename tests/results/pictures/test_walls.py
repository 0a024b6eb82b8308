"""Walls in pictures: their outlines in a box, and from which side they are shown."""

import numpy as np
import pytest

from pellucid.results.pictures.surroundings import Mirror, clipped, fan_of, meshes_of_walls, polygon_of, with_mirrored
from pellucid.results.storage.run_folder import StoredWall

LOW, HIGH = np.zeros(3), np.array([2.0, 1.0, 1.0])
DIAGONAL = np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)


def wall(point=(0.5, 0, 0.5), normal=DIAGONAL, velocity=(0, 0, 0)):
    return StoredWall("wall 1", np.array(point, float), np.array(normal, float), np.array(velocity, float))


def area(polygon):
    corners = polygon[fan_of(len(polygon))]
    return 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)


def test_a_part_of_a_square():
    square = np.array([(0.0, 0.0), (1, 0), (1, 1), (0, 1)])
    assert clipped(square, np.array([1.0, 0.0]), 0.25) == pytest.approx(np.array([(0, 0), (0.25, 0), (0.25, 1), (0, 1)]))
    assert len(clipped(square, np.array([1.0, 0.0]), -0.25)) == 0
    assert np.array_equal(clipped(square, np.array([1.0, 0.0]), 2.0), square)


def test_the_outline_of_a_wall_in_a_box():
    polygon = polygon_of(wall(), 0.0, LOW, HIGH)
    assert polygon @ DIAGONAL == pytest.approx(np.sqrt(0.5))
    assert area(polygon) == pytest.approx(np.sqrt(2.0) * DIAGONAL)  # from (1, y, 0) to (0, y, 1), in the sense of the normal
    later = polygon_of(wall(velocity=(0.5, 3.0, 0.0)), 1.0, LOW, HIGH)
    assert later @ DIAGONAL == pytest.approx(1.5 * np.sqrt(0.5))
    assert len(polygon_of(wall(velocity=(9, 0, 0)), 1.0, LOW, HIGH)) == 0


def test_a_wall_is_shown_from_the_side_of_the_bodies():
    up = np.array([0.0, 0.0, 1.0])
    assert len(meshes_of_walls([wall()], 0.0, (LOW, HIGH), up)) == 1
    assert meshes_of_walls([wall()], 0.0, (LOW, HIGH), -up) == []


def test_images_of_walls():
    one, image = with_mirrored([wall(velocity=(1, 0, 2))], (Mirror(0, 2.0),))
    assert image.point == pytest.approx((3.5, 0, 0.5))
    assert image.normal == pytest.approx(DIAGONAL * (-1, 1, 1))
    assert image.velocity == pytest.approx((-1, 0, 2))
    assert image.level(1.0) == pytest.approx(one.level(1.0) - 2.0 * 2.0 * DIAGONAL[0])
