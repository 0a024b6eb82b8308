"""Paths of equilibria through limit points of the load: the load factor is an unknown, and each equilibrium is at a given
distance along the path from the last one.

The distance to the next equilibrium follows the number of corrections of the last one (Ramm 1981, in Nonlinear Finite Element
Analysis in Structural Mechanics, p. 63); for the search see `pellucid.simulation.path_search`.
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
from pellucid.simulation.minimum import NoEquilibrium
from pellucid.simulation.path_search import LoadsOnPath, NoStart, PathPoint, PathSearch, Span
from pellucid.step.part import StepPart, StepParts

if TYPE_CHECKING:
    from pellucid.case import TimeCase
    from pellucid.case.steady import SteadyCase

USUAL = 3  # corrections of a step whose length is kept
LONGER = 2.0  # largest ratio of two successive lengths
SMALLEST = 2.0**-10  # shortest length that is tried, over the last one
LISTS = "branches", "modes", "frequencies", "corrections", "factors"


class Limit(NamedTuple):
    """A limit point: an extreme value of the load factor on the path."""

    kind: str  # "maximum" or "minimum"
    factor: float  # load factor, from the cubic between the equilibria before and after
    after: int  # number of the equilibrium before it, counted from 1; 0 for the start


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
