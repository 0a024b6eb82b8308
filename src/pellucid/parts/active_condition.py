"""Interface of a condition in a run, which a new kind of condition implements."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pellucid.energy import Passed, StepWork
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.step_limit import NO_LIMIT, StepLimit


class ActiveCondition:
    """A condition in a run, or several conditions of one class: base class whose methods are called at the stages of a
    step; a condition overrides the methods of those stages at which it acts.

    The state of a condition is stored in arrays of a body, which checkpoints include, or in the `state_numbers` of the
    condition.
    """

    def try_out(self) -> None:
        """Raise CaseError if the condition cannot act in this case. Called when all bodies are complete, before output is
        written."""

    def begin(self, time: float, dt: float) -> None:
        """Set forces or prescribed velocities for the step that begins at `time` [s].

        dt: increment of the time of the loads in this step [s]; 0 while bodies settle or are relaxed.
        """

    def act_on_nodes(self, dt: float) -> None:
        """Apply impulses to the grid nodes, after their momentum was advanced by a step dt [s] and before contact.

        Use `VelocityField.add_impulses`, which also computes the work of the impulses.
        """

    pushed_fields: Sequence[VelocityField] | None = None
    """Velocity fields to which `act_on_nodes` may apply impulses; None for all. The works of other fields are computed with
    their momentum."""

    def end(self, dt: float) -> None:
        """Update the state of the condition after the bodies have completed the step dt [s] and computed their totals (sums of
        mass, momentum and energies).

        The condition also adds to the totals what the bodies cannot compute: half the power of a force that stores energy,
        and the step limit due to it.
        """

    def enter(self, n_steps: int, time: float) -> Sequence[Passed]:
        """Insert points into bodies after the energy balance of step `n_steps`, which ended at `time` [s]; return their number,
        mass, momentum and energy.

        The totals of the bodies already include these points.
        """
        return ()

    def work(self) -> StepWork | None:
        """Return the works [J] and the impulse [N s] of the condition over the step as a `StepWork`; None if the nodes or
        bodies on which the condition acts compute these values."""
        return None

    def impulses(self) -> Mapping[str, np.ndarray]:
        """Return the impulses of the condition over the step [N s], shape (3,) each, by the names under which probes read
        these impulses; empty if the nodes and bodies on which the condition acts report them by name."""
        return {}

    def step_limit(self) -> StepLimit:
        """Return the limit of the time step that the condition requires in addition to the limits of the bodies; NO_LIMIT
        if there is none."""
        return NO_LIMIT

    def at_stake(self) -> float:
        """Return the energy that the condition stores at the start and could release [J]. This energy is added to the
        reference with which the error of the energy balance is compared."""
        return 0.0

    def warning(self) -> str | None:
        """Return a warning of the condition about the last step, as text for the user; None if there is none."""
        return None

    def columns(self) -> Mapping[str, float]:
        """Return the current values of the columns that the condition adds to the history (the table of values over time), by
        the names of `Condition.columns`, in SI units."""
        return {}

    def state_numbers(self) -> dict[str, Any]:
        """Return the state of the condition for a checkpoint, as JSON data."""
        return {}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Restore the state of the condition from numbers of `state_numbers`, bit for bit."""


class AtEachStep(ActiveCondition):
    """A condition that calls a function of the time [s] at the beginning of each step."""

    def __init__(self, act: Callable[[float], object]) -> None:
        self._act = act

    def begin(self, time: float, dt: float) -> None:
        self._act(time)
