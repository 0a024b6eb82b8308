"""Triangles and balls as fragments, pixel by pixel, and the canvas that keeps the nearest one of each pixel."""

from collections.abc import Iterator

import numpy as np

MOST = 2_000_000
"""Candidates that are looked at together."""

DEPTHS = 1 << 24  # steps of depth that a canvas tells apart
REACH = 1 << 15  # pixels of depth on either side of the origin: far beyond any picture
SHIFT = 32
INNER = 1e-9  # of a triangle: a pixel on an edge belongs to both neighbours

Fragments = Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]
"""Batches of x, y [pixels, whole numbers], depth [pixels] and number of the primitive."""


class Canvas:
    """The nearest fragment of every pixel: its depth, and which primitive of which part it belongs to."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.shape = shape
        self._key = np.full(shape[0] * shape[1], -1, np.int64)
        self._starts = [0]

    def begin_part(self, primitives: int) -> None:
        """What is added from now on belongs to a new part of so many primitives."""
        self._starts.append(self._starts[-1] + primitives)

    def add(self, x: np.ndarray, y: np.ndarray, depth: np.ndarray, primitive: np.ndarray) -> None:
        """Add fragments of the part begun last; of those at one depth the last primitive wins."""
        step = np.clip((depth + REACH) * (DEPTHS / (2 * REACH)), 0, DEPTHS - 1).astype(np.int64)
        np.maximum.at(self._key, y * self.shape[1] + x, step << SHIFT | (primitive + self._starts[-2]))

    def seen(self, part: int) -> tuple[np.ndarray, np.ndarray]:
        """The pixels that show a part, and the number of the primitive that each shows."""
        number = self._key & ((1 << SHIFT) - 1)
        index = np.flatnonzero((self._key >= 0) & (number >= self._starts[part]) & (number < self._starts[part + 1]))
        return index, number[index] - self._starts[part]

    def covered(self) -> np.ndarray:
        """Which pixels show anything, of the canvas's shape."""
        return (self._key >= 0).reshape(self.shape)

    def depth(self) -> np.ndarray:
        """Depth of the pixels, of the canvas's shape."""
        return ((self._key >> SHIFT) * (2 * REACH / DEPTHS) - REACH).reshape(self.shape)


def triangle_fragments(corners: np.ndarray, shape: tuple[int, int]) -> Fragments:
    """The fragments of triangles whose corners are given in pixels, shape (m, 3, 3)."""
    paper = corners[:, :, :2]
    limit = np.array([shape[1] - 1, shape[0] - 1])
    low = np.maximum(np.ceil(paper.min(axis=1)), 0).astype(np.int64)
    high = np.minimum(np.floor(paper.max(axis=1)), limit).astype(np.int64)
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    size = (high - low + 1).max(axis=1)
    size[((high < low).any(axis=1)) | (np.abs(area) < 1e-12)] = 0
    for which, side in _by_size(size):
        dx, dy = (low[which] - a[which, :2]).T
        (ux, uy, uz), (vx, vy, vz) = u[which].T / area[which], v[which].T / area[which]
        column, row = np.tile(np.arange(side), side), np.repeat(np.arange(side), side)
        # the share of the second and of the third corner in each pixel of the square about the triangle
        s = (dx * vy - dy * vx)[:, None] + vy[:, None] * column - vx[:, None] * row
        t = (dy * ux - dx * uy)[:, None] + ux[:, None] * row - uy[:, None] * column
        one, pixel = np.nonzero((s >= -INNER) & (t >= -INNER) & (s + t <= 1.0 + INNER))
        depth = a[which[one], 2] + area[which[one]] * (uz[one] * s[one, pixel] + vz[one] * t[one, pixel])
        x, y = low[which[one], 0] + column[pixel], low[which[one], 1] + row[pixel]
        within = (x <= limit[0]) & (y <= limit[1])
        yield x[within], y[within], depth[within], which[one][within]


def ball_fragments(place: np.ndarray, kept: np.ndarray, shape: tuple[int, int]) -> Fragments:
    """The fragments of the balls `kept` out of those at x, y, depth with a radius in pixels, shape (n, 4)."""
    size = np.zeros(len(place), np.int64)
    size[kept] = 2 * np.ceil(place[kept, 3]).astype(np.int64) + 1
    for which, side in _by_size(size):
        step = np.arange(side) - side // 2
        cx, cy, cz, radius = place[which].T[:, :, None]
        x, y = np.rint(cx).astype(np.int64) + np.tile(step, side), np.rint(cy).astype(np.int64) + np.repeat(step, side)
        rest = radius**2 - (x - cx) ** 2 - (y - cy) ** 2
        hit = (rest >= 0.0) & (x >= 0) & (y >= 0) & (x < shape[1]) & (y < shape[0])
        depth = cz + np.sqrt(np.maximum(rest, 0.0))
        yield x[hit], y[hit], depth[hit], np.broadcast_to(which[:, None], hit.shape)[hit]


def _by_size(size: np.ndarray) -> Iterator[tuple[np.ndarray, int]]:
    """Primitives in batches of like size in pixels, with the size that holds them all; those of size 0 left out."""
    lower, upper = 0, 1
    while lower < size.max(initial=0):
        found = np.flatnonzero((size > lower) & (size <= upper))
        batch = max(1, MOST // upper**2)
        for start in range(0, len(found), batch):
            yield found[start : start + batch], upper
        lower, upper = upper, upper + max(1, upper // 3)
