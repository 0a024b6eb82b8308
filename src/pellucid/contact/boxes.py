"""Lattice of boxes that sorts points and triangles, so that a search visits only a few of them."""

from typing import NamedTuple

import numpy as np

from pellucid.jit import kernel, pointwise

MOST_BOXES = 8  # largest number of boxes per member, plus 1000


class Boxes(NamedTuple):
    """Members (points or triangles) sorted by the boxes of a lattice that they overlap."""

    lower: np.ndarray  # (3,) lower corner of the lattice [m]
    size: float  # edge of a box [m]
    counts: tuple[int, int, int]  # number of boxes along each axis
    first: np.ndarray  # (boxes + 1,) start of each box in `order`
    order: np.ndarray  # members, in ascending order within a box


def make_boxes(low: np.ndarray, high: np.ndarray, lower: np.ndarray, upper: np.ndarray, size: float) -> Boxes:
    """Return the members sorted by the boxes of a lattice between the corners `lower` and `upper` [m], shape (3,) each.

    Members outside the lattice are omitted. low, high: lower and upper corners of the bounding box of each member [m],
    shape (n, 3). size: smallest edge length of a box [m].
    """
    counts = np.floor((upper - lower) / size).astype(np.int64) + 1
    while counts.prod() > MOST_BOXES * len(low) + 1000:
        size *= 1.5
        counts = np.floor((upper - lower) / size).astype(np.int64) + 1
    shape = int(counts[0]), int(counts[1]), int(counts[2])
    first = np.zeros(int(counts.prod()) + 1, np.int64)
    _count(low, high, lower, size, shape, first)
    order = np.zeros(int(first[-1]), np.int64)
    _sort(low, high, lower, size, shape, first, order)
    return Boxes(lower, size, shape, first, order)


@kernel()
def _count(low, high, lower, size, counts, first):
    """Count the members in each box of a lattice; write the start of each box in the sorted list to `first`, shape (boxes +
    1,).

    low, high: corners of the bounding box of each member [m]. lower: lower corner of the lattice [m]. size: edge of a box [m].
    counts: number of boxes along each axis.
    """
    for t in range(len(low)):
        for i in range(_first(low[t, 0], lower[0], size), _last(high[t, 0], lower[0], size, counts[0])):
            for j in range(_first(low[t, 1], lower[1], size), _last(high[t, 1], lower[1], size, counts[1])):
                for k in range(_first(low[t, 2], lower[2], size), _last(high[t, 2], lower[2], size, counts[2])):
                    first[(i * counts[1] + j) * counts[2] + k + 1] += 1
    for b in range(1, len(first)):
        first[b] += first[b - 1]


@kernel()
def _sort(low, high, lower, size, counts, first, order):
    """Write the indices of the members (points or triangles) to `order`, sorted by box.

    first: start of each box in `order`, as `_count` computes it; used as a counter and restored at the end. low, high,
    lower, size, counts: see `_count`.
    """
    for t in range(len(low) - 1, -1, -1):
        for i in range(_first(low[t, 0], lower[0], size), _last(high[t, 0], lower[0], size, counts[0])):
            for j in range(_first(low[t, 1], lower[1], size), _last(high[t, 1], lower[1], size, counts[1])):
                for k in range(_first(low[t, 2], lower[2], size), _last(high[t, 2], lower[2], size, counts[2])):
                    b = (i * counts[1] + j) * counts[2] + k
                    first[b + 1] -= 1
                    order[first[b + 1]] = t
    for b in range(len(first) - 1):
        first[b] = first[b + 1]
    first[len(first) - 1] = len(order)


@pointwise
def _first(x, lower, size):
    return max(0, int(np.floor((x - lower) / size)))


@pointwise
def _last(x, lower, size, count):
    return min(count, int(np.floor((x - lower) / size)) + 1)
