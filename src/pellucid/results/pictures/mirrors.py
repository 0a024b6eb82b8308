"""Mirror images of bodies in planes of symmetry, for cases that compute a half, a quarter or an eighth of a body."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.grid.model import GridCase
from pellucid.state import COMPONENT_NAMES, FIELDS


class Mirror(NamedTuple):
    """A plane of symmetry normal to an axis."""

    axis: int
    place: float  # position of the plane along the axis [m]


def mirrors_at(faces: tuple[str, ...], grid: GridCase | None) -> tuple[Mirror, ...]:
    """Return the planes of symmetry at the named faces of the grid, such as "x-lower" (normal to x at the lower end of the
    grid)."""
    if grid is None:
        return ()
    ends = {"lower": grid.lower, "upper": grid.extent_upper()}
    named = [(("xyz".index(face[0])), ends[face[2:]]) for face in faces]
    return tuple(Mirror(axis, float(end[axis])) for axis, end in named)


def with_images(fields: Mapping[str, np.ndarray], mirrors: tuple[Mirror, ...]) -> dict[str, np.ndarray]:
    """Return the fields of points, shape (n, ...), and of their images in all k planes, shape (2^k n, ...).

    Positions, vectors and symmetric tensors are mirrored; fields in the local frame of a membrane are copied.
    """
    found = dict(fields)
    for axis, place in mirrors:
        for name, values in found.items():
            image = values.copy()
            if name == "position":
                image[:, axis] = 2.0 * place - image[:, axis]
            elif values.ndim == 2 and FIELDS[name].names == COMPONENT_NAMES.get(values.shape[1]):
                odd = [component.count("xyz"[axis]) == 1 for component in COMPONENT_NAMES[values.shape[1]]]
                image[:, odd] *= -1.0
            found[name] = np.concatenate([values, image])
    return found


def cells_with_images(cells: Cells, n: int, mirrors: tuple[Mirror, ...]) -> Cells:
    """Return the cells of n points together with the cells of their mirror images, in the order of points of `with_images`."""
    copies = range(2 ** len(mirrors))
    return Cells(*(np.concatenate([corners + n * copy for copy in copies]) for corners in cells))
