"""Surroundings of bodies in pictures: mirror images, images in a periodic grid, and walls."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.grid.model import GridCase
from pellucid.results.pictures.drawables import Mesh
from pellucid.results.pictures.style import Axes
from pellucid.results.storage.run_folder import StoredWall
from pellucid.state import COMPONENT_NAMES, FIELDS

SEAM = "seam"
"""Name of the additional field with the displacement of points into the periodic box [m], shape (n, 3)."""


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
            elif name == SEAM or (values.ndim == 2 and FIELDS[name].names == COMPONENT_NAMES.get(values.shape[1])):
                odd = [component.count("xyz"[axis]) == 1 for component in COMPONENT_NAMES[values.shape[1]]]
                image[:, odd] *= -1.0
            found[name] = np.concatenate([values, image])
    return found


def cells_with_images(cells: Cells, n: int, mirrors: tuple[Mirror, ...]) -> Cells:
    """Return the cells of n points together with the cells of their mirror images, in the order of points of `with_images`."""
    copies = range(2 ** len(mirrors))
    return Cells(*(np.concatenate([corners + n * copy for copy in copies]) for corners in cells))


def in_box(fields: dict[str, np.ndarray], cells: Callable[[], Cells], grid: GridCase | None) -> dict[str, np.ndarray]:
    """Return the fields of a body after moving its positions into the box of the periodic grid; unchanged if the grid is
    not periodic.

    Points without cells are moved one by one; a body with a mesh is moved as a whole, according to the centre of its
    points. The displacement is added as the field `seam` [m]. cells: function that returns the cells of the body.
    """
    if grid is None or not grid.periodic:
        return fields
    moved = way_into_box(fields["position"], cells(), grid)
    return {**fields, "position": fields["position"] + moved, SEAM: moved}


def way_into_box(position: np.ndarray, cells: Cells, grid: GridCase | None) -> np.ndarray:
    """Return the displacement that moves points into the box of a periodic grid [m], shape (n, 3): multiples of its periods.

    position: [m], shape (n, 3). cells: cells of the body; a body with cells is moved as a whole.
    """
    way = np.zeros_like(position)
    for axis, period in enumerate(grid.periods() if grid is not None else ()):
        if period == 0.0:
            continue
        x = position[:, axis]
        if any(len(corners) for corners in (cells.lines, cells.triangles, cells.quadrilaterals, cells.tetrahedra)):
            x = np.full(len(x), np.mean(x[np.isfinite(x)]) if np.isfinite(x).any() else 0.0)
        way[:, axis] = -period * np.floor((x - grid.lower[axis]) / period) if grid is not None else 0.0
    return way


def places_unmoved(fields: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the positions of the points before `in_box` moved them into the periodic box [m], shape (n, 3). Displacements are
    computed from these."""
    return fields["position"] - fields.get(SEAM, 0.0)


INK, HATCH = "#5f6570", "////"
PALE = (0.86, 0.87, 0.90)  # of a wall in space
BAND = 0.03  # of the larger side of a picture: how far behind a wall is hatched
BEYOND = 0.15  # of the size of the bodies, by which a wall in space is shown around them
SEEN = 0.1  # the least cosine between the normal of a wall and the direction to the eye: others would hide the bodies


def with_mirrored(walls: Sequence[StoredWall], mirrors: Sequence[Mirror]) -> list[StoredWall]:
    """Return the walls, followed by their mirror images in the planes of symmetry `mirrors` and in combinations of these
    planes."""
    found = list(walls)
    for axis, place in mirrors:
        sign = np.where(np.arange(3) == axis, -1.0, 1.0)
        shift = np.where(np.arange(3) == axis, 2.0 * place, 0.0)
        found += [StoredWall(wall.name, sign * wall.point + shift, sign * wall.normal, sign * wall.velocity) for wall in found]
    return found


def clipped(polygon: np.ndarray, normal: np.ndarray, level: float) -> np.ndarray:
    """Return the corners of the part of a convex polygon in the half space n·x ≤ level [m], shape (k, d); empty if the
    polygon lies outside.

    polygon: corners in order [m], shape (m, d), d = 2 or 3. normal: unit vector n, shape (d,).
    """
    beyond = polygon @ normal - level
    corners: list[np.ndarray] = []
    for k in range(len(polygon)):
        last, here = k - 1, k
        if (beyond[last] > 0.0) != (beyond[here] > 0.0):
            share = beyond[last] / (beyond[last] - beyond[here])
            corners.append(polygon[last] + share * (polygon[here] - polygon[last]))
        if beyond[here] <= 0.0:
            corners.append(polygon[here])
    return np.array(corners).reshape(-1, polygon.shape[1])


def draw_walls(
    axes: Axes, walls: Sequence[StoredWall], time: float, flat: Sequence[int], at: float, window: tuple[np.ndarray, np.ndarray]
) -> None:
    """Draw walls at a time [s] as lines with hatching on their back side.

    flat: the two axes (0 to 2) of the picture; at: position of the picture along the third axis [m]; window: lower and upper
    corner of the picture [m], shape (2,) each.
    """
    (left, below), (right, above) = window
    paper = np.array([(left, below), (right, below), (right, above), (left, above)])
    width, tiny = BAND * float(np.ptp(paper, axis=0).max()), 1e-9 * float(np.ptp(paper, axis=0).max())
    (across,) = set(range(3)) - set(flat)
    for wall in walls:
        normal = wall.normal[list(flat)]
        size = float(np.linalg.norm(normal))
        if size < SEEN:  # it lies in the paper
            continue
        level = float((wall.level(time) - wall.normal[across] * at) / size)
        band = clipped(clipped(paper, normal / size, level), -normal / size, width - level)
        if not len(band):
            continue
        axes.fill(*band.T, facecolor="none", edgecolor=INK, hatch=HATCH, linewidth=0.0, zorder=0.5)
        edge = band[np.abs(band @ normal / size - level) < tiny]
        axes.plot(*edge.T, color=INK, linewidth=1.2, zorder=0.6)


def polygon_of(wall: StoredWall, time: float, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the corners of the part of a wall in a box at a time [s], shape (k, 3) [m], counterclockwise about its normal.
    low, high: corners of the box [m]."""
    centre, reach = 0.5 * (low + high), float(np.linalg.norm(high - low))
    middle = centre + (wall.level(time) - wall.normal @ centre) * wall.normal
    first = np.cross(wall.normal, np.eye(3)[int(np.argmin(np.abs(wall.normal)))])
    first *= reach / np.linalg.norm(first)
    second = np.cross(wall.normal, first)
    polygon = middle + np.array([-first - second, first - second, first + second, second - first])
    for axis in range(3):
        polygon = clipped(clipped(polygon, np.eye(3)[axis], high[axis]), -np.eye(3)[axis], -low[axis])
    return polygon


def fan_of(corners: int) -> np.ndarray:
    """Divide a convex polygon into triangles that share its first corner; return their corner numbers, shape (corners - 2,
    3). corners: number of corners."""
    return np.array([(0, k, k + 1) for k in range(1, corners - 1)], np.int64).reshape(-1, 3)


def around(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and upper corner [m] of a box with the corners `low` and `high` [m], after extending it on each side
    by BEYOND times its longest edge."""
    gap = BEYOND * float((high - low).max())
    return low - gap, high + gap


def meshes_of_walls(
    walls: Sequence[StoredWall], time: float, box: tuple[np.ndarray, np.ndarray], eye: np.ndarray
) -> list[Mesh]:
    """Return the parts of the walls in a box at a time [s] as surfaces, without walls that are seen from behind or nearly edge
    on.

    box: lower and upper corner [m]. eye: direction to the eye, a unit vector.
    """
    found = []
    for wall in walls:
        polygon = polygon_of(wall, time, *box)
        if wall.normal @ eye >= SEEN and len(polygon) > 2:
            colours, marked = np.tile(PALE, (len(polygon), 1)), np.zeros(len(polygon), bool)
            found.append(Mesh(polygon, fan_of(len(polygon)), colours, marked))
    return found
