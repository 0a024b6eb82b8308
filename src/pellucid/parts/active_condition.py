"""The interface of a condition in a run."""

from collections.abc import Callable

from pellucid.energy import StepWork


class ActiveCondition:
    """A condition in a run, or several of one class, which acts at the stages of a step whose methods it defines.

    It keeps nothing from step to step but in the arrays of a body, which checkpoints hold.
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

    def work(self) -> StepWork | None:
        """Its work and impulses over the step; None where nodes or bodies count them."""
        return None


class AtEachStep(ActiveCondition):
    """What a function of the time [s] does at the beginning of each step."""

    def __init__(self, act: Callable[[float], object]) -> None:
        self._act = act

    def begin(self, time: float, dt: float) -> None:
        """Do it."""
        self._act(time)
