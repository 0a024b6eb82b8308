"""Search for the equilibria on a path along which the loads have an unknown factor.

All loads are multiplied by the factor. With the stiffness K, which includes that of the loads, the loads F for a factor of 1
and the residual forces r, each correction of positions and factor solves

    K δu - F δλ = r,    t · δu = 0,

by two solutions with the same factors. The second equation keeps the iteration in the plane normal to the tangent t of the
path at the last equilibrium, at the given distance (Riks 1979, Int. J. Solids Struct. 15, 529; Crisfield 1991, Non-linear
Finite Element Analysis of Solids and Structures, vol. 1, section 9.3). Distances are displacements alone, as root mean squares
over the nodes. K is factored in each iteration as it is, also if it is not positive definite.
"""

from collections.abc import Callable
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from pellucid.parts.elastic_system import PathSystem
from pellucid.simulation.minimum import BALANCED, ROUNDED, NoEquilibrium

MOST = 20  # corrections of a step
LEAST_COSINE = 0.5  # of the angle between the tangents at both ends of a step: the cubic between them is accurate


class NoStart(NoEquilibrium):
    """The path cannot start from the state without loads; remedy: what to change in the case."""

    def __init__(self, reason: str, remedy: str) -> None:
        super().__init__(reason)
        self.remedy = remedy


class PathPoint(NamedTuple):
    """An equilibrium on a path, and the tangent of the path there."""

    position: np.ndarray  # (n, 3) positions of the nodes [m]
    factor: float  # load factor
    along: np.ndarray  # (n, 3) derivative of the positions with respect to the distance along the path
    rate: float  # derivative of the load factor with respect to the distance [1/m]


class LoadsOnPath:
    """The loads of the case, multiplied by the load factor.

    renew: function that computes all loads at factor 1 for the present positions of the nodes; follows: True if loads depend on
    the deformation.
    """

    def __init__(self, system: PathSystem, renew: Callable[[], None], follows: bool) -> None:
        self._system, self._renew_whole, self._follows = system, renew, follows
        self.factor = 0.0
        """Load factor that acts."""

    def renew(self, share: float = 1.0) -> None:
        """Compute the loads at the present positions of the nodes."""
        self._renew_whole()
        self._system.scale_loads(self.factor)

    def attempt(self, position: np.ndarray, factor: float) -> "Attempt":
        """Return the forces at positions [m], shape (n, 3), under the loads of a factor."""
        system = self._system
        system.place(position)
        self._renew_whole()
        whole = system.external_loads()
        self.factor = factor
        system.scale_loads(factor)
        system.take_loads(self.renew, self._follows)
        residual, size, is_valid = system.judge()[1:]
        return Attempt(residual, size, is_valid, whole)


class Attempt(NamedTuple):
    """Forces at trial positions."""

    residual: np.ndarray  # (n, 3) residual forces [N]
    size: float  # sum of the norms of internal and external forces [N]
    is_valid: bool  # False if the body is inverted
    whole: np.ndarray  # (n, 3) loads for a factor of 1 [N]


class PathSearch:
    """Searches for the next equilibrium on a path; arguments as for `pellucid.simulation.minimum.Search`, and the loads."""

    def __init__(self, system: PathSystem, loads: LoadsOnPath, tolerance: float) -> None:
        fraction, least, most = BALANCED
        self._system, self._loads, self._tolerance = system, loads, tolerance
        self._balanced = min(max(fraction * tolerance, least), most)
        self.largest = 0.0, 0.0
        """Largest displacement [m] and sum of the norms of the forces [N] of the equilibria so far."""
        self.corrections, self.error, self.unbalanced = 0, 0.0, 0.0
        """Number of corrections, estimated error, and residual forces over all forces, of the last search."""

    def start(self) -> tuple[PathPoint, float]:
        """Return the state without loads as the start of the path, and the distance that a factor of 1 moves the body in the
        linear theory [m]. Raises NoStart."""
        here = self._loads.attempt(self._system.position, 0.0)
        try:
            self._system.factor_indefinite()
        except np.linalg.LinAlgError:
            remedy = (
                "Hold the body by [[support]]s, so that it cannot move as a whole; a flat membrane needs an initial tension."
            )
            raise NoStart("the stiffness is singular", remedy) from None
        along = self._system.solve(here.whole)
        distance = _size(along)
        if distance == 0.0:
            raise NoStart("the loads do not move the body", "Apply a load where the body is not held.")
        if _size(self._system.solve(here.residual)) > self._tolerance * distance:
            remedy = (
                "Remove the initial tension, inflation, spontaneous curvature or [start] that only loads can balance, or set "
                'steady.control = "load".'
            )
            raise NoStart("the body is not in equilibrium without loads", remedy)
        return PathPoint(self._system.position.copy(), 0.0, along / distance, 1.0 / distance), distance

    def next(self, start: PathPoint, length: float, told: Callable[[int, float], None]) -> PathPoint:
        """Return the equilibrium at a distance from the start [m]; told: function that is called in each iteration with its
        number and the load factor. Raises NoEquilibrium."""
        x, factor = start.position + length * start.along, start.factor + length * start.rate
        return self._corrected(start, x, factor, start.along, length, told)

    def at_factor(self, start: PathPoint, near: PathPoint, told: Callable[[int, float], None]) -> PathPoint:
        """Return the equilibrium under the loads of factor 1; start: last equilibrium; near: estimate. Raises NoEquilibrium."""
        length = _size(near.position - start.position)
        return self._corrected(start, near.position, 1.0, None, length, told)

    def _corrected(
        self,
        start: PathPoint,
        x: np.ndarray,
        factor: float,
        normal: np.ndarray | None,
        length: float,
        told: Callable[[int, float], None],
    ) -> PathPoint:
        """Iterate from positions x [m] and a load factor to an equilibrium in the plane with this normal, or with this factor
        for None. start: last equilibrium; length: distance from it, the largest change of an iteration [m]."""
        system, last = self._system, length
        for number in range(MOST):
            here = self._loads.attempt(x, factor)
            if not here.is_valid:
                raise NoEquilibrium("the body inverts")
            self._factor()
            change, ahead = system.solve(here.residual), system.solve(here.whole)
            more = 0.0
            if normal is not None:
                more = -_dot(normal, change) / _dot(normal, ahead)
                change = change + more * ahead
            scale = max(self.largest[0], float(np.abs(x - system.rest).max()))
            size, error = _size(change), float(np.abs(change).max()) / scale
            unbalanced = _norm(here.residual) / max(self.largest[1], here.size)
            told(number, factor)
            is_rounding = error <= ROUNDED and unbalanced <= BALANCED[2] and size > last
            if (error <= self._tolerance and unbalanced <= self._balanced) or is_rounding:
                if (obstacle := system.obstacle()) is not None:
                    raise NoEquilibrium(obstacle)
                self.corrections, self.error, self.unbalanced = number, error, unbalanced
                return self._with_tangent(start, x, factor, ahead)
            if not size <= last:
                raise NoEquilibrium("the corrections grow")
            x, factor, last = x + change, factor + more, size
        raise NoEquilibrium(f"the estimated error is {error:.2g} after {MOST} iterations")

    def _with_tangent(self, start: PathPoint, x: np.ndarray, factor: float, ahead: np.ndarray) -> PathPoint:
        """Return the equilibrium at positions x [m] with the tangent that continues the path from the start; ahead: derivative
        of the positions with respect to the load factor [m], shape (n, 3)."""
        distance = _size(ahead)
        if _dot(ahead, x - start.position) < 0.0:
            distance = -distance
        along = ahead / distance
        if not _dot(along, start.along) >= LEAST_COSINE * len(along):
            raise NoEquilibrium("the path turns sharply")
        return PathPoint(x, factor, along, 1.0 / distance)

    def _factor(self) -> None:
        try:
            self._system.factor_indefinite()
        except np.linalg.LinAlgError:
            raise NoEquilibrium("the stiffness is singular") from None

    def keep(self, point: PathPoint) -> None:
        """Record an equilibrium at which the last search ended in `largest`."""
        here = self._loads.attempt(point.position, point.factor)
        moved = float(np.abs(point.position - self._system.rest).max())
        self.largest = max(self.largest[0], moved), max(self.largest[1], here.size)


class Span:
    """The part of a path between two equilibria, as a cubic of the share 0 to 1 of the distance between them."""

    def __init__(self, start: PathPoint, end: PathPoint) -> None:
        chord, turn = _size(end.position - start.position), _size(end.along - start.along)
        self._start, self._end = start, end
        self.length = chord * (1.0 + turn * turn / 24.0)  # of an arc, up to the fourth power of its angle
        """Distance along the path between both equilibria [m]."""

    @property
    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the positions with respect to the share at both ends [m], shape (n, 3)."""
        return self.length * self._start.along, self.length * self._end.along

    def factor(self, share: float) -> float:
        """Return the load factor at a share of the distance."""
        first, last = self._start, self._end
        return _cubic(share, first.factor, last.factor, self.length * first.rate, self.length * last.rate)

    def position(self, share: float) -> np.ndarray:
        """Return the positions at a share of the distance [m], shape (n, 3)."""
        one, other = self.ends
        return np.asarray(_cubic(share, self._start.position, self._end.position, one, other))

    def extremes(self) -> list[float]:
        """Return the shares inside the span at which the load factor is extreme, in ascending order."""
        one, other = self.length * self._start.rate, self.length * self._end.rate
        rise = self._end.factor - self._start.factor
        a, b, c = 3.0 * (one + other - 2.0 * rise), 2.0 * (3.0 * rise - 2.0 * one - other), one  # of the derivative
        root = b * b - 4.0 * a * c
        if root <= 0.0:
            return []
        q = -0.5 * (b + np.copysign(sqrt(root), b))
        return sorted(share for share in ([c / q] if q else []) + ([q / a] if a else []) if 0.0 < share < 1.0)

    def limits(self, least: float) -> list[tuple[str, float]]:
        """Return kind and share of the limit points inside the span, in ascending order; least: smallest difference of the load
        factors of two limit points in one span, since the cubic overshoots where the load factor hardly changes."""
        shares = self.extremes()
        if self._start.rate * self._end.rate > 0.0 and (
            len(shares) < 2 or abs(self.factor(shares[0]) - self.factor(shares[1])) <= least
        ):
            return []
        kinds = ("maximum", "minimum") if self._start.rate > 0.0 else ("minimum", "maximum")
        return list(zip(kinds, shares, strict=False))

    def first_at(self, factor: float) -> float | None:
        """Return the first share at which the load factor reaches a value from below; None if it does not."""
        before = 0.0
        for share in (*self.extremes(), 1.0):
            if self.factor(share) >= factor:
                low, high = before, share
                while (middle := 0.5 * (low + high)) not in (low, high):
                    low, high = (low, middle) if self.factor(middle) >= factor else (middle, high)
                return high
            before = share
        return None


def _cubic(share: float, start: Any, end: Any, leaving: Any, arriving: Any) -> Any:
    """Return the value at a share 0 to 1 of the cubic with these values and derivatives at both ends."""
    s, left = share, 1.0 - share
    return left * left * ((1.0 + 2.0 * s) * start + s * leaving) + s * s * ((1.0 + 2.0 * left) * end - left * arriving)


def _dot(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.sum(one * other))


def _norm(one: np.ndarray) -> float:
    return sqrt(_dot(one, one))


def _size(displacement: np.ndarray) -> float:
    """Return the root mean square of displacements of the nodes [m], shape (n, 3)."""
    return _norm(displacement) / sqrt(len(displacement))
