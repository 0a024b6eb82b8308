"""Conditions in a run: the assembly on which they act, and the interface of an active condition."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from pellucid.energy import FIRST_LOAD, Channel, StepWork, no_work
from pellucid.grid.momentum import ExternalAction
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel

NO_AXES = (False, False, False)


class AssembledBody(NamedTuple):
    """A body that is built, its model, and its velocity field; a case without a grid has none."""

    body: Body
    model: BodyModel
    velocity_field: VelocityField | None

    @property
    def thin(self) -> tuple[bool, bool, bool]:
        """Which axes are one cell thick."""
        return self.velocity_field.grid.thin if self.velocity_field else NO_AXES


class Assembly(NamedTuple):
    """The bodies of a case by name, and the external actions on the nodes of their velocity fields."""

    bodies: Mapping[str, AssembledBody]
    external: Mapping[VelocityField, ExternalAction]
    loads: Sequence[Channel]  # the channels of external forces
    n_supports: int

    def column(self, channel: str) -> int:
        """The column of a channel of external forces in the rows of works."""
        return next(load.column for load in self.loads if load.name == channel)

    def no_work(self) -> StepWork:
        """No work, in the layout of the balance of this run."""
        return no_work(FIRST_LOAD + len(self.loads), self.n_supports)


class ActiveCondition(Protocol):
    """A condition, or several of one class, that acts in a run."""

    channels: Sequence[Channel]
    """The channels of its work but for those of external forces."""

    def begin(self, time: float, dt: float) -> None:
        """Set forces or prescribed velocities for the step dt [s] that begins at `time` [s]."""

    def work(self) -> StepWork | None:
        """Its work and impulses over the step; None where nodes or bodies count them."""


def load_channels(names: Sequence[str]) -> tuple[Channel, ...]:
    """The channels of external forces by these names, each with a column of its own in the rows of works."""
    return tuple(Channel(name, 1.0, FIRST_LOAD + number) for number, name in enumerate(dict.fromkeys(names)))
