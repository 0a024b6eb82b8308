"""Paths of equilibria through limit points of the load: the load factor is an unknown, and each equilibrium is at a given
distance along the path from the last one.

All loads are multiplied by the factor. With the stiffness K, which includes that of the loads, the loads F for a factor of 1
and the residual forces r, each correction of positions and factor solves

    K δu - F δλ = r,    t · δu = 0,

by two solutions with the same factors. The second equation keeps the iteration in the plane normal to the tangent t of the
path at the last equilibrium, at the given distance (Riks 1979, Int. J. Solids Struct. 15, 529; Crisfield 1991, Non-linear
Finite Element Analysis of Solids and Structures, vol. 1, section 9.3). Distances are displacements alone, as root mean squares
over the nodes. K is factored in each iteration as it is, also if it is not positive definite. The distance to the next
equilibrium follows the number of iterations (Ramm 1981, in Nonlinear Finite Element Analysis in Structural Mechanics, p. 63).
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from math import sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.errors import Interrupted, RunStopped
from pellucid.parts.body import Body
from pellucid.parts.capabilities import Relaxable
from pellucid.parts.elastic_system import PathSystem
from pellucid.simulation.clock import Clock, renew_loads
from pellucid.simulation.minimum import BALANCED, ROUNDED, NoEquilibrium
from pellucid.step.part import StepPart, StepParts

if TYPE_CHECKING:
    from pellucid.case import TimeCase
    from pellucid.case.steady import SteadyCase

USUAL = 3  # corrections of a step whose length is kept
LONGER = 2.0  # largest ratio of two successive lengths
SMALLEST = 2.0**-10  # shortest length that is tried, over the last one
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


class Limit(NamedTuple):
    """A limit point: an extreme value of the load factor on the path."""

    kind: str  # "maximum" or "minimum"
    factor: float  # load factor, from the cubic between the equilibria before and after
    after: int  # number of the equilibrium before it, counted from 1; 0 for the start


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
        """Of the last search: number of corrections, estimated error and residual forces over all forces."""

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


class PathState(StepPart):
    """State of the path for the history."""

    def __init__(self) -> None:
        self.factor, self.modes = 0.0, 0

    def columns(self) -> Mapping[str, float]:
        return {"load_factor": self.factor, "unstable_modes": float(self.modes)}


class ArcLengthClock(Clock):
    """Clock of a steady analysis that follows the path of equilibria. Each step of the run ends at an equilibrium; the time
    counts them: it is the end time of the case when the load factor reaches 1, or after the number of load steps.

    steady, time, bodies, parts: as for `SteadyClock`; system: energy, forces and stiffness of the body that deforms; follows:
    True if loads depend on the deformation.
    """

    adds_works_of_load_steps = True
    against_energy_error = "Set a larger steady.load_steps"

    def __init__(
        self,
        steady: "SteadyCase",
        time: "TimeCase",
        bodies: Sequence[Body],
        parts: StepParts,
        system: PathSystem,
        follows: bool,
    ) -> None:
        super().__init__(time, parts=parts)
        self.steady, self._bodies, self._step_parts, self._system = steady, bodies, parts, system
        self._relaxed = [body for body in bodies if isinstance(body, Relaxable)]
        self._loads = LoadsOnPath(system, self._renew_loads, follows)
        self._search = PathSearch(system, self._loads, steady.tolerance)
        self._state = PathState()
        parts.add([self._state])
        self._point: PathPoint | None = None  # last equilibrium; None before the first step
        self._length = 0.0  # of the next step along the path
        self._has_arrived = False  # True if the load factor has reached 1
        self.limits: list[Limit] = []
        self.branches: list[int] = []
        """Numbers of the equilibria after which another path branches off, counted from 1; 0 for the start."""
        self.modes: list[int] = []
        """Number of unstable modes of each equilibrium."""
        self.frequencies: list[float | None] = []
        """Lowest natural frequency of each equilibrium [Hz], negative if it is imaginary; None if it is not known."""
        self.corrections: list[int] = []
        """Number of corrections of each equilibrium."""
        self.factors: list[float] = []
        self._told = 0, 0.0  # iteration and load factor of the present search

    def next_step(self, bodies: Sequence[Body]) -> float:
        return self.case.end / self.steady.load_steps

    def span(self, dt: float) -> tuple[float, float]:
        return self.case.end, 0.0

    def pace(self, dt: float) -> None:
        for body in self._relaxed:
            body.relax(1.0, 1.0, 1.0, 1.0)

    def _renew_loads(self) -> None:
        dt = self.next_step(self._bodies)
        self.pace(dt)
        renew_loads(self._bodies, self._step_parts, self.case.end, dt)

    def carry_out(self, dt: float, begin: Callable[[float], None], act: Callable[[float], None]) -> float:
        begin(dt)
        self._loads.factor = self._state.factor
        self._system.scale_loads(self._loads.factor)
        self._system.begin(dt)
        try:
            if self._point is None:
                self._point, distance = self._search.start()
                self._length, self._state.modes = distance / self.steady.load_steps, self._system.unstable_modes
            start = self._point
            end, is_last = self._find(start)
        except NoStart as reason:
            self._system.reject()
            raise RunStopped(f"the path of equilibria cannot start: {reason}\n    {reason.remedy}") from None
        except Interrupted:
            self._system.reject()
            raise
        self._has_arrived = is_last
        self._record(start, end, dt)
        return dt

    def _find(self, start: PathPoint) -> tuple[PathPoint, bool]:
        """Return the next equilibrium, and whether the load factor reaches 1 there. Raises RunStopped if none is found."""
        longest = length = self._length
        while True:
            try:
                end = self._search.next(start, length, self._tell)
                corrections, is_last = self._search.corrections, False
                span = Span(start, end)
                if len(span.limits(self._least(end))) > 1 and 0.5 * length >= SMALLEST * longest:
                    raise NoEquilibrium("the load factor has two limit points in one step")  # shorter steps tell if they exist
                if (share := span.first_at(1.0)) is not None:
                    near = PathPoint(span.position(share), 1.0, end.along, end.rate)
                    end, is_last = self._search.at_factor(start, near, self._tell), True
                self._length = length * min(max(sqrt(USUAL / max(corrections, 1)), 1.0 / LONGER), LONGER)
                return end, is_last
            except NoEquilibrium as reason:
                self._system.reject()
                length *= 0.5
                if length < SMALLEST * longest:
                    if not self.factors:
                        raise RunStopped(
                            f"the first equilibrium on the path is not found ({reason})\n    Hold the body by [[support]]s, so "
                            "that the loads cannot move it as a whole."
                        ) from None
                    raise RunStopped(
                        f"equilibrium {self.n_steps + 1}: the path of equilibria does not continue ({reason}) after the load "
                        f"factor {start.factor:.6g}\n    Set more `steady.load_steps`: steps are then shorter."
                    ) from None

    def _least(self, end: PathPoint) -> float:
        """Return the smallest difference of the load factors of two limit points in the span before an equilibrium."""
        return self.steady.tolerance * max(map(abs, (*self.factors, end.factor)))

    def _record(self, start: PathPoint, end: PathPoint, dt: float) -> None:
        """Move the body to the next equilibrium, and record its stability and the limit points on the way."""
        span = Span(start, end)
        modes, frequency = self._system.unstable_modes, self._system.signed_frequency()
        self._search.keep(end)
        self._system.accept_on_path(end.position, *span.ends, self._loads_at(span.factor(0.5)), dt)
        self._loads.factor = end.factor
        self._loads.renew()
        self.modes.append(modes)
        self.frequencies.append(frequency)
        self.corrections.append(self._search.corrections)
        self.factors.append(end.factor)
        number, limits = len(self.factors), span.limits(self._least(end))
        between = f"between equilibria {number - 1} and {number}" if number > 1 else "between the start and equilibrium 1"
        if abs(modes - self._state.modes) > len(limits):
            self.branches.append(number - 1)
            warnings.warn(
                f"{between} (load factors {start.factor:.6g} and {end.factor:.6g}) the stability changes without a limit "
                "point: another path branches off; a small load in the direction of the buckling mode, or an imperfect shape, "
                "leads to it",
                stacklevel=2,
            )
        for kind, share in limits:
            self.limits.append(Limit(kind, span.factor(share), number - 1))
            warnings.warn(
                f"{between} the load factor has a {kind} of {span.factor(share):.6g} (limit point); under given loads the body "
                "would leave the path there",
                stacklevel=2,
            )
        self._state.factor, self._state.modes, self._point = end.factor, modes, end

    def _loads_at(self, factor: float) -> Callable[[], None]:
        """Return a function that computes the loads of a factor at the present positions of the nodes."""

        def load() -> None:
            kept, self._loads.factor = self._loads.factor, factor
            self._loads.renew()
            self._loads.factor = kept

        return load

    def _tell(self, iteration: int, factor: float) -> None:
        self._told = iteration, factor
        self.on_the_way()

    def advance(self, dt: float) -> None:
        self.n_steps += 1
        before, number = self.time, self.n_steps
        is_last = self._has_arrived or number >= self.steady.load_steps
        self.time = self.case.end if is_last else number * self.case.end / self.steady.load_steps
        self.dt, self.weight = dt, (self.time - before) / dt
        if is_last and not self._has_arrived:
            warnings.warn(
                f"the path of equilibria ends at the load factor {self._state.factor:.6g}, before all loads act; to follow it "
                "further, set more steady.load_steps",
                stacklevel=2,
            )

    def search(self) -> str:
        iteration, factor = self._told
        return f"equilibrium {self.n_steps + 1}: iteration {iteration}, load factor {factor:.4g}"

    # results and checkpoint

    def facts(self) -> dict[str, Any]:
        limits = [{"kind": kind, "load_factor": factor, "after_equilibrium": after} for kind, factor, after in self.limits]
        found = {"method": "factored", "control": "arc-length", "load_factors": self.factors, "limit_points": limits}
        found |= {
            "branches_after_equilibria": self.branches,
            "unstable_modes": self.modes,
            "lowest_frequencies": self.frequencies,
            "steps": self.corrections,
        }
        own = {"estimated_error": self._search.error, "unbalanced_force": self._search.unbalanced}
        return {"steady": {**found, "reached_full_load": self._has_arrived, **own}}

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {} if self._point is None else {"along": self._point.along, "reached": self._point.position}

    def state_numbers(self) -> dict[str, Any]:
        own: dict[str, Any] = {name: list(getattr(self, name)) for name in LISTS}
        own |= {"limits": [list(limit) for limit in self.limits]}
        own |= {"length": self._length, "has_arrived": self._has_arrived, "largest_so_far": self._search.largest}
        own |= {"error": self._search.error, "unbalanced": self._search.unbalanced}
        if self._point is not None:
            own["rate"] = self._point.rate
        return {**super().state_numbers(), **own}

    def restore(self, numbers: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(numbers, arrays)
        for name in LISTS:
            setattr(self, name, list(numbers[name]))
        self.limits = [Limit(*limit) for limit in numbers["limits"]]
        self._length, self._has_arrived = numbers["length"], numbers["has_arrived"]
        self._search.largest = tuple(numbers["largest_so_far"])
        self._search.error, self._search.unbalanced = numbers["error"], numbers["unbalanced"]
        if self.factors:
            self._state.factor, self._state.modes = self.factors[-1], self.modes[-1]
            self._point = PathPoint(arrays["reached"].copy(), self.factors[-1], arrays["along"].copy(), numbers["rate"])


LISTS = "branches", "modes", "frequencies", "corrections", "factors"


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
