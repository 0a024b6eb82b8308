"""Surfaces beside planes of symmetry, where they go on as their mirror images, and beside the seams of periodic grids."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pellucid.contact.contact_surface import ContactSurface

NO_IMAGES = np.zeros(0, np.int64), np.zeros((0, 3))
ACROSS = 2.0  # of the largest reach of a point, from a seam: a place beside it meets no point that is further beyond


class Plane(NamedTuple):
    """A plane of symmetry across an axis."""

    axis: int
    place: float  # [m]


class Seam(NamedTuple):
    """The ends of a periodic axis, which are the same."""

    axis: int
    place: float  # of the lower end [m]
    period: float  # [m]


class Described(NamedTuple):
    """The n points of a surface as a step begins, the m of the surface itself first, then images of those near planes and
    seams. Along periodic axes all lie within the box, but for images."""

    place: np.ndarray  # (n, 3) [m]
    normal: np.ndarray  # (n, 3) unit normals, see `ContactSurface.normals`
    size: np.ndarray  # (n,) areas [m²]
    reach: np.ndarray  # (n,) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    point: np.ndarray  # (n - m,) of which point each image is one
    flip: np.ndarray  # (n - m, 3) -1 along the axes across which it is mirrored, 1 along others
    wraps: bool = False  # whether points come back at the other end of a periodic grid

    def fold(self, force: np.ndarray) -> np.ndarray:
        """Forces on the points of the surface, shape (m, 3), with those on their images, of forces on all (n, 3)."""
        m = len(self.place) - len(self.point)
        if not len(self.point):
            return force
        total = force[:m].copy()
        np.add.at(total, self.point, self.flip * force[m:])
        return total


def describe(surface: ContactSurface, planes: Sequence[Plane], seams: Sequence[Seam] = ()) -> Described:
    """The points of a surface with their images."""
    (normal, size), m = surface.directions(), len(surface.place)
    if not planes and not seams:
        return Described(surface.place, normal, size, surface.reach, surface.velocity, *NO_IMAGES)
    found = _Points(surface.place, normal, size, surface.reach, surface.velocity, np.arange(m), np.ones((m, 3)))
    for axis, at, period in seams:
        found.place = found.place.copy()
        found.place[:, axis] -= period * np.floor((found.place[:, axis] - at) / period)
    for axis, at, period in seams:
        x, far = found.place[:, axis], ACROSS * float(surface.reach.max(initial=0.0))
        low, high = np.flatnonzero(x < at + far), np.flatnonzero(x > at + period - far)
        shift = period * np.eye(3)[axis]
        found.add(np.concatenate([low, high]), np.ones(3), np.repeat([shift, -shift], [len(low), len(high)], axis=0))
    for axis, at in planes:
        across = np.ones(3)
        across[axis] = -1.0
        found.add(np.flatnonzero(np.abs(found.place[:, axis] - at) < found.reach), across, 2.0 * at * np.eye(3)[axis])
    of_images = found.point[m:], found.flip[m:]
    return Described(found.place, found.normal, found.size, found.reach, found.velocity, *of_images, len(seams) > 0)


@dataclass
class _Points:
    """Points of a surface and images of them, as `Described` has them; `point` and `flip` of all."""

    place: np.ndarray
    normal: np.ndarray
    size: np.ndarray
    reach: np.ndarray
    velocity: np.ndarray
    point: np.ndarray
    flip: np.ndarray

    def add(self, near: np.ndarray, across: np.ndarray, shift: np.ndarray) -> None:
        """Add images of some: vectors times `across`, (3,), and places moved then by a shift [m], (3,) or one for each."""
        if not len(near):
            return
        self.place = np.concatenate([self.place, across * self.place[near] + shift])
        self.normal = np.concatenate([self.normal, across * self.normal[near]])
        self.velocity = np.concatenate([self.velocity, across * self.velocity[near]])
        self.size, self.reach = (np.concatenate([of, of[near]]) for of in (self.size, self.reach))
        self.point = np.concatenate([self.point, self.point[near]])
        self.flip = np.concatenate([self.flip, across * self.flip[near]])
