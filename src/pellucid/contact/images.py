"""Mirror images of surfaces at planes of symmetry, periodic images at the seams of periodic grids, and feet on surfaces.

Feet are the projections of contact points on another surface, as weighted means of its points. Velocities of the other
surface are interpolated to the feet. Forces on the feet are distributed to its points with the same weights and therefore
do the same work. Contact laws need no further data of the other surface.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import sparse

from pellucid.contact.contact_surface import ContactSurface
from pellucid.jit import kernel

BESIDE = 1.2
"""Largest distance of a point from a plane of symmetry for which it has an image, over the reach of the point.

Images further away than one reach have no weight. Points of regular lattices seldom lie at this distance, so that the set
of images stays the same from step to step.
"""
ACROSS = 2.0  # width of the strip at a seam with images, in the largest reach of a point


class Plane(NamedTuple):
    """Plane of symmetry perpendicular to an axis."""

    axis: int  # 0 to 2
    place: float  # position of the plane along the axis [m]


class Seam(NamedTuple):
    """Seam of a periodic axis: both ends of the axis are the same plane."""

    axis: int  # 0 to 2
    place: float  # position of the lower end of the axis [m]
    period: float  # length of the axis [m]


class Images(NamedTuple):
    """Images of points of a surface; k is their number."""

    point: np.ndarray  # (k,) index of the original point of each image
    flip: np.ndarray  # (k, 3) -1 along the axes in which the image is mirrored, 1 along others


NO_IMAGES = Images(np.zeros(0, np.int64), np.zeros((0, 3)))


class Described(NamedTuple):
    """Points of a surface with their images at the start of a step.

    The first m points are the points of the surface; the remaining n - m are images at planes of symmetry and seams. Points
    other than images lie within the box along periodic axes.
    """

    place: np.ndarray  # (n, 3) positions [m]
    normal: np.ndarray  # (n, 3) unit normals, see `ContactSurface.normals`
    size: np.ndarray  # (n,) areas [m²]
    reach: np.ndarray  # (n,) see `ContactSurface` [m]
    images: Images  # n - m images

    def fold(self, force: np.ndarray) -> np.ndarray:
        """Return the forces on the m surface points, including the forces on their images, shape (m, 3).

        force: forces on all points and images, shape (n, 3).
        """
        point, flip = self.images
        if not len(point):
            return force
        m = len(self.place) - len(point)
        total = force[:m].copy()
        _fold(point, flip, force[m:], total)
        return total


@kernel()
def _fold(point, flip, force, total):
    for i in range(len(point)):
        for d in range(3):
            total[point[i], d] += flip[i, d] * force[i, d]


class Feet(NamedTuple):
    """Feet of n contact points, i.e. their projections on another surface, as weighted means of its points. Foot i has
    the entries first[i] to first[i + 1] of `point` and `share`."""

    first: np.ndarray  # (n + 1,) start of the entries of each foot
    point: np.ndarray  # (k,) point numbers
    share: np.ndarray  # (k,) weights; their sum is 1 for each foot

    def gather(self, values: np.ndarray, images: Images = NO_IMAGES) -> np.ndarray:
        """Return vectors interpolated to the feet, shape (n, 3), from the vectors at the m points of the other surface, shape
        (m, 3), whose images follow these points."""
        found = np.empty((len(self.first) - 1, 3))
        _gather(*self, *images, values, found)
        return found

    def shares(self, m: int, images: Images) -> sparse.csr_array:
        """Return the weights of the m points of the other surface in the positions of the feet, shape (n, m); those of images
        count as weights of their points."""
        point = np.where(self.point < m, self.point, 0)
        beyond = self.point >= m
        point[beyond] = images.point[self.point[beyond] - m]
        rows = np.repeat(np.arange(len(self.first) - 1), np.diff(self.first))
        return sparse.csr_array((self.share, (rows, point)), shape=(len(self.first) - 1, m))

    def spread(self, force: np.ndarray, into: np.ndarray) -> None:
        """Distribute forces on the feet [N], shape (n, 3), to the points of the other surface and its images by adding them to
        `into`, the forces on these points [N], shape (q, 3)."""
        _spread(*self, force, into)


@kernel()
def _gather(first, point, share, original, flip, values, found):
    m = len(values)
    for i in range(len(found)):
        a = b = c = 0.0
        for r in range(first[i], first[i + 1]):
            q, w = point[r], share[r]
            if q < m:
                a, b, c = a + w * values[q, 0], b + w * values[q, 1], c + w * values[q, 2]
            else:
                o = original[q - m]
                a += w * flip[q - m, 0] * values[o, 0]
                b += w * flip[q - m, 1] * values[o, 1]
                c += w * flip[q - m, 2] * values[o, 2]
        found[i, 0], found[i, 1], found[i, 2] = a, b, c


@kernel()
def _spread(first, point, share, force, into):
    for i in range(len(force)):
        a, b, c = force[i, 0], force[i, 1], force[i, 2]
        for r in range(first[i], first[i + 1]):
            q, w = point[r], share[r]
            into[q, 0] += w * a
            into[q, 1] += w * b
            into[q, 2] += w * c


def describe(
    surface: ContactSurface, planes: Sequence[Plane], seams: Sequence[Seam] = (), before: Described | None = None
) -> Described:
    """Return the points of a surface with their images at planes of symmetry and at the seams of a periodic grid.

    before: result for the same surface in the previous step; the arrays of this result are reused if the number of images
    is the same.
    """
    m = len(surface.place)
    kept = before is not None and len(before.size) == m + len(before.images.point)
    found = before if before is not None and kept else _make_room(m, m)
    if not planes and not seams:
        found = found._replace(place=surface.place, reach=surface.reach)
        surface.find_directions(found.normal, found.size)
        return found
    faces = np.array([(axis, at, period) for axis, at, period in seams] + [(axis, at, 0.0) for axis, at in planes])
    n = -1
    while n != len(found.place):
        found = _make_room(m, n) if n >= 0 else found
        surface.find_directions(found.normal[:m], found.size[:m])
        n = int(_describe(faces, surface.place, surface.reach, *found[:4], *found.images))
    return found


def _make_room(m: int, n: int) -> Described:
    images = Images(np.zeros(n - m, np.int64), np.zeros((n - m, 3)))
    return Described(np.empty((n, 3)), np.empty((n, 3)), np.empty(n), np.empty(n), images)


@kernel()
def _describe(faces, place_of_points, reach_of_points, place, normal, size, reach, point, flip):
    """Write the points of a surface and their images to the arrays from `place` to `flip`, see `Described`, up to the size of
    these arrays; return the number of points and images.

    faces: axis, position [m] and period [m] of each seam and then of each plane of symmetry (period 0), shape (k, 3). The
    arrays that end in `_of_points` are the data of the m surface points.
    """
    m, n, far = len(place_of_points), len(place_of_points), 0.0
    for p in range(m):
        reach[p], far = reach_of_points[p], max(far, ACROSS * reach_of_points[p])
        for d in range(3):
            place[p, d] = place_of_points[p, d]
    for j in range(len(faces)):
        axis, at, period, upto = int(faces[j, 0]), faces[j, 1], faces[j, 2], n
        if period > 0.0:
            for p in range(m):
                place[p, axis] -= period * np.floor((place[p, axis] - at) / period)
        for side in range(2 if period > 0.0 else 1):
            for i in range(min(upto, len(place))):
                x = place[i, axis]
                if period > 0.0:
                    near, sign = x < at + far if side == 0 else x > at + period - far, 1.0
                    shift = period if side == 0 else -period
                else:
                    near, sign, shift = abs(x - at) < BESIDE * reach[i], -1.0, 2.0 * at
                if not near:
                    continue
                if n < len(place):
                    for d in range(3):
                        across = sign if d == axis else 1.0
                        place[n, d] = across * place[i, d] + (shift if d == axis else 0.0)
                        normal[n, d] = across * normal[i, d]
                        flip[n - m, d] = across * flip[i - m, d] if i >= m else across
                    size[n], reach[n], point[n - m] = size[i], reach[i], point[i - m] if i >= m else i
                n += 1
    return n
