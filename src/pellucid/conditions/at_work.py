"""What conditions are given to do their work in a run, and what a run asks of them."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from pellucid.bodies.contract import Body
from pellucid.energy import FIRST_LOAD, Channel, StepWork, no_work
from pellucid.grid.momentum import ExternalAction
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts import BodyModel

NO_AXES = (False, False, False)


class Home(NamedTuple):
    """A body that is built, with its model, and the velocity field that it is in; without a grid there is none."""

    body: Body
    model: BodyModel
    field: VelocityField | None

    @property
    def thin(self) -> tuple[bool, bool, bool]:
        """Which axes are one cell thick."""
        return self.field.grid.thin if self.field else NO_AXES


class World(NamedTuple):
    """The bodies of a case by name, and what acts on the nodes of their velocity fields."""

    homes: Mapping[str, Home]
    external: Mapping[VelocityField, ExternalAction]
    loads: Sequence[Channel]  # the channels of external forces
    n_supports: int

    def column(self, channel: str) -> int:
        """The column of a channel of external forces in the rows of works."""
        return next(load.column for load in self.loads if load.name == channel)

    def no_work(self) -> StepWork:
        """Nothing done, as the balance of this run lays it out."""
        return no_work(FIRST_LOAD + len(self.loads), self.n_supports)


class ConditionAtWork(Protocol):
    """A condition, or several of one class, in a run."""

    channels: Sequence[Channel]
    """The channels of its work but for those of external forces."""

    def begin(self, time: float, dt: float) -> None:
        """Act over the step dt [s] that begins at `time` [s]: forces, prescribed velocities."""

    def work(self) -> StepWork | None:
        """What it did over the step, but for what nodes and bodies count themselves."""


def load_channels(names: Sequence[str]) -> tuple[Channel, ...]:
    """The channels of external forces by these names, each with a column of its own in the rows of works."""
    return tuple(Channel(name, 1.0, FIRST_LOAD + number) for number, name in enumerate(dict.fromkeys(names)))
