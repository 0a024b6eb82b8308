"""Equilibria of elastic bodies as minima of their potential energy, by the limited-memory BFGS method with a factored
stiffness.

Each direction is d = -H g, with the gradient g of the energy and an approximation H of the inverse of its second derivatives:
the factored stiffness, corrected by the last changes of displacements and gradients (Nocedal & Wright 2006, Numerical
Optimization, algorithm 7.4). The stiffness is factored at each equilibrium, which shows whether it is stable, and serves for
the next load step; and again where the iteration is slow. The energy decreases in every iteration: the iteration approaches
stable equilibria, also where a load buckles a body. Loads that follow the deformation, such as pressures, have no potential
in general: then a step is accepted if the residual forces along it do not grow in the opposite direction.

If the factors are those of an approximation of the stiffness, more iterations are needed; each still costs one evaluation of
the forces and one solution. The factors are computed at the start of each load step; an equilibrium is not tested for
stability.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from pellucid.parts.elastic_system import ElasticSystem, Searched, Trial

MEMORY = 20  # pairs of changes that are kept
RENEWAL = 40  # iterations after which the stiffness is factored again, if the second half of them was slow
SLOW = 0.1  # ratio of the errors at the end and start of this half from which it was slow
BALANCED = 0.1, 1e-9, 1e-5  # residual forces of an equilibrium over all forces: fraction of the tolerance, least and most
MOST = 400  # iterations of a load step
DECREASE = 1e-4  # smallest decrease of the energy, as a fraction of that along the tangent
SLOPE = 0.9  # largest slope at the end of a step, as a fraction of that at its start, for loads without a potential
ROUNDED = 1e-8  # error up to which a search may end by rounding above the tolerance
AT_REST, ROUNDED_REST = 1e-10, 1e-12
"""Displacements of a body at rest without loads, and their last change, over the size of the body: what rounding leaves."""
POSITIONS = 1e-14  # changes of positions that are rounding, relative to the positions
SHORTEST = 1e-6  # smallest fraction of a direction
ROUNDING = 1e-12  # change of the energy, relative to the energy, below which only the slope judges a step
FIRST_KICK, LAST_KICK = 1e-4, 0.1  # displacements that leave an unstable equilibrium, relative to the size of the body
MOST_LEFT = 3  # unstable equilibria that are left in a load step


class NoEquilibrium(Exception):
    """No equilibrium was found; the text is the reason, as a clause."""


class Equilibrium(NamedTuple):
    """An equilibrium that was found."""

    position: np.ndarray  # (n, 3) positions of the nodes [m]
    iterations: int  # number of iterations
    error: float  # estimated error of the displacements relative to the largest
    unbalanced: float  # norm of the residual forces relative to internal and external forces
    left_unstable: bool  # True if an unstable equilibrium was found on the way and left
    is_unstable: bool  # True if it is unstable, and no way to a stable one was found
    frequency: float | None  # lowest natural frequency [Hz]; None if it is not known


class Search:
    """Searches for positions at which the forces of one body balance.

    system: energy, forces and stiffness of the body; tolerance: estimated error of the displacements, relative to the largest,
    at which positions are accepted if their forces also balance.
    """

    def __init__(self, system: Searched, tolerance: float) -> None:
        fraction, least, most = BALANCED
        self._system, self._tolerance, self._balanced = system, tolerance, min(max(fraction * tolerance, least), most)
        self._extent = float(np.ptp(system.rest, axis=0).max())
        self._reach = float(np.abs(system.rest).max())  # largest coordinate
        self.has_factors, self._renewed = False, False
        """Whether there are factors for the next search, and whether they were computed within the last one."""
        self._changes: list[tuple[np.ndarray, np.ndarray]] = []
        self.largest = 0.0, 0.0
        """Largest displacement [m] and sum of the norms of the forces [N] of the equilibria so far."""
        self._error = 0.0  # estimated error relative to the largest displacement
        self._goal = tolerance, self._balanced  # limits of the estimated error and of the residual forces, of this search

    def forget(self) -> None:
        """Discard the factors, so that the next search begins with new ones."""
        self.has_factors = False

    def give_up(self) -> None:
        """Discard the factors after a search without success, unless they are those of the last equilibrium."""
        self.has_factors = self.has_factors and not self._renewed

    def near(self, starts: Sequence[np.ndarray], told: Callable[[int, float], None], few: int) -> Equilibrium:
        """Return positions at which the forces balance; the last call of `attempt` is there. The present factors serve again,
        and also for the next search after at most `few` iterations.

        starts: positions [m], shape (n, 3), at the first of which the search starts if they are valid, else at the next; told:
        function that is called in each iteration with its number and the estimated error. Raises NoEquilibrium.
        """
        for start in starts:
            here = self._system.attempt(start)
            if here.is_valid:
                break
        else:
            raise NoEquilibrium("the predicted positions invert the body")
        if not self.has_factors:
            self._factor()
        self._changes, self._renewed = [], False
        x, here, used = self._minimise(start, here, 0, told)
        self.has_factors = used <= few
        return Equilibrium(x, used, self._error, self._unbalanced(x, here), False, False, None)

    def _minimise(
        self, x: np.ndarray, here: Trial, done: int, told: Callable[[int, float], None]
    ) -> tuple[np.ndarray, Trial, int]:
        """Iterate from positions x [m], with energy and forces there, to a minimum. done: iterations before. Returns
        positions, energy and forces at the minimum, and the number of iterations."""
        since, errors = 0, list[float]()  # iterations since the factors are in use; errors of all iterations
        for number in range(MOST):
            if since >= RENEWAL and self._error > SLOW * errors[-RENEWAL // 2]:
                self._renewed, since = True, 0
                self._factor()
            direction, slope = self._direction(here)
            change, scale = float(np.abs(direction).max()), self._scale_at(x)
            self._error = change / scale if scale > 0.0 else 0.0
            since += 1
            errors.append(self._error)
            balanced = _norm(here.residual) <= self._goal[1] * max(self.largest[1], here.size)
            told(done + number, self._error)
            if scale <= AT_REST * self._extent and change <= ROUNDED_REST * self._extent:
                self._error = 0.0  # both are rounding
                return x, here, number
            if (self._error <= self._goal[0] and balanced) or (
                change <= POSITIONS * self._reach and self._is_rounding(here.residual)
            ):
                return x, here, number
            found = self._searched(x, here, direction, slope)
            if found is None:
                if self._error > ROUNDED or _norm(here.residual) > BALANCED[2] * max(self.largest[1], here.size):
                    what = "the energy does" if self._system.has_potential else "the residual forces do"
                    raise NoEquilibrium(f"{what} not decrease further, at an estimated error of {self._error:.2g}")
                return x, self._system.attempt(x), number
            x, here = found
        raise NoEquilibrium(f"the estimated error is {self._error:.2g} after {MOST} iterations")

    def _unbalanced(self, x: np.ndarray, here: Trial) -> float:
        """Record an equilibrium at positions x [m] in `largest`; return the norm of its residual forces relative to the largest
        forces so far."""
        self.largest = self._scale_at(x), max(self.largest[1], here.size)
        return _norm(here.residual) / (self.largest[1] or 1.0)

    def _is_rounding(self, residual: np.ndarray) -> bool:
        """Return True if the displacements under residual forces [N], shape (n, 3), are rounding of the positions."""
        return float(np.abs(self._system.solve(residual)).max()) <= 10.0 * POSITIONS * self._reach

    def _scale_at(self, x: np.ndarray) -> float:
        """Return the largest displacement of the equilibria so far and of positions x [m]."""
        return max(self.largest[0], float(np.abs(x - self._system.rest).max()))

    def _direction(self, here: Trial) -> tuple[np.ndarray, float]:
        """Return the next direction and the derivative of the energy along it [J]."""
        for _ in range(2):
            q, factors = here.residual.copy(), []
            for s, y in reversed(self._changes):
                a = _dot(s, q) / _dot(y, s)
                factors.append(a)
                q -= a * y
            q = self._system.solve(q)
            for (s, y), a in zip(self._changes, reversed(factors), strict=True):
                q += s * (a - _dot(y, q) / _dot(y, s))
            slope = -_dot(here.residual, q)
            if slope < 0.0 or not here.residual.any():
                break
            self._changes = []  # not a descent, by rounding: the factors alone are positive definite
        return q, slope

    def _searched(self, x: np.ndarray, here: Trial, direction: np.ndarray, slope: float) -> tuple[np.ndarray, Trial] | None:
        """Return positions with a lower energy along a direction, and energy and forces there; None if there are none."""
        length, system = 1.0, self._system
        while True:
            there = system.attempt(x + length * direction)
            slope_there = -_dot(there.residual, direction)
            if there.is_valid and not system.has_potential:
                if slope_there <= SLOPE * abs(slope):
                    break
                length *= min(max(slope / (slope - slope_there), 0.1), 0.5)
            elif there.is_valid:
                rise = there.energy - here.energy
                level = max(system.rounding, ROUNDING * abs(here.energy))
                if rise <= DECREASE * length * slope or (rise <= level and abs(slope_there) <= abs(slope)):
                    break
                least = -0.5 * slope * length**2 / max(rise - slope * length, 1e-300)  # of the parabola through both
                length = min(max(least, 0.1 * length), 0.5 * length)
            else:
                length *= 0.5
            if length < SHORTEST:
                return None
        s, y = length * direction, here.residual - there.residual
        if _dot(s, y) > 1e-12 * np.sqrt(_dot(s, s) * _dot(y, y)):
            self._changes = [*self._changes[1 - MEMORY :], (s, y)]
        return x + s, there

    def _factor(self) -> None:
        try:
            self._system.factor()
        except np.linalg.LinAlgError:
            raise NoEquilibrium("the stiffness is far from positive definite") from None
        # the stored changes make up for what approximate factors lack; new ones lack the same
        if not (self._renewed and self._system.is_approximate):
            self._changes = []
        self.has_factors = True


class Minimiser(Search):
    """Finds equilibria of one body, one load step after the other, as minima of its potential energy; arguments as for
    `Search`."""

    def __init__(self, system: ElasticSystem, tolerance: float) -> None:
        super().__init__(system, tolerance)
        self._elastic, self._is_unstable = system, False

    def find(self, told: Callable[[int, float], None], tolerance: float = 0.0) -> Equilibrium:
        """Return the equilibrium under the present loads and prescribed displacements of the system; the last call of
        `attempt` is at its positions.

        told: function that is called in each iteration with its number and the estimated error; tolerance: estimated error
        that is enough, if it is larger than that of this object. Raises NoEquilibrium.
        """
        self._aim(tolerance)
        system = self._elastic
        here = system.attempt(system.position)
        if not (self.has_factors and system.has_factors) or system.has_contact or system.is_approximate:
            self._factor()
        self._changes, self._renewed = [], False
        soft = system.shift > 0.0  # then a linear estimate means little: the length of the first step is searched too
        x = system.position + system.follow(np.zeros_like(here.residual) if soft else here.residual)
        here = system.attempt(x)
        if not here.is_valid:
            raise NoEquilibrium("the linear estimate inverts a point")
        left, done = 0, 0
        while True:
            x, here, done = self._balance(x, here, done, told)
            if (near := system.aligned(x)) is not x:
                x, here = near, system.attempt(near)
            lower = self._lower(x, here) if left < MOST_LEFT else None
            if lower is None:
                if (obstacle := system.obstacle()) is not None:
                    raise NoEquilibrium(obstacle)
                self.has_factors = left < MOST_LEFT
                stability = left > 0, self._is_unstable, system.lowest_frequency()
                return Equilibrium(x, done, self._error, self._unbalanced(x, here), *stability)
            left += 1
            x, here = lower

    def _balance(
        self, x: np.ndarray, here: Trial, done: int, told: Callable[[int, float], None]
    ) -> tuple[np.ndarray, Trial, int]:
        """Iterate from positions x [m], with energy and forces there, to an equilibrium with given volumes; arguments and
        result as for `_minimise`, with the number of all iterations."""
        x, here, used = self._minimise(x, here, done, told)
        done += used
        while self._elastic.corrects(self._goal[0]):
            x, here, used = self._minimise(x, self._elastic.attempt(x), done, told)
            done += used
        return x, here, done

    def _aim(self, tolerance: float) -> None:
        """Set the limits of the errors of a search, see `find`."""
        larger = max(tolerance / self._tolerance, 1.0)
        self._goal = larger * self._tolerance, larger * self._balanced

    def again(self, told: Callable[[int, float], None], tolerance: float = 0.0) -> Equilibrium:
        """Return the equilibrium near the last one, after the loads changed a little; arguments and errors as for `find`. The
        factors of the last equilibrium serve."""
        self._aim(tolerance)
        x = self._elastic.tried.copy()
        x, here, done = self._balance(x, self._elastic.attempt(x), 0, told)
        return Equilibrium(x, done, self._error, self._unbalanced(x, here), False, False, None)

    def unbalanced(self) -> float:
        """Return the norm of the residual forces relative to the largest forces so far, under the present loads at the last
        trial positions."""
        x = self._elastic.tried.copy()
        return self._unbalanced(x, self._elastic.attempt(x))

    def _lower(self, x: np.ndarray, here: Trial) -> tuple[np.ndarray, Trial] | None:
        """Return positions with a lower energy beside an equilibrium at positions x [m] if it is unstable, and energy and
        forces there; None if it is stable. The stiffness is factored at the equilibrium, and its factors serve for the next
        load step, except with contact or approximate factors.

        The energy decreases along the direction of the smallest eigenvalue of the stiffness.
        """
        system = self._elastic
        if system.has_contact or system.is_approximate:
            return None
        self._factor()
        direction = system.unstable_direction()
        self._is_unstable = direction is not None
        if direction is None or not system.has_potential:
            return None
        extent, energy, best = self._extent, here.energy - system.rounding, 0.0
        for sign in (1.0, -1.0):
            size = FIRST_KICK * extent
            while size <= LAST_KICK * extent:
                there = system.attempt(x + sign * size * direction)
                if not there.is_valid or there.energy >= energy:
                    break
                energy, best, size = there.energy, sign * size, 2.0 * size
        x = x + best * direction
        there = system.attempt(x)
        return (x, there) if best else None


def _dot(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.sum(one * other))


def _norm(one: np.ndarray) -> float:
    return float(np.sqrt(np.sum(one**2)))
