"""The interface of a condition in a run."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pellucid.energy import Passed, StepWork
from pellucid.parts.step_limit import NO_LIMIT, StepLimit


class ActiveCondition:
    """A condition in a run, or several of one class, which acts at the stages of a step whose methods it defines.

    What it keeps from step to step is in the arrays of a body, which checkpoints hold, or among its `state_numbers`.
    """

    def try_out(self) -> None:
        """All bodies are complete, and nothing is written: raise CaseError where it cannot act."""

    def begin(self, time: float, dt: float) -> None:
        """Set forces or prescribed velocities for the step that begins at `time` [s], over which the time of the loads grows by
        dt [s]: by that of the step, or by nothing while bodies settle or come to rest."""

    def act_on_nodes(self, dt: float) -> None:
        """Give the nodes impulses, after their momentum was advanced over the step dt [s] and before contact.

        See `VelocityField.add_impulses`, which also counts their work.
        """

    def end(self, dt: float) -> None:
        """The bodies have done the step dt [s], and have their totals: renew its own state, and count in the totals what the
        bodies do not know of, half the power of a force that stores energy and what bounds their step."""

    def enter(self, n_steps: int, time: float) -> Sequence[Passed]:
        """The step is in the balance: let points into bodies, which have them in their totals then; what these bring."""
        return ()

    def work(self) -> StepWork | None:
        """Its work and impulses over the step; None where nodes or bodies count them."""
        return None

    def impulses(self) -> Mapping[str, np.ndarray]:
        """Impulses over the step [N s], shape (3,), by the names under which probes find the forces, of what nodes and bodies
        count without a name."""
        return {}

    def step_limit(self) -> StepLimit:
        """What bounds the step, where it is the condition more than the body on which it acts."""
        return NO_LIMIT

    def at_stake(self) -> float:
        """The energy that it stores at the start and could set free [J]."""
        return 0.0

    def warning(self) -> str | None:
        """What a user should know of the step that was done; None where it is as it should be."""
        return None

    def columns(self) -> Mapping[str, float]:
        """What the history shows of it as it is now, by the names of `Condition.columns`, in SI units."""
        return {}

    def state_numbers(self) -> dict[str, Any]:
        """What a checkpoint keeps of its own state, for JSON."""
        return {}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Go on from such numbers, bit for bit."""


class AtEachStep(ActiveCondition):
    """What a function of the time [s] does at the beginning of each step."""

    def __init__(self, act: Callable[[float], object]) -> None:
        self._act = act

    def begin(self, time: float, dt: float) -> None:
        """Do it."""
        self._act(time)
