"""Members by boxes: each box has those that see it, in ascending order."""

import numpy as np
import pytest

from pellucid.contact.boxes import MOST_BOXES, make_boxes


@pytest.mark.parametrize("wide", [0.0, 0.3])
def test_a_box_has_the_members_that_see_it(wide):
    generator = np.random.default_rng(3)
    low = generator.uniform(-1.5, 1.5, (200, 3))
    high = low + wide * generator.uniform(size=(200, 3))
    lower, upper, size = np.full(3, -1.0), np.array([1.0, 1.0, 0.9]), 0.25
    boxes = make_boxes(low, high, lower, upper, size)
    assert boxes.size == size
    assert boxes.counts == (9, 9, 8)
    corner = lower + size * np.stack(np.meshgrid(*map(np.arange, boxes.counts), indexing="ij"), axis=-1).reshape(-1, 3)
    for b, begin in enumerate(corner):
        # a point on a face of two boxes belongs to the upper one
        seen = (np.floor((low - begin) / size) <= 0).all(axis=1) & (np.floor((high - begin) / size) >= 0).all(axis=1)
        assert np.array_equal(boxes.order[boxes.first[b] : boxes.first[b + 1]], np.flatnonzero(seen))


def test_boxes_grow_where_they_would_be_too_many():
    place = np.array([[0.0, 0.0, 0.0], [100.0, 100.0, 100.0]])
    boxes = make_boxes(place, place, place[0], place[1], 0.1)
    assert np.prod(boxes.counts) <= MOST_BOXES * len(place) + 1000
    assert boxes.order.tolist() == [0, 1]
