"""All rigid bodies of a case, one after the other."""

from collections.abc import Sequence

from pellucid.conditions.rigid_body import RigidBody
from pellucid.energy import StepWork, total_work
from pellucid.parts.active_condition import ActiveCondition


class RigidBodies(ActiveCondition):
    """All rigid bodies of a case. What acts on the nodes has done so before they do, but for contact."""

    def __init__(self, bodies: Sequence[RigidBody], n_columns: int) -> None:
        self._bodies, self._columns = bodies, n_columns

    def begin(self, time: float, dt: float) -> None:
        """What leads each over the step."""
        for body in self._bodies:
            body.leads.begin(time, dt)

    def act_on_nodes(self, dt: float) -> None:
        """Let the nodes about each move as it does."""
        for body in self._bodies:
            body.hold_nodes(dt)
        for body in self._bodies:
            body.nodes.await_contact()

    def work(self) -> StepWork:
        """Of all."""
        return total_work([body.work() for body in self._bodies], self._columns)
