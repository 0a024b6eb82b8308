"""Loads: forces on the points of a body, of any kind that is registered."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Protocol

import numpy as np

from pellucid.conditions.signals import smooth_step
from pellucid.energy import CONTACT_WORK, GRAVITY_WORK, MOTION_WORK, SUPPORT_WORK
from pellucid.errors import RunStopped
from pellucid.findings import Finding, Path, listed
from pellucid.model import Vector, parameter
from pellucid.parts import Condition, Parts
from pellucid.registry import Family, OneOf, register

OTHER_CHANNELS = [channel.name for channel in (GRAVITY_WORK, SUPPORT_WORK, MOTION_WORK, CONTACT_WORK)]


class PointsView(NamedTuple):
    """The points or nodes of a body at the start of a step. The arrays are the body's own: do not write to them."""

    position: np.ndarray
    """(n, 3) [m]"""
    velocity: np.ndarray
    """(n, 3) [m/s]"""
    mass: np.ndarray
    """(n,) [kg]"""
    volume: np.ndarray
    """(n,) [m³]"""


class Load(Condition):
    """Forces on a body. A new kind is a subclass with a `kind` of its own."""

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


class Loaded(Protocol):
    """What loads ask of a body."""

    name: str
    arrays: dict[str, np.ndarray]

    def add_external_force(self, force: np.ndarray, column: int) -> None: ...


class LoadsAtWork:
    """The loads of a case on bodies that are built. `columns` are those of their channels in a row of works."""

    def __init__(self, bodies: Sequence[Loaded], loads: Sequence[Load], columns: Mapping[str, int]) -> None:
        named = {body.name: body for body in bodies}
        self._loads = [(load, named[load.body], columns[load.channel]) for load in loads]

    def begin(self, time: float) -> None:
        """Add the forces over the step that begins at `time` [s]."""
        for load, body, column in self._loads:
            points = PointsView(*(body.arrays[name] for name in PointsView._fields))
            body.add_external_force(_checked(load, load.forces(points, time), len(points.mass)), column)


def _checked(load: Load, forces: np.ndarray, n: int) -> np.ndarray:
    """The forces of a load, if they are what they must be. Raises RunStopped."""
    forces = np.asarray(forces, dtype=float)
    if forces.shape != (n, 3):
        raise RunStopped(
            f'the load of kind "{load.kind}" on body {load.body} gives forces of shape {forces.shape} for {n} points; '
            f"`forces` must return an array of shape ({n}, 3)"
        )
    if not np.isfinite(forces).all():
        point = int(np.flatnonzero(~np.isfinite(forces).all(axis=1))[0])
        raise RunStopped(
            f'the load of kind "{load.kind}" on body {load.body} gives the force {forces[point]} N; mend its `forces`',
            body=load.body,
        )
    return np.ascontiguousarray(forces)
