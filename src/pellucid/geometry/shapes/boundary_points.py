"""Points on the boundary of a region with their shares of the vector area, computed only from a function that tests whether
points lie in the region.

Lattice lines along each axis are followed. A point is placed by bisection where a line enters or leaves the region; the
slope of the boundary is found from neighbouring crossings. Lines along axis d intersect a boundary with unit normal n
with a density |n_d|/s² (s: spacing), so that the share s² |n_d| of each point makes the sum over the three families Σ
n_d² = 1: areas of planes are exact.
"""

from collections.abc import Callable

import numpy as np

from pellucid.geometry.shapes.contract import ActiveAxes

BISECTIONS = 40
BESIDE = 1e-3  # of the spacing: distance from a point at which the boundary is located again to find its slope
PHASE = 0.5  # of the spacing: offset of the lines from the lower corner, so that a face on the lattice lies between two lines
Contains = Callable[[np.ndarray], np.ndarray]


def boundary_points(
    contains: Contains, lower: np.ndarray, upper: np.ndarray, spacing: float, active: ActiveAxes, thickness: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return positions [m] and outward vector areas [m²] of points on the boundary of a region, shape (n, 3) each.

    contains: returns a mask of the positions, shape (m, 3), that lie in the region; lower, upper: corners of a box around
    the region [m]; spacing: approximate distance between points [m]; active: axes along which the grid is more than one
    cell thick; thickness: of the region along each axis that is not active [m].
    """
    axes = [d for d in range(3) if active[d]]
    counts = {d: max(1, round(float(upper[d] - lower[d]) / spacing)) for d in axes}
    steps = {d: float(upper[d] - lower[d]) / counts[d] for d in axes}
    middle = 0.5 * (lower + upper)
    places, areas = [], []
    for d in axes:
        others = [e for e in axes if e != d]
        lines = [lower[e] + steps[e] * (np.arange(counts[e]) + PHASE) for e in others]
        at = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, len(others)) if others else np.zeros((1, 0))
        along = lower[d] + steps[d] * (np.arange(-1, counts[d] + 1) + PHASE)
        base = np.tile(middle, (len(at), 1))
        base[:, others] = at
        grid = np.repeat(base[:, None, :], len(along), axis=1)
        grid[:, :, d] = along
        inside = contains(grid.reshape(-1, 3)).reshape(len(at), len(along))
        line, number = np.nonzero(inside[:, 1:] != inside[:, :-1])
        start, enters = grid[line, number], inside[line, number + 1]
        found = _crossing(contains, start, enters, d, 0.0, steps[d])
        slopes = np.zeros((len(start), 3))
        for e in others:
            slopes[:, e] = _slope(contains, start, enters, found, d, e, steps)
        normal = -slopes
        normal[:, d] = 1.0
        normal *= np.where(enters, -1.0, 1.0)[:, None]
        cosine = 1.0 / np.linalg.norm(normal, axis=1)
        normal *= cosine[:, None]
        start[:, d] += found
        places.append(start)
        share = float(np.prod([steps[e] for e in others])) * thickness ** (3 - len(axes))
        areas.append((share * cosine)[:, None] * normal)
    return np.concatenate(places), np.concatenate(areas)


def _crossing(
    contains: Contains, start: np.ndarray, enters: np.ndarray, d: int, low: float | np.ndarray, high: float | np.ndarray
) -> np.ndarray:
    """Return the distance from each start position to the boundary along axis d [m], shape (n,), by bisection between the
    distances `low` and `high` [m]. contains: as in `boundary_points`; start: positions [m], shape (n, 3); enters: True if
    the line enters the region there, shape (n,)."""
    lo, hi = np.broadcast_to(low, len(start)).copy(), np.broadcast_to(high, len(start)).copy()
    for _ in range(BISECTIONS):
        mid = 0.5 * (lo + hi)
        place = start.copy()
        place[:, d] += mid
        beyond = contains(place) == enters
        lo, hi = np.where(beyond, lo, mid), np.where(beyond, mid, hi)
    return 0.5 * (lo + hi)


def _slope(
    contains: Contains, start: np.ndarray, enters: np.ndarray, found: np.ndarray, d: int, e: int, steps: dict[int, float]
) -> np.ndarray:
    """Return the derivative of the boundary position along axis d with respect to axis e, shape (n,). contains, start,
    enters: as in `_crossing`; found: distances that it returned [m]; steps: spacing of the lattice lines along each axis
    [m].

    A central difference is used, or a one-sided one next to an edge.
    """
    beside, room = BESIDE * steps[e], 0.2 * steps[d]
    rises, known = [], []
    for side in (-1.0, 1.0):
        moved = start.copy()
        moved[:, e] += side * beside
        low, high = moved.copy(), moved.copy()
        low[:, d] += found - room
        high[:, d] += found + room
        known.append((contains(low) != enters) & (contains(high) == enters))
        rises.append(side * (_crossing(contains, moved, enters, d, found - room, found + room) - found) / beside)
    one, other = known
    both = np.where(one & other, 0.5 * (rises[0] + rises[1]), np.where(one, rises[0], np.where(other, rises[1], 0.0)))
    sharp = one & other & (np.abs(rises[0] - rises[1]) > 0.5)  # an edge lies between the two: the flatter side is this face
    return np.where(sharp, np.where(np.abs(rises[0]) < np.abs(rises[1]), rises[0], rises[1]), both)
