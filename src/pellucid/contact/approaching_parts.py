"""Search for narrow gaps between two parts of the surface of one body, to warn that the grid will join them.

Material points of one velocity field share the nodes of the grid. Two parts of one body therefore stick to each other as soon
as their points contribute to the same nodes, about one cell before their surfaces touch. From then on they neither slide nor
separate.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

NARROW = 1.5
"""Width of a gap [cells] below which points on both sides of the gap contribute to the same nodes."""
ASIDE = 0.75  # largest tangential offset of the two points of a pair, in cells
OPPOSITE = -0.7  # largest cosine between the normals of two parts that face each other
PARALLEL = -0.97  # largest cosine between the normals of both sides of a slit; excludes the tip of a notch
APPROACHED = 0.25  # smallest decrease of a gap that counts as an approach, in cells
FEWEST = 3  # smallest number of facing pairs that form a gap
LEAST_EXTENT = 2.0  # smallest extent of a slit along its sides, in cells
LEAST_GAP = 1e-3  # smallest width of a gap, in cells


class Facing(NamedTuple):
    """Pairs of points of one surface that face each other across a narrow gap (see `select_facing`); n is the number of
    pairs."""

    one: np.ndarray  # (n,) indices of the first points
    other: np.ndarray  # (n,) indices of the second points
    gap: np.ndarray  # (n,) gap widths [m]
    middle: np.ndarray  # (n, 3) positions midway between both points [m]


class Gap(NamedTuple):
    """Narrowest gap between two parts of one surface, for a warning (see `describe_gap`)."""

    width: float  # smallest distance of both parts across the gap [m]
    before: float  # width of the gap at the start of the run [m]
    place: np.ndarray  # (3,) position midway between both parts [m]


def find_near(place: np.ndarray, distance: float, lower: np.ndarray, periods: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of all pairs of positions that are at most `distance` [m] apart, two arrays of shape (k,).

    place: positions [m], shape (n, 3). lower: lower corner of the grid [m], shape (3,). periods: periods of the grid [m],
    shape (3,), zero along non-periodic axes.
    """
    folds, inside = periods > 0.0, place - lower
    inside[:, folds] %= periods[folds]
    shift = np.where(folds, 0.0, inside.min(axis=0, initial=0.0))
    tree = cKDTree(inside - shift, boxsize=np.where(folds, periods, 0.0))
    one, other = tree.query_pairs(distance, output_type="ndarray").T
    return one, other


def select_facing(
    place: np.ndarray,
    normal: np.ndarray,
    one: np.ndarray,
    other: np.ndarray,
    cell: float,
    periods: np.ndarray,
    opposite: float = OPPOSITE,
) -> tuple[Facing, np.ndarray]:
    """Return those of the given pairs of points that face each other across a gap of at most `NARROW` cells, and a mask
    that selects them among the k given pairs, shape (k,).

    Parameters
    ----------
    place, normal
        Positions [m] and unit normals of the points, shape (n, 3).
    one, other
        Indices of both points of each given pair, shape (k,).
    cell
        Cell size [m].
    periods
        Periods of the grid [m], shape (3,), zero along non-periodic axes.
    opposite
        Largest cosine of the angle between both normals of a selected pair; -1 accepts exactly opposite normals only.
    """
    gap, beside, away = measure_gaps(place, normal, one, other, periods)
    faces = (gap > LEAST_GAP * cell) & (gap <= NARROW * cell) & (beside <= ASIDE * cell)
    faces &= np.einsum("ij,ij->i", normal[one], normal[other]) < opposite
    return Facing(one[faces], other[faces], gap[faces], (place[one] + 0.5 * away)[faces]), faces


def measure_gaps(
    place: np.ndarray, normal: np.ndarray, one: np.ndarray, other: np.ndarray, periods: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the gap and the tangential offset [m], shape (k,), and the connecting vector [m], shape (k, 3), of each of k
    pairs of points of a surface.

    place, normal: positions [m] and unit normals of the points, shape (n, 3). one, other: indices of both points of each
    pair, shape (k,). periods: periods of the grid [m], shape (3,), zero along non-periodic axes.

    The gap is the component of the connecting vector along the mean normal. It is negative if the material of the body lies
    between the points. The tangential offset is the length of the remaining component.
    """
    away = place[other] - place[one]
    folds = periods > 0.0
    away[:, folds] -= periods[folds] * np.round(away[:, folds] / periods[folds])
    mean = normal[one] - normal[other]
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300)
    gap = np.einsum("ij,ij->i", away, mean)
    return gap, np.linalg.norm(away - gap[:, None] * mean, axis=1), away


def find_slit(facing: Facing, empty: np.ndarray, cell: float) -> Gap | None:
    """Return the narrowest gap of a slit (facing pairs of points over a length of at least `LEAST_EXTENT` cells); None if there
    is no slit.

    empty: mask of the pairs with no other body at their midpoint, shape (n,). cell: cell size [m].
    """
    middle = facing.middle[empty]
    if len(middle) < FEWEST or float(np.linalg.norm(np.ptp(middle, axis=0))) < LEAST_EXTENT * cell:
        return None
    narrowest = int(np.argmin(facing.gap[empty]))
    width = float(facing.gap[empty][narrowest])
    return Gap(width, width, middle[narrowest])


def describe_gap(name: str, gap: Gap, cell: float, at_start: bool) -> str:
    """Return the warning about a gap between two parts of body `name`.

    cell: cell size [m]. at_start: True if the body has not moved yet.
    """
    at = ", ".join(f"{value:.4g}" for value in gap.place)
    width = f"{gap.width / cell:.2g} cells ({gap.width:.3g} m)"
    if at_start:
        what = f"a slit in body {name} is {width} wide at ({at}) m, less than {NARROW:g} cells: its sides"
    else:
        left = f"{width} remain of a gap of {gap.before / cell:.2g}"
        what = f"parts of the surface of body {name} approach each other: at ({at}) m {left} cells; below {NARROW:g} cells they"
    return (
        f"{what} stick to each other: material points of one velocity field share the nodes of the grid, and contact does "
        f"not act there. Describe them as two bodies with a `field` each and a [[contact]], use kind "
        f'"meshless-solid" with [[contact]] `between = ["{name}"]`, '
        "or a smaller grid.cell, with which they stick only when they are closer"
    )
