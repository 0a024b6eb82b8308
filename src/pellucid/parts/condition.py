"""The interface of the model of a condition."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Literal, Self

from pellucid.parts.part import Part, Parts

if TYPE_CHECKING:
    from pellucid.parts.assembly import ActiveCondition, Assembly


class Condition(Part):
    """An external action on bodies or nodes, or between bodies. A new one is a subclass, and a key of the case."""

    nodal: ClassVar[Literal["loads", "absorption", "driven", ""]] = ""
    """Nodal arrays that it needs in the velocity field of its body, see `pellucid.grid.momentum.ExternalAction`."""

    def acts_on(self) -> str | None:
        """The name of the body on which it acts, if it is one body."""
        return None

    def load_channel(self) -> str | None:
        """The column of the history that shows the work of its external forces, if it has such forces."""
        return None

    @classmethod
    def activate(cls, conditions: Sequence[Self], assembly: "Assembly") -> Sequence["ActiveCondition"]:
        """What acts for all conditions of this class in a run; nothing where they only mark nodes or pairs at the start."""
        return ()

    def reaction(self) -> str | None:
        """The name under which probes find the force that it exerts, if it has one."""
        return None

    def constrains_face(self, face: str) -> bool:
        """Whether it constrains the nodes of a face of the grid, such as "x-lower", along any direction."""
        return False

    def face_velocity(self, face: str) -> tuple[float, float, float] | None:
        """The velocity [m/s] of the nodes of a face of the grid, if it constrains them along its normal."""
        return None

    def prescribed_axes(self, body: str) -> set[int]:
        """The axes along which a body as a whole follows it."""
        return set()


def is_driven(body: str, parts: Parts) -> bool:
    """Whether a body as a whole follows a prescribed motion along every axis that counts: it is rigid then."""
    grid = parts.grid
    free = {axis for axis in range(3) if grid is None or not grid.thin()[axis]}
    return any(free <= condition.prescribed_axes(body) for condition in parts.of(Condition))
