"""Simulated time and choice of the time step."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.case.spec import MOST_STEPS, STEP_MARGIN
from pellucid.energy import StepWork
from pellucid.errors import CaseError, Problem, RunStopped
from pellucid.parts.body import Body, in_metres
from pellucid.step.limit import NO_LIMIT, StepLimit, fall_through_cells, tightest
from pellucid.step.part import StepParts


def fastest_point(bodies: Iterable[Body]) -> tuple[str, dict[str, Any]]:
    """Return a description of the fastest point of the bodies, and its data for `RunStopped` (body, number of the point,
    position [m]); both empty if nothing moves. A point whose velocity is not finite counts as fastest."""
    found: tuple[float, Body, int] | None = None
    for body in bodies:
        speed = np.linalg.norm(body.stored_field("velocity"), axis=1)
        speed[np.isnan(speed)] = np.inf
        p = int(np.argmax(speed))
        if speed[p] > (found[0] if found else 0.0):
            found = float(speed[p]), body, p
    if found is None:
        return "", {}
    speed, body, p = found
    point, position = int(body.stored_field("id")[p]), body.stored_field("position")[p]
    words = f"fastest point: number {point} of body `{body.name}` at {in_metres(position)}, {speed:.4g} m/s"
    return words, {"body": body.name, "point": point, "position": position.tolist()}


if TYPE_CHECKING:
    from pellucid.case import TimeCase

COLLAPSED = 1e-6  # fraction of the largest step so far, below which a step stops the run


def renew_loads(bodies: Iterable[Body], parts: StepParts, time: float, dt: float) -> None:
    """Compute the loads at a time [s] for the present positions of the bodies, in a step dt [s]; parts: parts of the step."""
    for body in bodies:
        body.begin(dt)
    parts.run("begin", time, 0.0)


class Clock:
    """Counter of steps and simulated time, which chooses the length of each step.

    The stable step of a body is h/(c + |v|) for the cell size h, the wave speed c, which artificial viscosity increases, and
    the speed |v|, or h²ρ/(2(2μ+λ)) for the density ρ and the viscosities μ and λ. The step is also limited by the parts of
    the step, and by the time of fall through a cell. Steps that are not fixed are also limited by `StepPart.longest_step`.

    longest: time of fall through a cell [s]; most: largest step allowed by the output, if bodies can take longer ones
    [s]; parts: parts of the step.
    """

    def __init__(self, case: "TimeCase", longest: float = inf, most: float = inf, parts: StepParts | None = None) -> None:
        self.case = case
        self.longest, self.most, self.parts = longest, most, parts
        self.n_steps = 0
        self.time = 0.0
        self.dt = 0.0
        self.largest = 0.0
        self._fixed_from = (0, 0.0)
        """Number of steps and time [s] at which fixed steps got their present length."""
        self.weight = 1.0
        """Factor by which the impulses of the last step are multiplied before they are added to the total reactions."""
        self.missed: str | None = None
        """Reason why the run must end before its goal is reached, although the state is valid and stored; None otherwise."""

    @property
    def is_last_try(self) -> bool:
        """True if the coming step is the last one that the run may take to reach its goal, such as a steady state."""
        return False

    def next_step(self, bodies: Sequence[Body]) -> float:
        """Return the length of the coming step [s]; the last step ends at the end of the case.

        Raises CaseError (before the first step) or RunStopped if a fixed step is not stable, or if the stable step has
        collapsed. Raises CaseError if the first step is so small that the end of the case cannot be reached.
        """
        limit, body = self.stable_step(bodies)
        if self.case.step is not None:
            self._check_fixed(self.case.step, limit)
            steps, time = self._fixed_from
            remaining = (self.case.end - time) / self.case.step - (self.n_steps - steps)
            return self.case.step if remaining > 1.0 - 1e-9 else remaining * self.case.step
        stable = min(self.case.courant * limit.step, self.most, self.case.end)
        dt = stable if self.parts is None else min(stable, self.parts.longest_step())
        self.check_collapse(dt, limit, [body] if body else bodies)
        if self.n_steps == 0 and self.case.end > MOST_STEPS * stable:
            text = (
                f"the time step, limited by {limit.reason}, is {stable:.3g} s, which requires more than {MOST_STEPS:.0e} steps "
                f"until time.end = {self.case.end:g} s"
            )
            remedy = "Set a larger time.courant, or an earlier time.end."
            raise CaseError(Problem(text, "time.courant", self.case.courant, remedy))
        remaining = self.case.end - self.time
        if remaining <= dt * (1.0 + 1e-9):
            return remaining
        return min(dt, 0.5 * remaining)  # no sliver at the end

    def stable_step(self, bodies: Sequence[Body]) -> tuple[StepLimit, Body | None]:
        """Return the limit of the stable step in the present state: the smallest limit of the bodies, the parts of the step
        and free fall; and the limiting body, None if no body limits it. The reason given here for a body is only its name,
        see `limit`."""
        body = max(bodies, key=lambda body: body.totals.rate)
        own = 1.0 / body.totals.rate if body.totals.rate > 0.0 else inf
        of_parts = NO_LIMIT if self.parts is None else self.parts.step_limit()
        other = tightest([of_parts, fall_through_cells(self.longest)])
        if other.step <= own and other.step < inf:
            return other, None
        return StepLimit(own, "wave", f"body `{body.name}`"), body

    def limit(self, bodies: Sequence[Body]) -> tuple[StepLimit, str]:
        """Return the limit of the stable step in the present state with its full reason, and the name of the limiting
        body; an empty name if no body limits it."""
        limit, body = self.stable_step(bodies)
        return (limit, "") if body is None else (body.step_limit(), body.name)

    def check_collapse(self, dt: float, limit: StepLimit, bodies: Sequence[Body]) -> None:
        """Raise RunStopped if the coming step dt [s] is negligible compared with the largest step so far; limit: limit of
        the step with its reason; bodies: the limiting body, or all bodies if no body limits the step."""
        self.largest = max(self.largest, dt)
        if dt < COLLAPSED * self.largest:
            words, place = fastest_point(bodies)
            raise RunStopped(
                f"step {self.n_steps}, time {self.time:.6g} s: the stable time step, limited by {limit.reason}, has decreased "
                f"to {dt:.3g} s, "
                f"less than {COLLAPSED:g} of the largest so far ({self.largest:.3g} s), because velocities or stiffnesses grow "
                f"without bound{', ' * bool(words)}{words}\n    Check the loads and conditions there. Set a smaller "
                "time.courant, or apply loads more slowly.",
                **({"body": bodies[0].name} if len(bodies) == 1 else {}) | place,
            )

    def span(self, dt: float) -> tuple[float, float]:
        """Return the time [s] from which, and the interval [s] over which, the loads act in the coming step; dt: length of the
        step [s]."""
        return self.time, dt

    def pace(self, dt: float) -> None:
        """Set the damping and the load rate (increment of the time of the loads over the length of the step) of the bodies
        for the coming step dt [s]. This method of the base class sets nothing: without relaxation, bodies move by their own
        inertia."""

    def carry_out(self, dt: float, begin: Callable[[float], None], act: Callable[[float], None]) -> float:
        """Carry out the coming step dt [s] and return its length [s], which may be shorter.

        begin: function that prepares bodies and conditions for a step of this length; act: function that advances the bodies.
        """
        begin(dt)
        act(dt)
        return dt

    def advance(self, dt: float) -> None:
        """Count a completed step of the length dt [s] and advance the simulated time."""
        self.n_steps += 1
        self.dt = dt
        fixed = self.case.step
        steps, time = self._fixed_from
        self.time = time + (self.n_steps - steps) * fixed if fixed is not None and dt == fixed else self.time + dt
        if self.case.end - self.time < 1e-9 * dt:
            self.time = self.case.end

    def finished(self, until: float | None) -> bool:
        """Return True if the simulated time has reached the end of the case, or `until` [s] if it is given."""
        return self.case.reached(self.time) or (until is not None and self.time >= until)

    def _check_fixed(self, step: float, limit: StepLimit) -> None:
        if step <= limit.step * (1.0 + STEP_MARGIN):
            return
        text = f"the largest stable step is {limit.step:.4g} s, limited by {limit.reason}"
        remedy = f"Set `time.step` to at most {0.8 * limit.step:.2g} s, or remove it: `time.courant` then sets the step."
        if self.n_steps == 0:
            raise CaseError(Problem(text, "time.step", step, remedy))
        text = f"time.step = {step:g} s is not stable any more: {text}"
        raise RunStopped(f"step {self.n_steps}, time {self.time:.6g} s: {text}\n    {remedy}")

    against_energy_error: str | None = None
    """Remedy for an energy error, if it is not a smaller step; None otherwise."""

    def counts(self, body: Body) -> bool:
        """Return True if `works_of_step` includes the works of this body with its own nodes."""
        return False

    def works_of_step(self, on_grid: StepWork) -> StepWork:
        """Return the works and impulses of the bodies on the grid in the completed step; on_grid: those of its last act."""
        return on_grid

    adds_works_of_load_steps = False
    """True if works are sums over large load steps: their error shows in the energy balance, and affects nothing else."""

    is_adjusting = False
    """True while the clock changes contact forces at constant loads; the energy balance is not checked then."""

    on_the_way: Callable[[], None] = staticmethod(lambda: None)
    """Function that is called several times in a long step, to show the progress; it raises Interrupted after a signal."""

    def search(self) -> str:
        """Return the state of the search for an equilibrium as text; empty for motion in time."""
        return ""

    def progress(self) -> float:
        """Return the simulated time, which shows the progress of the run [s]."""
        return self.time

    def facts(self) -> dict[str, Any]:
        """Return entries about the time stepping for the summary of the run, by name."""
        return {}

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays of the clock for a checkpoint, by name."""
        return {}

    def state_numbers(self) -> dict[str, Any]:
        """Return the numbers of the clock for a checkpoint, by name."""
        kept = {"n_steps": self.n_steps, "time": self.time, "dt": self.dt, "largest": self.largest}
        return {**kept, "fixed_from": list(self._fixed_from), "fixed": self.case.step}

    def ready(self, numbers: Mapping[str, Any]) -> None:
        """Prepare the bodies for the state of a checkpoint, before it is restored; numbers: as returned by `state_numbers`."""

    def restore(self, numbers: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the state of the clock from a checkpoint; numbers, arrays: as returned by `state_numbers` and
        `state_arrays`."""
        self.n_steps, self.time = numbers["n_steps"], numbers["time"]
        self.dt, self.largest = numbers["dt"], numbers["largest"]
        steps, time = numbers["fixed_from"]
        same = numbers["fixed"] == self.case.step
        self._fixed_from = (int(steps), float(time)) if same else (self.n_steps, self.time)
