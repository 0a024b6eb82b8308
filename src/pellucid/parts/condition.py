"""Interface of the model of a condition in a case, which a new kind of condition implements."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple, Self

from pellucid.energy import Channel
from pellucid.findings import Reason
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Part, Parts
from pellucid.step.limit import Cause
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.parts.assembly import Assembly


LoadKind = Literal["dead", "follower", "contact", "volume", "other"]


class Swing(NamedTuple):
    """Texts for the step limit of bodies that oscillate against the elastic force of a condition: cause as a word
    (`StepLimit.cause`), and reason as a phrase for the user."""

    cause: Cause = "spring"  # word for the cause, as in `StepLimit`
    reason: str = "it oscillates under this condition"


class Condition(Part):
    """An external action on bodies or nodes, or between bodies. A new condition is a subclass, and a key of the case."""

    swings_as: ClassVar[Swing] = Swing()  # description of the step limit that follows from `swing_of`
    load_kind: ClassVar[LoadKind] = "other"
    """Forces on bodies with their own nodes in an equilibrium: "dead" if they do not depend on the deformation of the bodies,
    or if there are none; "follower" if they depend on the present positions of the nodes only; "contact" if they are forces
    between surfaces; "volume" if they are a pressure in a membrane, which depends on the enclosed volume
    (`pellucid.conditions.enclosed.steady`)."""
    losses: ClassVar[Sequence[Channel]] = ()  # channels of work and losses, in addition to `load_channel`

    def load_channel(self) -> str | None:
        """Return the name of the channel (entry of the energy balance) of the condition's external forces, which is a
        column of the history ending with `_work`, or None."""
        return None

    def channels(self) -> Sequence[Channel]:
        """Return the channels (entries of the energy balance) for works and losses of the condition, except the channel
        `load_channel`."""
        return self.losses

    def columns(self) -> Mapping[str, str]:
        """Return names and SI units of the columns of the history (the table of values over time) that show the state of the
        condition."""
        return {}

    def swing_of(self, body: BodyModel, rate: float, cell: float | None) -> float:
        """Return the rate [1/s] of the oscillation of a body on the elastic force of the condition at the start, estimated from
        the models: the largest stable step for this oscillation alone is 1/rate.

        rate: the corresponding rate of the body itself; the squares of both rates are added. cell: edge length of the cells
        [m], or None.
        """
        return 0.0

    def why_not_steady(self) -> Reason | None:
        """Return the reason why bodies under this condition cannot come to rest by dynamic relaxation, or None."""
        return None

    def kind_of_load(self) -> LoadKind:
        """Return the kind of the forces of this condition in an equilibrium, by default that of all conditions of the class."""
        return self.load_kind

    def why_not_factored(self) -> Reason | None:
        """Return the reason why equilibria with a pressure that depends on the enclosed volume cannot be found with a factored
        stiffness, or None."""
        return None

    def in_case(self, bodies: Sequence[BodyModel], conditions: "Sequence[Condition]", thin: tuple[bool, bool, bool]) -> Self:
        """Return the condition as it acts in a case with these bodies and conditions, e.g. with defaults that depend on
        other parts of the case; thin: True for axes along which the grid is one cell thick."""
        return self

    @classmethod
    def activate(cls, conditions: Sequence[Self], assembly: "Assembly") -> Sequence[StepPart]:
        """Return the objects that act in a run for all conditions of this class; none if these conditions only mark nodes or
        pairs of bodies at the start.

        This method is called once for each class that a case can have, in the order of its keys, even without conditions of
        the class. It registers the required nodal actions through the bodies of the assembly.
        """
        return ()

    def reaction(self) -> str | None:
        """Return the name under which probes find the force of the condition on bodies, or None."""
        return None

    def turning_reaction(self, parts: Parts) -> str | None:
        """Return the name under which probes find the torque of the condition on a rigid body about the centre of mass, or
        None; parts: all parts of the case."""
        return None

    def constrains_face(self, face: str) -> bool:
        """Return True if the condition constrains the nodes of a face of the grid, such as "x-lower", along any direction."""
        return False

    def face_velocity(self, face: str) -> tuple[float, float, float] | None:
        """Return the velocity [m/s] of the nodes of a face of the grid if the condition constrains them along its normal,
        else None."""
        return None

    def opens_face(self, face: str) -> bool:
        """Return True if material can flow through this face of the grid under the condition."""
        return False

    def accelerates(self, axis: int) -> bool:
        """Return True if the condition accelerates material along an axis as gravity does, so that its pressure rises towards
        the faces across this axis."""
        return False

    def prescribed_axes(self, body: str) -> set[int]:
        """Return the axes (0, 1, 2) along which the condition prescribes the motion of the body with this name as a whole."""
        return set()


def conditions_in_case(parts: Parts) -> list[Condition]:
    """Return the valid conditions of a case, each as `Condition.in_case` returns it; parts: all parts of the case."""
    conditions, bodies = parts.of(Condition), parts.of(BodyModel)
    x, y, z = parts.active_axes
    return [condition.in_case(bodies, conditions, (not x, not y, not z)) for condition in conditions]


def is_driven(body: str, parts: Parts) -> bool:
    """Return True if the body with this name follows a prescribed motion as a whole along every active axis (more than one cell
    thick), and therefore is rigid; parts: all parts of the case."""
    grid = parts.grid
    free = {axis for axis in range(3) if grid is None or not grid.thin()[axis]}
    return any(free <= condition.prescribed_axes(body) for condition in parts.of(Condition))
