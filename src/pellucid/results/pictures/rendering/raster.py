"""Rasterization of triangles and balls into fragments, and the canvas that keeps the nearest fragment of each pixel."""

from collections.abc import Iterator

import numpy as np

from pellucid.geometry.algorithms.enclosure import spread

MOST = 2_000_000
"""Largest number of pixels that are processed together."""

DEPTHS = 1 << 24  # steps of depth that a canvas tells apart
REACH = 1 << 15  # pixels of depth on either side of the origin: far beyond any picture
SHIFT = 32
INNER = 1e-9  # of a triangle: a pixel on an edge belongs to both neighbours

Fragments = Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]
"""Batches of fragments (pixels of primitives): x and y [pixels, whole numbers], depth [pixels] and number of the primitive."""


class Canvas:
    """Depth buffer of a picture: stores, for every pixel, the depth of the nearest fragment, the part (drawn object) to
    which this fragment belongs, and the number of its primitive (triangle, ball or pixel) in the part.

    shape: numbers of rows and columns of pixels.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self.shape = shape
        self._key = np.full(shape[0] * shape[1], -1, np.int64)
        self._starts = [0]

    def begin_part(self, primitives: int) -> None:
        """Start a new part, i.e. the next drawn object. primitives: number of its triangles, balls or pixels."""
        self._starts.append(self._starts[-1] + primitives)

    def add(self, x: np.ndarray, y: np.ndarray, depth: np.ndarray, primitive: np.ndarray) -> None:
        """Add fragments (pixels covered by primitives) of the current part. Of fragments of a pixel at the same depth, the one
        with the highest primitive number is kept.

        x, y: pixel coordinates, whole numbers; depth: towards the eye [pixels]; primitive: number of the triangle, ball or
        pixel in the part; shape (k,) each.
        """
        step = np.clip((depth + REACH) * (DEPTHS / (2 * REACH)), 0, DEPTHS - 1).astype(np.int64)
        np.maximum.at(self._key, y * self.shape[1] + x, step << SHIFT | (primitive + self._starts[-2]))

    def seen(self, part: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the pixels in which a part (number of the drawn object) is visible: their indices, row by row, and the
        primitive number in each, both of shape (k,)."""
        number = self._key & ((1 << SHIFT) - 1)
        index = np.flatnonzero((self._key >= 0) & (number >= self._starts[part]) & (number < self._starts[part + 1]))
        return index, number[index] - self._starts[part]

    def covered(self) -> np.ndarray:
        """Return a mask of the pixels covered by any primitive, with the canvas's shape."""
        return (self._key >= 0).reshape(self.shape)

    def depth(self) -> np.ndarray:
        """Return the depth towards the eye [pixels] of the object that each pixel shows, with the canvas's shape."""
        return ((self._key >> SHIFT) * (2 * REACH / DEPTHS) - REACH).reshape(self.shape)


def triangle_fragments(corners: np.ndarray, shape: tuple[int, int]) -> Fragments:
    """Yield the fragments (pixels covered by triangles, with depth and number of the triangle), row by row.

    corners: pixel coordinates and depth of the corners, shape (m, 3, 3). shape: rows and columns of the picture.
    """
    with np.errstate(invalid="ignore", over="ignore"):  # of points that are nowhere
        a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    shown = np.isfinite(area) & (np.abs(area) >= 1e-12)
    corners = np.where(shown[:, None, None], corners, 0.0)
    low = np.maximum(np.ceil(corners[:, :, 1].min(axis=1)), 0).astype(np.int64)
    high = np.minimum(np.floor(corners[:, :, 1].max(axis=1)), shape[0] - 1).astype(np.int64)
    rows = np.where(shown, np.maximum(high - low + 1, 0), 0)
    pixels = np.cumsum(rows * np.minimum(np.ptp(corners[:, :, 0], axis=1) + 1.0, shape[1]))
    for some in np.split(np.arange(len(corners)), np.searchsorted(pixels, np.arange(MOST, pixels.max(initial=0), MOST))):
        row, number = spread(rows[some])
        which = some[row]
        y = low[which] + number
        dy, one = y - a[which, 1], 1.0 / area[which]
        (ux, uy, uz), (vx, vy, vz) = u[which].T * one, v[which].T * one
        # the shares of the second and of the third corner in a pixel are s + ds x and t + dt x, x from the first corner on
        s, ds, t, dt = -dy * vx, vy, dy * ux, -uy
        first, last = -a[which, 0], shape[1] - 1 - a[which, 0]
        for share, slope in ((s, ds), (t, dt), (1.0 - s - t, -ds - dt)):
            with np.errstate(divide="ignore", invalid="ignore"):
                end = -(share + INNER) / slope
            first = np.where(slope > 0.0, np.maximum(first, end), first)
            last = np.where(slope < 0.0, np.minimum(last, end), last)
            last = np.where((slope == 0.0) & (share < -INNER), -np.inf, last)
        start = np.ceil(first + a[which, 0])
        line, number = spread(np.maximum(np.floor(last + a[which, 0]) - start + 1.0, 0.0).astype(np.int64))
        x = start[line].astype(np.int64) + number
        z, slope = a[which, 2] + area[which] * (uz * s + vz * t), area[which] * (uz * ds + vz * dt)
        yield x, y[line], z[line] + slope[line] * (x - a[which, 0][line]), which[line]


def ball_fragments(place: np.ndarray, kept: np.ndarray, shape: tuple[int, int]) -> Fragments:
    """Yield the fragments (pixels covered by balls, with depth and number of the ball).

    place: x, y, depth and radius of all balls in pixels, shape (n, 4). kept: indices of the balls to draw. shape: rows and
    columns of the picture.
    """
    size = np.zeros(len(place), np.int64)
    size[kept] = 2 * np.ceil(place[kept, 3]).astype(np.int64) + 1
    for which, side in _by_size(size):
        step = np.arange(side) - side // 2
        cx, cy, cz, radius = place[which].T[:, :, None]
        x, y = np.rint(cx).astype(np.int64) + step, np.rint(cy).astype(np.int64) + step
        across = np.where((x >= 0) & (x < shape[1]), np.square(x - cx), np.inf)
        upward = np.where((y >= 0) & (y < shape[0]), np.square(radius) - np.square(y - cy), -np.inf)
        rest = upward[:, :, None] - across[:, None, :]
        ball, row, column = np.nonzero(rest >= 0.0)
        yield x[ball, column], y[ball, row], cz[ball, 0] + np.sqrt(rest[ball, row, column]), which[ball]


def _by_size(size: np.ndarray) -> Iterator[tuple[np.ndarray, int]]:
    """Yield batches of primitives of similar size: their indices and an upper bound of their size in pixels. size: shape (n,);
    primitives of size 0 are omitted."""
    lower, upper = 0, 1
    while lower < size.max(initial=0):
        found = np.flatnonzero((size > lower) & (size <= upper))
        batch = max(1, MOST // upper**2)
        for start in range(0, len(found), batch):
            yield found[start : start + batch], upper
        lower, upper = upper, upper + max(1, upper // 3)
