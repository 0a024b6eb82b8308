"""Plane walls that cut cells of the grid, for the surface energy of a fluid in front of them.

The space in front of the planes is sampled by parts of cells, each with its fraction in front of the planes; this is exact
for planes along the axes. The result is the fraction of the volume around each node and of each cell that the fluid can
fill. The area of a plane around a node is summed where lines along an axis cross the plane, so that a plane on a face of
the grid counts with its full area. Faces of the grid count with the fraction of their area in front of the planes, since
there is no fluid behind the planes.
"""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from pellucid.approximants import GridFunctions, image_along
from pellucid.approximants.grid_functions import axis_weights
from pellucid.contact.wall_plane import WallPlane
from pellucid.grid.lattice import Grid

PARTS, PARTS_IN_SPACE = 8, 4  # parts of a cell along each axis: in plane problems, in space
MOST_PARTS = 4_000_000  # at a time
NEAR = 1e-6  # distance below which a plane coincides with a face of the grid or another plane, in cells


class WettedPlane(NamedTuple):
    """A plane wall at rest that a fluid wets."""

    wall: WallPlane  # unit normal towards the fluid and position of the plane
    cosine: float  # cosine of the contact angle of the fluid at the wall


class OpenSpace(NamedTuple):
    """Space in front of wall planes (on the side of the fluid): fractions of the volumes around nodes and of cells, and
    areas. Arrays of nodes have the shape (x, y, z), with the nodes within the faces of the grid."""

    nodes: np.ndarray
    """Fraction of the volume around each node in front of the planes."""
    cells: np.ndarray
    """Fraction of each cell in front of the planes."""
    areas: list[np.ndarray]
    """Area of each plane around each node [m²]."""
    faces: list[tuple[np.ndarray, np.ndarray]]
    """For each axis, the fraction of the area around the nodes of the lower and of the upper face of the grid in front of
    the planes, one node thick along the axis."""


def find_open_space(grid: Grid, functions: GridFunctions, planes: Sequence[WettedPlane]) -> OpenSpace:
    """Return the space in front of planes that a fluid can fill, computed by sampling nodes and cells; functions: shape
    functions of the grid along each axis."""
    axes = [_Samples(grid, function, axis) for axis, function in enumerate(functions)]
    shape = tuple(axis.smooth.shape[1] for axis in axes)
    cells = tuple(axis.boxes.shape[1] for axis in axes)
    nodes, share = np.zeros(shape), np.zeros(cells)
    part = [axis.width for axis in axes]
    rows = max(1, MOST_PARTS // (len(axes[1].place) * len(axes[2].place)))
    for start in range(0, len(axes[0].place), rows):
        of_x = slice(start, start + rows)
        x, y, z = axes[0].place[of_x, None, None], axes[1].place[None, :, None], axes[2].place[None, None, :]
        before = []
        for plane in planes:
            across = float(
                np.abs(plane.wall.normal * [0.0 if thin else p for thin, p in zip(grid.thin, part, strict=True)]).sum()
            )
            before.append(np.clip(0.5 + _height(plane, (x, y, z)) / across, 0.0, 1.0))
        whole = np.prod(before, axis=0)
        nodes += _collect(whole, [axes[0].smooth[of_x], axes[1].smooth, axes[2].smooth])
        share += _collect(whole, [axes[0].boxes[of_x], axes[1].boxes, axes[2].boxes])
    about = [axis.smooth.sum(axis=0) for axis in axes]
    near = NEAR * grid.lattice.cell
    areas = [_area(planes, number, axes, near) for number in range(len(planes))]
    faces = [(_open_share(planes, axes, axis, False, near), _open_share(planes, axes, axis, True, near)) for axis in range(3)]
    return OpenSpace(nodes / np.einsum("i,j,k->ijk", *about), share, areas, faces)


def _height(plane: WettedPlane, place: Sequence[np.ndarray | float]) -> np.ndarray:
    """Return the height [m] of positions above a plane, in the direction of its normal; place: coordinates x, y, z [m],
    numbers or arrays that broadcast with each other."""
    normal = plane.wall.normal
    return np.asarray(normal[0] * place[0] + normal[1] * place[1] + normal[2] * place[2] - plane.wall.level)


def _before(plane: WettedPlane, place: Sequence[np.ndarray | float], across: float, on: float, near: float) -> np.ndarray:
    """Return the fraction of each part of a plane or face that lies in front of the plane `plane`. place: coordinates x, y,
    z of the centres of the parts [m]; across: difference of the height above `plane` over a part [m].

    on: fraction for a part that lies in `plane`; near: height up to which a part counts as lying in `plane` [m].
    """
    height = _height(plane, place)
    if across > near:
        return np.clip(0.5 + height / across, 0.0, 1.0)
    return np.where(np.abs(height) <= near, on, np.where(height > 0.0, 1.0, 0.0))


def _area(planes: Sequence[WettedPlane], number: int, axes: Sequence["_Samples"], near: float) -> np.ndarray:
    """Return the area of the plane with index `number` around each node [m²], shape (x, y, z), in front of the other planes:
    summed where lines along the axis nearest to its normal cross the plane within the grid. axes: sampling points along
    each axis; near: distance below which planes coincide [m]."""
    normal, level = planes[number].wall.normal, planes[number].wall.level
    axis = int(np.argmax(np.abs(normal)))
    one, two = (other for other in range(3) if other != axis)
    place: list[np.ndarray | float] = [0.0, 0.0, 0.0]
    place[one], place[two] = axes[one].place[:, None], axes[two].place[None, :]
    crossing = (level - normal[one] * place[one] - normal[two] * place[two]) / normal[axis]
    place[axis] = crossing
    area = np.where((crossing >= axes[axis].lower - near) & (crossing <= axes[axis].upper + near), 1.0, 0.0)
    area *= axes[one].width * axes[two].width / abs(normal[axis])
    for plane in [*planes[:number], *planes[number + 1 :]]:
        tilt = plane.wall.normal - normal * (plane.wall.normal[axis] / normal[axis])
        across = abs(tilt[one]) * axes[one].width + abs(tilt[two]) * axes[two].width
        area *= _before(plane, place, across, 0.5, near)
    return _spread_linearly(area, place, axes)


def _open_share(planes: Sequence[WettedPlane], axes: Sequence["_Samples"], axis: int, upper: bool, near: float) -> np.ndarray:
    """Return the fraction of the area around the nodes of a face of the grid that lies in front of the planes; 0 where a
    plane coincides with the face. axes: sampling points along each axis; axis: normal axis of the face; upper: True for the
    upper end of the grid; near: distance below which planes coincide [m]."""
    one, two = (other for other in range(3) if other != axis)
    place: list[np.ndarray | float] = [0.0, 0.0, 0.0]
    place[one], place[two] = axes[one].place[:, None], axes[two].place[None, :]
    place[axis] = axes[axis].upper if upper else axes[axis].lower
    share = np.ones((len(axes[one].place), len(axes[two].place)))
    whole = _spread_linearly(share, place, axes)
    for plane in planes:
        normal = plane.wall.normal
        across = abs(normal[one]) * axes[one].width + abs(normal[two]) * axes[two].width
        share = share * _before(plane, place, across, 0.0, near)
    nodes = tuple(slice(-1, None) if upper and o == axis else slice(0, 1) if o == axis else slice(None) for o in range(3))
    return np.asarray(_spread_linearly(share, place, axes)[nodes] / whole[nodes])


def _spread_linearly(values: np.ndarray, place: Sequence[np.ndarray | float], axes: Sequence["_Samples"]) -> np.ndarray:
    """Return the sums at the nodes, shape (x, y, z), of values that are distributed linearly to the nodes around their
    positions; place: coordinates x, y, z of the values [m]; axes: sampling points along each axis."""
    shape = tuple(axis.n_nodes for axis in axes)
    ends = []
    for at, axis in zip(place, axes, strict=True):
        u = np.broadcast_to(axis.in_cells(at), values.shape)
        left = np.minimum(u.astype(np.int64), max(axis.n_nodes - 2, 0))
        ends.append(((left, left + 1.0 - u), (np.minimum(left + 1, axis.n_nodes - 1), u - left)))
    out = np.zeros(shape)
    for (i, of_x), (j, of_y), (k, of_z) in product(*ends):
        index = np.ravel_multi_index((i, j, k), shape).ravel()
        out += np.bincount(index, (values * of_x * of_y * of_z).ravel(), out.size).reshape(shape)
    return out


class _Samples:
    """Sampling points (parts of cells) along an axis, and their weights at nodes, shape (parts, nodes), and in cells, shape
    (parts, cells)."""

    def __init__(self, grid: Grid, function: object, axis: int) -> None:
        count, cell = grid.lattice.counts[axis], grid.lattice.cell
        self.lower, self.upper = grid.lattice.lower[axis], grid.lattice.lower[axis] + cell * count
        self.n_nodes, self._cell = 1 if grid.thin[axis] else count + 1, cell
        if grid.thin[axis]:
            self.place, self.width = np.array([grid.lattice.lower[axis]]), grid.slice_thickness
            self.smooth = self.boxes = np.ones((1, 1))
            return
        parts = PARTS if any(grid.thin) else PARTS_IN_SPACE
        u = (np.arange(count * parts) + 0.5) / parts
        self.place, self.width = grid.lattice.lower[axis] + cell * u, cell / parts
        smooth = np.zeros((len(u), count + 4))
        self.boxes = np.zeros((len(u), count))
        for row, at in enumerate(u):
            first, weights, _ = axis_weights(function, at, count)
            for node, weight in enumerate(weights, start=first):
                smooth[row, image_along(function, node, count)] += weight
            self.boxes[row, int(at)] = 1.0 / parts
        self.smooth = smooth[:, : count + 1]  # weights beyond a face are zero

    def in_cells(self, place: np.ndarray | float) -> np.ndarray:
        """Return positions along the axis [m] as distances from the lower face in cells, limited to the grid."""
        return np.clip((np.asarray(place) - self.lower) / self._cell, 0.0, self.n_nodes - 1.0)


def _collect(values: np.ndarray, weights: Sequence[np.ndarray]) -> np.ndarray:
    """Return the sums of values at sampling points, shape (parts x, parts y, parts z), times their weights at nodes or cells
    along the axes, shape (x, y, z); einsum adds in the same order for any number of threads."""
    x, y, z = weights
    along_z = np.einsum("abc,ck->abk", values, z)
    return np.asarray(np.einsum("ajk,ai->ijk", np.einsum("abk,bj->ajk", along_z, y), x))
