"""The interface of the model of a condition."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Self

from pellucid.energy import Channel
from pellucid.findings import Reason
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Part, Parts
from pellucid.parts.step_limit import Cause

if TYPE_CHECKING:
    from pellucid.parts.assembly import Assembly


class Swing(NamedTuple):
    """How bodies swing on a condition, in a word and in a clause."""

    cause: Cause = "spring"
    reason: str = "it swings on what acts on it"


class Condition(Part):
    """An external action on bodies or nodes, or between bodies. A new one is a subclass, and a key of the case."""

    swings_as: ClassVar[Swing] = Swing()  # where `swing_of` bounds the step
    losses: ClassVar[Sequence[Channel]] = ()  # the channels of its other work and losses, where its keys do not change these

    def load_channel(self) -> str | None:
        """The name of the channel of its external forces, if it has such: a column of the history, ending in `_work`."""
        return None

    def channels(self) -> Sequence[Channel]:
        """The channels of its other work and losses."""
        return self.losses

    def columns(self) -> Mapping[str, str]:
        """The columns of the history that show its state, with their SI units."""
        return {}

    def swing_of(self, body: BodyModel, rate: float, cell: float | None) -> float:
        """How fast a body at the start, whose own steps are 1/rate [s] at most, swings on it besides, as far as their models
        tell, in cells of this edge [m] if there are any: a rate that is added to the own one as squares are [1/s]."""
        return 0.0

    def why_not_steady(self) -> Reason | None:
        """Why bodies under it cannot come to rest by dynamic relaxation, if they cannot."""
        return None

    def in_case(self, bodies: Sequence[BodyModel], conditions: "Sequence[Condition]", thin: tuple[bool, bool, bool]) -> Self:
        """Return the condition as it acts in a case with these bodies and conditions, on a grid with these thin axes."""
        return self

    @classmethod
    def activate(cls, conditions: Sequence[Self], assembly: "Assembly") -> Sequence[ActiveCondition]:
        """What acts for all conditions of this class in a run; nothing where they only mark nodes or pairs at the start.

        It is called once for each class that a case can have, in the order of its keys, also where there are no conditions.
        It asks for the actions on nodes that it needs through the bodies of the assembly.
        """
        return ()

    def reaction(self) -> str | None:
        """The name under which probes find the force that it exerts, if it has one."""
        return None

    def turning_reaction(self, parts: Parts) -> str | None:
        """The name under which probes find the torque that it exerts on a rigid body about its centre of mass, if it does."""
        return None

    def constrains_face(self, face: str) -> bool:
        """Return True if it constrains the nodes of a face of the grid, such as "x-lower", along any direction."""
        return False

    def face_velocity(self, face: str) -> tuple[float, float, float] | None:
        """The velocity [m/s] of the nodes of a face of the grid, if it constrains them along its normal."""
        return None

    def opens_face(self, face: str) -> bool:
        """Return True if material flows through a face of the grid by this condition."""
        return False

    def prescribed_axes(self, body: str) -> set[int]:
        """The axes along which a body as a whole follows it."""
        return set()


def conditions_in_case(parts: Parts) -> list[Condition]:
    """Return the sound conditions of a case as they act in it."""
    conditions, bodies = parts.of(Condition), parts.of(BodyModel)
    x, y, z = parts.active_axes
    return [condition.in_case(bodies, conditions, (not x, not y, not z)) for condition in conditions]


def is_driven(body: str, parts: Parts) -> bool:
    """Return True if a body as a whole follows a prescribed motion along every axis that counts: it is rigid then."""
    grid = parts.grid
    free = {axis for axis in range(3) if grid is None or not grid.thin()[axis]}
    return any(free <= condition.prescribed_axes(body) for condition in parts.of(Condition))
