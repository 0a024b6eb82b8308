"""Search for the points of two surfaces that may be in contact, with a lattice of boxes.

A search finds, for each point of one surface, the points of the other within the search radius plus a margin. The result is
reused until the surfaces may have approached by the margin. Lists are in ascending order and sums exclude points outside
the search radius, so that sums do not depend on the time of the search.
"""

from math import sqrt

import numpy as np

from pellucid.contact.boxes import make_boxes
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Described
from pellucid.contact.proximity import CLEAR, Candidates
from pellucid.jit import kernel
from pellucid.jit.memory import indices

SIGHT = sqrt(2.0)  # radius that contains all points with weight, in reaches
MARGIN = 0.25  # margin of the search, in reaches


class Following:
    """Search for contact candidates, i.e. points of one surface that are near points of another surface `other`. The result
    `candidates` lists, for each candidate, the points of `other` nearby; it is searched again only when the surfaces may
    have approached by a margin.

    width: distance of the surfaces below which they overlap [m].
    """

    def __init__(self, other: ContactSurface, width: float) -> None:
        reach = float(other.reach.max())
        self._margin, self._sight = MARGIN * reach, (SIGHT + MARGIN) * reach
        self._beside = width + CLEAR * reach + self._margin
        self._two_sided = other.two_sided
        self._places: list[np.ndarray] = []
        self._images = np.zeros(0, np.int64)
        self._moved = [0.0, 0.0]
        self._room = self._margin
        """Distance by which the surfaces may approach before a new search is required [m]."""
        self.candidates = Candidates(np.zeros(0, np.int64), np.zeros(1, np.int64), np.zeros(0, np.int64))
        self.n_near = 0
        """Total number of points in all candidate lists."""

    def find(self, n_points: int, one: Described, other: Described, stands: tuple[bool, bool]) -> bool:
        """Search again for candidates among the first `n_points` points of surface `one` if a search is due; return True if
        there are any candidates.

        one, other: points and images of both surfaces. stands: for each surface, True if it has not moved since the
        previous step.
        """
        described = one.place[:n_points], other.place
        if not self._places or not np.array_equal(other.images.point, self._images):
            self._search(*described, other)
        else:
            for side in range(2):
                if not stands[side]:  # points that crossed a seam count as moved by the period, so that a search follows
                    self._moved[side] = sqrt(_largest_square(described[side], self._places[side]))
            if sum(self._moved) > self._room:
                self._search(*described, other)
        return len(self.candidates.asks) > 0

    def _search(self, one: np.ndarray, other: np.ndarray, described: Described) -> None:
        self._places, self._images, self._moved = [one.copy(), other.copy()], described.images.point.copy(), [0.0, 0.0]
        sight, nothing = self._sight, np.zeros(0, np.int64)
        self.candidates, self.n_near = Candidates(nothing, np.zeros(1, np.int64), nothing), 0
        ends_of_one, ends_of_other = np.empty((2, 3)), np.empty((2, 3))
        _find_ends(one, ends_of_one)
        _find_ends(other, ends_of_other)
        lower = np.maximum(ends_of_one[0] - sight, ends_of_other[0])
        upper = np.minimum(ends_of_one[1] + sight, ends_of_other[1])
        self._room = self._margin + max(0.0, float((lower - upper).max()))
        if (lower > upper).any():
            return
        asks = np.flatnonzero(((one >= lower - sight) & (one <= upper + sight)).all(axis=1))
        boxes, n = make_boxes(other, other, lower, upper, sight), len(other)
        ends, how = np.zeros(len(asks) + 1, np.int64), (self._sight, self._beside, self._two_sided)
        _list_near(one, other, described.normal, asks, boxes, *how, ends, nothing)
        near = np.zeros(int(ends[-1]), np.int64)
        _list_near(one, other, described.normal, asks, boxes, *how, ends, near)
        counts = np.diff(ends)
        near += n * np.repeat(np.arange(len(asks)), counts)
        near.sort()
        near %= n
        having = counts > 0
        self.candidates = Candidates(asks[having], np.concatenate([[0], ends[1:][having]]), near)
        self.n_near = len(near)


@kernel()
def _find_ends(place, ends):
    """Write the lowest and the highest coordinates of the positions `place` [m], shape (n, 3), to `ends`, shape (2, 3)."""
    for d in range(3):
        ends[0, d], ends[1, d] = np.inf, -np.inf
    for p in range(len(place)):
        for d in range(3):
            ends[0, d], ends[1, d] = min(ends[0, d], place[p, d]), max(ends[1, d], place[p, d])


@kernel()
def _largest_square(place, before):
    """Return the square of the largest displacement of a point [m²] from the positions `before` to `place` [m], shape (n,
    3)."""
    most = 0.0
    for p in range(len(place)):
        square = 0.0
        for d in range(3):
            square += (place[p, d] - before[p, d]) ** 2
        if square > most:  # a maximum would wait for the last one
            most = square
    return most


@kernel()
def _list_near(one, other, normal, asks, boxes, sight, beside, two_sided, ends, near):
    """Compute the end index `ends` of the list of neighbours of each candidate; fill the lists if `near` is not empty.

    The list of a candidate contains the points of the other surface within the distance `sight` [m]. The list is empty if
    the candidate lies further than the distance `beside` [m] above the plane of its nearest point (for a two-sided surface,
    on either side). one, other: positions of the points of both surfaces [m]. normal: unit normals of the other surface.
    asks: indices of the candidates. boxes: the points of the other surface, sorted.
    """
    k, low, high = 0, indices(3), indices(3)
    for e in range(len(asks)):
        p, begun = asks[e], k
        if len(near) and ends[e + 1] == ends[e]:
            continue
        nearest, outside = np.inf, np.inf
        for d in range(3):
            i = int(np.floor((one[p, d] - boxes.lower[d]) / boxes.size))
            low[d], high[d] = max(0, i - 1), min(boxes.counts[d] - 1, i + 1)
        for i in range(low[0], high[0] + 1):
            for j in range(low[1], high[1] + 1):
                for m in range(low[2], high[2] + 1):
                    b = (i * boxes.counts[1] + j) * boxes.counts[2] + m
                    for r in range(boxes.first[b], boxes.first[b + 1]):
                        q, square, beyond = boxes.order[r], 0.0, 0.0
                        for d in range(3):
                            away = one[p, d] - other[q, d]
                            square += away * away
                            beyond += away * normal[q, d]
                        if square < nearest:
                            nearest, outside = square, beyond
                        if square <= sight * sight:
                            if len(near):
                                near[k] = q
                            k += 1
        if outside > beside or (two_sided and outside < -beside):
            k = begun
        ends[e + 1] = k
