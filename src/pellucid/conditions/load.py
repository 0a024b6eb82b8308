"""Loads: forces on the points of a body, of any kind that is registered."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np

from pellucid.conditions.checked import checked_forces
from pellucid.conditions.signals import smooth_step
from pellucid.energy import CONTACT_WORK, GRAVITY_WORK, MOTION_WORK, SUPPORT_WORK, Channel
from pellucid.errors import CaseError, Problem, RunStopped
from pellucid.findings import Finding, Path, listed
from pellucid.model import Vector, parameter
from pellucid.parts import Condition, Parts
from pellucid.registry import Family, OneOf, register
from pellucid.users_code import read_only

if TYPE_CHECKING:
    from pellucid.bodies.contract import Body
    from pellucid.conditions.contract import Assembly

OTHER_CHANNELS = [channel.name for channel in (GRAVITY_WORK, SUPPORT_WORK, MOTION_WORK, CONTACT_WORK)]


class PointsView:
    """The points or nodes of a body at the start of a step. The arrays are the body's own and cannot be written to.

    position [m] and velocity [m/s], shape (n, 3); mass [kg], shape (n,).
    """

    def __init__(self, body: "Body") -> None:
        self._body = body
        self.position, self.velocity, self.mass = (read_only(body.arrays[name]) for name in ("position", "velocity", "mass"))

    @cached_property
    def volume(self) -> np.ndarray:
        """Volume [m³], shape (n,); of the nodes of a membrane their shares of it."""
        return read_only(self._body.volumes())


class Load(Condition):
    """Forces on a body. A new kind is a subclass with a `kind` of its own."""

    nodal: ClassVar[Literal["loads", "absorption", "driven", ""]] = "loads"
    channel: ClassVar[str] = "load_work"
    """The column of `history.csv` that shows its work, with a name that ends in `_work`; loads of one channel are summed."""

    kind: str
    body: str = parameter("", "name of the body")

    @classmethod
    def __pydantic_init_subclass__(cls, **arguments: Any) -> None:
        """Raises TypeError for a channel that is none of a load's."""
        super().__pydantic_init_subclass__(**arguments)
        if cls.channel in OTHER_CHANNELS or not cls.channel.endswith("_work"):
            raise TypeError(
                f'{cls.__name__}.channel = "{cls.channel}" must end in "_work" and be none of {listed(OTHER_CHANNELS)}'
            )

    @abstractmethod
    def forces(self, points: PointsView, time: float) -> np.ndarray:
        """Forces [N], shape (n, 3), on the points over the step that begins at a time [s]."""

    def acts_on(self) -> str:
        """Its body."""
        return self.body

    def load_channel(self) -> str:
        """Its channel."""
        return self.channel

    @classmethod
    def activate(cls, conditions: Sequence["Load"], assembly: "Assembly") -> Sequence["ActiveLoad"]:
        """One for each."""
        for number, load in enumerate(conditions):
            try:  # before anything is written, so that a load that fails at once costs no earlier results
                checked_forces(load, PointsView(assembly.bodies[load.body].body), 0.0)
            except RunStopped as error:
                raise CaseError(Problem(str(error), f"load.{number}")) from error
        return [ActiveLoad(assembly.bodies[load.body].body, load, assembly) for load in conditions]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A body that is not there."""
        yield from super().problems(path, parts)
        yield from parts.unknown_body((*path, "body"), self.body)


LOADS = Family("load", Load)
AnyLoad = Annotated[Load, OneOf(LOADS)]


@register
class BodyForce(Load):
    """A force on every mass: an acceleration of one body, as of a frame that speeds up the other way."""

    kind: Literal["body-force"] = "body-force"
    acceleration: Vector = parameter("m/s^2", "force on unit mass")
    rise: float = parameter("s", "time over which it rises smoothly from zero", 0.0, ge=0)

    def forces(self, points: PointsView, time: float) -> np.ndarray:
        """Forces [N], shape (n, 3)."""
        share = smooth_step(time / self.rise) if self.rise > 0.0 else 1.0
        return points.mass[:, None] * (share * np.array(self.acceleration))


class ActiveLoad:
    """A load on a body that is built."""

    channels: Sequence[Channel] = ()

    def __init__(self, body: "Body", load: Load, assembly: "Assembly") -> None:
        self._body, self._load, self._column = body, load, assembly.column(load.channel)

    def begin(self, time: float, dt: float) -> None:
        """Its forces over the step."""
        self._body.add_external_force(checked_forces(self._load, PointsView(self._body), time), self._column)

    def work(self) -> None:
        """None: nodes and bodies count the work of external forces."""
