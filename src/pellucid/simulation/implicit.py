"""Motion in time by implicit steps, for bodies with their own nodes and a factored stiffness."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.case.sections import parts_of
from pellucid.errors import Interrupted, RunStopped
from pellucid.parts.body import Body
from pellucid.parts.condition import Condition
from pellucid.parts.elastic_system import HasMovingSystem, MovingSystem
from pellucid.simulation.clock import Clock, renew_loads
from pellucid.simulation.implicit_step import ImplicitStep
from pellucid.simulation.minimum import Equilibrium, NoEquilibrium, Search
from pellucid.step.part import StepParts

if TYPE_CHECKING:
    from pellucid.case import Case, TimeCase

TOLERANCE = 1e-8  # estimated error of the positions in the middle of a step, over the largest displacement from its start
SMALLEST = 1.0 / 64.0  # of `time.step`: smallest part that is tried
FEW = 16  # iterations up to which the factors serve for the next step: a factorisation costs as much as about twenty


class ImplicitClock(Clock):
    """Clock of a run in implicit steps of the length `time.step`. If a search fails, such a step is divided into several steps
    of the run.

    time: table of the case; bodies, parts: all bodies, and the parts of the step; systems: energy, forces, stiffness and
    inertia of the bodies; follows: True if loads depend on the deformation.
    """

    def __init__(
        self, time: "TimeCase", bodies: Sequence[Body], parts: StepParts, systems: Sequence[MovingSystem], follows: bool
    ) -> None:
        super().__init__(time, parts=parts)
        self._bodies, self._step_parts, self._follows = bodies, parts, follows
        self._steps = [ImplicitStep(system) for system in systems]
        self._searches = [Search(step, TOLERANCE) for step in self._steps]
        self._from, self._whole = 0.0, 0  # time from which steps have their present length [s], and number of steps since
        self._part, self._share = 0.0, 1.0  # of the present step: part that is done, and part to try next
        self._recalled: Mapping[str, np.ndarray] = {}  # positions at which the factors of a checkpoint were computed
        self._kept = [self._factors(number) for number in range(len(systems))]  # factors for the next step
        self.iterations, self.halved = 0, 0
        """Numbers of iterations, and of steps that were halved."""

    def next_step(self, bodies: Sequence[Body]) -> float:
        return min(self._share, 1.0 - self._part) * self._length()

    def _length(self) -> float:
        """Return the length of the present step, of which a part may be done [s]; the last one ends at the end of the case."""
        step = self.case.step or self.case.end
        left = self.case.end - (self._from + self._whole * step)
        return step if left > step * (1.0 - 1e-9) else left

    def carry_out(self, dt: float, begin: Callable[[float], None], act: Callable[[float], None]) -> float:
        while True:
            begin(dt)
            for step in self._steps:
                step.begin(dt)
            renew = partial(self._renew_loads, self.time, dt)
            renew(0.5)
            for step in self._steps:
                step.take_loads(renew, self._follows)
            try:
                found = [self._find(number) for number in range(len(self._steps))]
            except NoEquilibrium as reason:
                dt = self._retry(dt, str(reason))
                continue
            except Interrupted:
                self._reject()
                raise
            for number, (step, middle) in enumerate(zip(self._steps, found, strict=True)):
                step.arrive(middle.position)
                self._searches[number].has_factors &= step.system.keeps_factors
                self._kept[number] = self._factors(number)
                self.iterations += middle.iterations
            return dt

    def _renew_loads(self, start: float, dt: float, share: float) -> None:
        """Compute the loads for the present positions of the bodies at a share of a step dt [s] that begins at the time `start`
        [s]."""
        renew_loads(self._bodies, self._step_parts, start + share * dt, dt)

    def _find(self, number: int) -> Equilibrium:
        step, search = self._steps[number], self._searches[number]
        if (recalled := self._recalled.get(_name(number))) is not None:
            step.factor_at(recalled)
            search.has_factors = True
            self._recalled = {name: array for name, array in self._recalled.items() if name != _name(number)}
        search.has_factors = search.has_factors and step.fits
        return search.near(step.starts(), self._tell, FEW)

    def _factors(self, number: int) -> np.ndarray | None:
        """Return the positions at which the factors for the next step were computed [m], shape (n, 3), or None."""
        return self._steps[number].factored_at if self._searches[number].has_factors else None

    def _tell(self, iteration: int, error: float) -> None:
        self.on_the_way()

    def _retry(self, dt: float, reason: str) -> float:
        """Restore the start of a step dt [s] after a failed search; return the next, shorter step [s]. Raises RunStopped if it
        would be too short."""
        self._reject()
        self.halved += 1
        self._share = 0.5 * dt / self._length()
        if self._share < SMALLEST:
            text = f"the equations of an implicit step of {dt:.3g} s have no solution that could be found ({reason})"
            remedy = "Set a smaller `time.step`, or apply loads more slowly. If this does not help, the load crushes the body"
            raise RunStopped(f"step {self.n_steps}, time {self.time:.6g} s: {text}\n    {remedy}.")
        return 0.5 * dt

    def _reject(self) -> None:
        """Restore the start of the step."""
        for step, search in zip(self._steps, self._searches, strict=True):
            step.system.reject()
            search.has_factors = False

    def advance(self, dt: float) -> None:
        self.n_steps += 1
        self.dt, length = dt, self._length()
        self._part, self._share = self._part + dt / length, min(2.0 * dt / length, 1.0)
        step = self.case.step or self.case.end
        if self._part >= 1.0 - 1e-9:
            self._whole, self._part = self._whole + 1, 0.0
            if length < step:  # the run may go on with a later end
                self._from, self._whole = self._from + (self._whole - 1) * step + length, 0
        self.time = self._from + self._whole * step + self._part * length
        if self.case.end - self.time < 1e-9 * dt:
            self.time = self.case.end

    def facts(self) -> dict[str, Any]:
        found = {"iterations": self.iterations, "halved_steps": self.halved}
        return {"implicit": {**found, "factorisations": sum(step.factorisations for step in self._steps)}}

    # checkpoint: the factors are computed again from the positions of the nodes where they were computed

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {_name(number): array for number, array in enumerate(self._kept) if array is not None}

    def state_numbers(self) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in OWN}
        of_bodies = {
            "largest_so_far": [search.largest for search in self._searches],
            "in_single": [step.system.in_single for step in self._steps],
            "factorisations": [step.factorisations for step in self._steps],
            "weights": [step.weight for step in self._steps],
        }
        return {**super().state_numbers(), **own, **of_bodies}

    def restore(self, numbers: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(numbers, arrays)
        for name in OWN:
            setattr(self, name, numbers[name])
        if numbers["fixed"] != self.case.step:
            self._from, self._whole, self._part, self._share = self.time, 0, 0.0, 1.0
        for number, (step, search) in enumerate(zip(self._steps, self._searches, strict=True)):
            search.largest = tuple(numbers["largest_so_far"][number])
            step.system.in_single = numbers["in_single"][number]
            step.factorisations = numbers["factorisations"][number]
            self._kept[number] = arrays.get(_name(number))
        self._recalled = {name: array for name, array in arrays.items() if numbers["fixed"] == self.case.step}


OWN = "_from", "_whole", "_part", "_share", "iterations", "halved"


def _name(number: int) -> str:
    """Return the name of the array of a checkpoint with the positions at which the stiffness of a body was factored."""
    return f"factored-{number}"


def implicit_clock(case: "Case", bodies: Sequence[Body], parts: StepParts) -> ImplicitClock:
    """Return the clock of a case with implicit time steps."""
    systems = [body.moving_system() for body in bodies if isinstance(body, HasMovingSystem)]
    follows = any(condition.kind_of_load() == "follower" for condition in parts_of(case).of(Condition))
    return ImplicitClock(case.time, bodies, parts, systems, follows)
