"""Surfaces beside planes of symmetry, where they go on as their mirror images."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pellucid.contact.contact_surface import ContactSurface


class Plane(NamedTuple):
    """A plane of symmetry across an axis."""

    axis: int
    place: float  # [m]


class Described(NamedTuple):
    """The n points of a surface as a step begins, the m of the surface itself first, then images of those near planes."""

    place: np.ndarray  # (n, 3) [m]
    normal: np.ndarray  # (n, 3) unit normals, zero where the area is
    size: np.ndarray  # (n,) areas [m²]
    reach: np.ndarray  # (n,) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    point: np.ndarray  # (n - m,) of which point each image is one
    flip: np.ndarray  # (n - m, 3) -1 along the axes across which it is mirrored, 1 along others
    lower: np.ndarray  # (3,) of a box about the places [m],
    upper: np.ndarray  # (3,)

    def fold(self, force: np.ndarray) -> np.ndarray:
        """Forces on the points of the surface, shape (m, 3), with those on their images, of forces on all (n, 3)."""
        m = len(self.place) - len(self.point)
        total = force[:m].copy()
        np.add.at(total, self.point, self.flip * force[m:])
        return total


def describe(surface: ContactSurface, planes: Sequence[Plane]) -> Described:
    """The points of a surface with their images."""
    length = np.linalg.norm(surface.area, axis=1)
    normal = surface.area / np.where(length > 0.0, length, 1.0)[:, None]
    place, size, reach, velocity = surface.place, surface.sizes(), surface.reach, surface.velocity
    point, flip = np.arange(len(place)), np.ones_like(place)
    for axis, at in planes:
        near = np.flatnonzero(np.abs(place[:, axis] - at) < reach)
        if not len(near):
            continue
        mirrored = flip[near].copy()
        mirrored[:, axis] *= -1.0
        image = place[near].copy()
        image[:, axis] = 2.0 * at - image[:, axis]
        across = np.ones(3)
        across[axis] = -1.0
        place, normal = np.concatenate([place, image]), np.concatenate([normal, across * normal[near]])
        velocity = np.concatenate([velocity, across * velocity[near]])
        size, reach = np.concatenate([size, size[near]]), np.concatenate([reach, reach[near]])
        point, flip = np.concatenate([point, point[near]]), np.concatenate([flip, mirrored])
    m = len(surface.place)
    ends = place.min(axis=0, initial=np.inf), place.max(axis=0, initial=-np.inf)
    return Described(place, normal, size, reach, velocity, point[m:], flip[m:], *ends)
