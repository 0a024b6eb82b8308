"""Drawing of walls (rigid planes that bound the bodies and have no points) in pictures and in the interactive view."""

from collections.abc import Sequence

import numpy as np

from pellucid.results.pictures.annotations import Axes
from pellucid.results.pictures.mirrors import Mirror
from pellucid.results.pictures.rendering.drawables import Mesh
from pellucid.results.storage.stored_case import StoredWall

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
