"""Detects whether parts of the surface of one solid of material points approach each other during a run."""

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.material_points.surface import carried
from pellucid.contact.approaching_parts import (
    APPROACHED,
    ASIDE,
    FEWEST,
    NARROW,
    OPPOSITE,
    Gap,
    find_near,
    measure_gaps,
    select_facing,
)
from pellucid.grid.model import GridCase

DEFORMED = 0.1  # deformation of the surface between searches, in cells
NEARER = 0.1  # approach of two points, in cells, before their normals are computed
FOLDED = 4.0  # smallest initial distance of parts that can fold onto each other, in cells
SHEARED = 0.5  # largest deviation of points from the rigid motion of their hosts, in cells


class SurfaceParts:
    """Points on the surface of a body, about one per grid cell, that move with its material points; used to detect closing
    gaps.

    begun: initial positions of all material points by number [m], shape (n, 3).
    """

    def __init__(self, model: SeededBody, grid: GridCase, begun: np.ndarray) -> None:
        self._begun = begun
        self._place, area = model.boundary(grid, hard=False, spacing=grid.cell)
        self._area, self._normal, self._cell = area, _unit(area), grid.cell
        self._lower, self._periods = np.array(grid.lower, float), np.array(grid.periods(), float)
        self._tree = cKDTree(self._begun)
        self.hosts = np.asarray(self._tree.query(self._place)[1], np.int64).reshape(-1)
        """Numbers of the material points with which the surface points move, shape (m,)."""
        self._host = self._begun[self.hosts]  # places of these, without jumps over seams [m]
        self._searched = self._host.copy()

    def has_deformed(self, host: np.ndarray) -> bool:
        """Return True if the surface has deformed since the last search for gaps. host: present positions of the material
        points `hosts`, which move the surface points [m], shape (m, 3).
        """
        self._host = self._host + _shortest(host - self._host, self._periods)
        if not len(host):
            return False
        away = _after_rigid_motion(self._searched, self._host)[0] - self._host
        return float(np.einsum("ij,ij->i", away, away).max()) > (DEFORMED * self._cell) ** 2

    def find_closing_gap(self, position: np.ndarray, is_filled: Callable[[np.ndarray, float], np.ndarray]) -> Gap | None:
        """Return the narrowest gap between parts of the surface that have approached each other; None if there is none.

        position: positions of all material points [m], shape (n, 3), by number; is_filled: function that returns a mask of the
        positions [m], shape (k, 3), that lie within a distance [m] of other bodies.
        """
        self._searched = self._host.copy()
        if len(position) != len(self._begun):  # points that leave take their surface with them
            return None
        cell = self._cell
        _, turn = _after_rigid_motion(self._begun[self.hosts], self._host)
        near = self._host + (self._place - self._begun[self.hosts]) @ turn
        one, other = find_near(near, float(np.hypot(NARROW, ASIDE) + SHEARED) * cell, self._lower, self._periods)
        before, _, away = measure_gaps(self._place, self._normal, one, other, self._periods)
        distance = np.linalg.norm(away, axis=1)
        faced = np.einsum("ij,ij->i", self._normal[one], self._normal[other]) < OPPOSITE
        now = np.linalg.norm(_shortest(near[other] - near[one], self._periods), axis=1)
        # narrower gaps are reported before a run; both sides of a thin part have a negative one
        across = faced & (before > NARROW * cell)
        before = np.where(across, before, distance)
        possible = (across | (distance > FOLDED * cell)) & (before - now > NEARER * cell)
        one, other, before = one[possible], other[possible], before[possible]
        if len(one) < FEWEST:
            return None
        used, numbers = np.unique(np.concatenate([one, other]), return_inverse=True)
        one, other = numbers[: len(one)], numbers[len(one) :]
        whole = self._begun + (self._host - self._begun[self.hosts]).mean(axis=0)
        whole += _shortest(position - whole, self._periods)
        place, area = carried(self._place[used], self._area[used], self.hosts[used], self._tree, whole)
        facing, kept = select_facing(place, _unit(area), one, other, cell, self._periods)
        before = before[kept]
        closes = before - facing.gap > APPROACHED * cell
        at = np.flatnonzero(closes)
        if len(at) >= FEWEST:
            at = at[~is_filled(facing.middle[at], 0.5 * cell)]
        if len(at) < FEWEST:
            return None
        narrowest = at[np.argmin(facing.gap[at])]
        return Gap(float(facing.gap[narrowest]), float(before[narrowest]), facing.middle[narrowest])


def _shortest(way: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Return displacements [m], shape (n, 3), reduced by whole periods of the grid [m], shape (3,), to the shortest
    equivalent displacements."""
    folds = periods > 0.0
    shortest = way.copy()
    shortest[:, folds] -= periods[folds] * np.round(way[:, folds] / periods[folds])
    return shortest


def _after_rigid_motion(before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions `before` [m], shape (n, 3), after the rigid motion for which they are closest to `after`, and
    the transposed rotation matrix of this motion (Kabsch 1976, Acta Cryst. A 32, 922)."""
    first, last = before.mean(axis=0), after.mean(axis=0)
    left, _, right = np.linalg.svd((before - first).T @ (after - last))
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = (left * signs) @ right
    return (before - first) @ turn + last, turn


def _unit(area: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(area, axis=1, keepdims=True)
    return np.asarray(area / np.where(size > 0.0, size, 1.0))
