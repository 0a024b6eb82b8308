"""Areas of the surface of a region at the nodes near it, and its sharp edges.

The area of a node is A_i = ∫ φ_i dA over the surface. It is summed over the crossings of the surface with lines along the axes,
SAMPLES in a cell. A crossing with a line along axis d stands for an area δ^(D-1) w_d(n)/|n_d| of a grid of D axes, with the
distance δ of the lines, the normal n at the crossing and weights w_d that add up to 1 over the axes. The normals follow from
the crossings with parallel lines on both sides. Where the radius of curvature is less than a cell, as at an edge, only one side
is used: the one towards which the surface is less inclined to the plane across the line. The normals of plane faces are then
exact up to their edges, and the areas of faces that meet are added as numbers. The gradient of the filled fraction, ∫ φ_i n dA,
adds them as vectors: at a right-angled edge it is up to 30 % smaller.

A crossing belongs to an edge if the normal at another crossing at most BESIDE_EDGES cells away differs from its own by more
than on a surface with a radius of curvature of two cells, and the region is convex there: at concave edges the velocity of a
viscous fluid is not singular.
"""

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from pellucid.conditions.rigid.no_slip import NoSlip
from pellucid.geometry.shapes.contract import ActiveAxes

SAMPLES = 4  # lines in a cell along each axis; samples in a cell along them
BESIDE = 0.125  # cells between a line and the parallel lines from which the normal follows
STEEPEST = 2.0  # slope of the surface up to which such a line finds it
LEAST_SQUARE = 1.0 / (1.0 + STEEPEST**2)  # of the component of a normal along a line: with it, both slopes are smaller
BISECTIONS = 12  # to find a crossing
BESIDE_EDGES = 0.5  # cells from an edge within which the surface belongs to it
SMOOTH, SHARP = 0.6, 1.0  # curvatures per cell up to which a surface is smooth, with an error of 0.1; from which it is an edge
MOST_PLACES = 1_000_000  # largest number of positions evaluated at once

Inside = Callable[[np.ndarray], np.ndarray]


class Edges(NamedTuple):
    """Pieces of a surface at its convex edges."""

    place: np.ndarray  # (m, 3) positions [m]
    normal: np.ndarray  # (m, 3) unit normals out of the region
    area: np.ndarray  # (m,) areas [cell^(D-1)]


def find_areas(
    no_slip: NoSlip,
    contains: Inside,
    place: np.ndarray,
    normal: np.ndarray,
    lower: np.ndarray,
    cell: float,
    active: ActiveAxes,
) -> tuple[np.ndarray, np.ndarray, Edges]:
    """Return the integrals of the shape functions of nodes over the surface of a region, without parts that face away from the
    normal of the node, shape (n,) [cell^(D-1)], the same over the edges, shape (n,), and the edges.

    no_slip: provides the shape functions; contains: function that returns which positions lie in the region; place: positions
    of the nodes [m], shape (n, 3); normal: unit normals out of the region at the nodes, shape (n, 3); lower: lower corner of
    the grid [m]; cell: cell size [m]; active: axes along which the grid is more than one cell thick.
    """
    area, of_edges, nothing = np.zeros(len(place)), np.zeros(len(place)), np.zeros((0, 3))
    if not len(place):
        return area, of_edges, Edges(nothing, nothing, np.zeros(0))
    on, axes = np.array(active), np.flatnonzero(active)
    reach = int(np.ceil(no_slip.half))
    start = np.where(on, lower, place[0])
    at = np.where(on, np.rint((place - start) / cell), 0).astype(int)
    around = np.array(list(product(*(range(-reach, reach + 1) if a else (0,) for a in active))))
    low = at.min(axis=0) - reach
    shape = at.max(axis=0) + reach + 1 - low
    number = np.full(shape, -1)
    number[tuple((at - low).T)] = np.arange(len(at))
    covered = np.zeros(shape, bool)
    for step in around:
        covered[tuple((at + step - low).T)] = True
    cells = np.argwhere(covered) + low
    at_once = max(1, MOST_PLACES // SAMPLES ** len(axes))
    parts = [
        _crossings(lambda s: contains(start + cell * s), cells[k : k + at_once], active) for k in range(0, len(cells), at_once)
    ]
    crossing, seen_at, out, size = (np.concatenate(values) for values in zip(*parts, strict=True))
    sharp = _sharpness(crossing, out)
    nearest = np.where(on, np.rint(seen_at), 0).astype(int)
    for step in around:
        to = nearest + step
        within = np.all((to >= low) & (to < low + shape), axis=1)
        node = np.where(within, number[tuple((np.clip(to, low, low + shape - 1) - low).T)], -1)
        value = size.copy()
        for d in axes:
            value *= no_slip.functions(seen_at[:, d] - to[:, d])[0]
        seen = np.flatnonzero((node >= 0) & (np.sum(normal[node] * out, axis=1) > 0.0))
        area += np.bincount(node[seen], value[seen], len(place))
        of_edges += np.bincount(node[seen], (sharp * value)[seen], len(place))
    edge = np.flatnonzero(sharp > 0.0)
    return area, of_edges, Edges(start + cell * crossing[edge], out[edge], (sharp * size)[edge])


def _sharpness(place: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return the parts with which pieces of a surface belong to convex edges, shape (m,): 0 if it is smooth, 1 at edges. place:
    positions in cells, shape (m, 3); normal: unit normals, shape (m, 3)."""
    turn = np.zeros(len(place))
    if len(place):
        one, two = cKDTree(place).query_pairs(BESIDE_EDGES, output_type="ndarray").T
        angle = np.arccos(np.clip(np.sum(normal[one] * normal[two], axis=1), -1.0, 1.0))
        angle[np.sum((place[two] - place[one]) * (normal[two] - normal[one]), axis=1) <= 0.0] = 0.0
        np.maximum.at(turn, one, angle)
        np.maximum.at(turn, two, angle)
    return np.clip((turn / BESIDE_EDGES - SMOOTH) / (SHARP - SMOOTH), 0.0, 1.0)


def _crossings(contains: Inside, cells: np.ndarray, active: ActiveAxes) -> tuple[np.ndarray, ...]:
    """Return the crossings of the surface of a region with lines along the axes in cells around nodes: their positions and
    those midway between the samples on both sides, shape (m, 3) each, the unit normals out of the region there, shape (m, 3),
    and the areas for which they stand, shape (m,), in cells. contains: function of positions in cells; cells: indices of the
    nodes, shape (n, 3)."""
    axes, offsets = np.flatnonzero(active), (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    found: list[tuple[np.ndarray, ...]] = []
    for d in axes.tolist():
        block = np.stack(np.meshgrid(*(offsets if on else [0.0] for on in active), indexing="ij"), axis=-1).reshape(-1, 3)
        first = (cells[:, None] + block).reshape(-1, 3)
        along = np.eye(3)[d] / SAMPLES
        inside = contains(first)
        crossed = inside != contains(first + along)
        lower, inside = first[crossed], inside[crossed]
        place = lower + _find_change(contains, lower, inside, along)[:, None] * along
        slopes, known = np.zeros((len(place), 3)), np.ones(len(place), bool)
        for e in axes[axes != d].tolist():
            rises, sure = zip(*(_rise(contains, place, inside, d, e, side) for side in (-1.0, 1.0)), strict=True)
            both = np.where(sure, np.abs(rises), np.inf)
            mean = 0.5 * (rises[0] + rises[1])
            turn = np.abs(np.arctan(rises[1]) - np.arctan(rises[0]))
            smooth = np.all(sure, axis=0) & (turn < BESIDE * np.sqrt(1.0 + mean**2))
            slopes[:, e] = np.where(smooth, mean, np.choose(both.argmin(axis=0), rises))
            known &= np.isfinite(both.min(axis=0))
        out = np.where(np.arange(3) == d, 1.0, -slopes) * np.where(inside, 1.0, -1.0)[:, None]
        out /= np.linalg.norm(out, axis=1)[:, None]
        weights = np.maximum(out**2 - LEAST_SQUARE, 0.0)
        component = np.abs(out[:, d])
        size = np.where(known, weights[:, d] / weights.sum(axis=1) / component, 0.0) / SAMPLES ** (len(axes) - 1)
        midway = lower + 0.5 * along  # as the samples of the filled fraction see it
        found.append(tuple(values[size > 0.0] for values in (place, midway, out, size)))
    return tuple(np.concatenate(values) for values in zip(*found, strict=True))


def _find_change(contains: Inside, start: np.ndarray, inside: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Return the parts of the vector `step` from positions `start`, shape (m, 3), at which a region begins or ends, shape (m,).
    inside: mask of the positions that lie in the region."""
    low, high = np.zeros(len(start)), np.ones(len(start))
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        same = contains(start + middle[:, None] * step) == inside
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray(0.5 * (low + high))


def _rise(
    contains: Inside, place: np.ndarray, inside: np.ndarray, d: int, e: int, side: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the slope along axis `e` of the surface above axis `d` at positions on it, shape (m,), from a parallel line on the
    side -1 or 1, and a mask of the positions at which this line meets the surface up to the slope `STEEPEST`."""
    reach = STEEPEST * BESIDE
    start = place + side * BESIDE * np.eye(3)[e] - reach * np.eye(3)[d]
    step = 2.0 * reach * np.eye(3)[d]
    sure = (contains(start) == inside) & (contains(start + step) != inside)
    rise = np.zeros(len(place))
    rise[sure] = 2.0 * _find_change(contains, start[sure], inside[sure], step) - 1.0
    return side * STEEPEST * rise, sure
