"""The interfaces of loads: of every kind, and of those that are forces on the points of a body at the start of each step."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pellucid.energy import FIXED_COLUMNS
from pellucid.errors import RunStopped
from pellucid.findings import Finding, Path, listed, refuse
from pellucid.model import parameter
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.users_code import WrongArray, as_array, failing_as, home_of, read_only

if TYPE_CHECKING:
    from pellucid.parts.assembly import Assembly
    from pellucid.parts.body import Body

OTHER_CHANNELS = [channel.name for channel in FIXED_COLUMNS]


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


class LoadModel(Condition):
    """A load as the user describes it."""

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
    def active(self, assembly: "Assembly", path: Path) -> ActiveCondition:
        """What acts in a run. Raises CaseError, with the path of the load in the case, where it cannot."""

    def load_channel(self) -> str:
        """Its channel."""
        return self.channel

    @classmethod
    def activate(cls, conditions: Sequence["LoadModel"], assembly: "Assembly") -> Sequence[ActiveCondition]:
        """One for each."""
        return [load.active(assembly, ("load", number)) for number, load in enumerate(conditions)]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A body that is not there, or has no inertia."""
        yield from super().problems(path, parts)
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        body = parts.named(BodyModel, self.body)
        if body is not None and not body.moves:
            yield Finding((*path, "body"), f"body {self.body} does not move: it has no inertia", "leave this load out")


class Load(LoadModel):
    """Forces on the points of a body at the start of each step. A new kind is a subclass with a `kind` of its own."""

    @abstractmethod
    def forces(self, points: PointsView, time: float) -> np.ndarray:
        """Forces [N], shape (n, 3), on the points over the step that begins at a time [s]."""

    def active(self, assembly: "Assembly", path: Path) -> ActiveCondition:
        """Its forces, tried before anything is written, so that a load that fails at once costs no earlier results."""
        try:
            checked_forces(self, PointsView(assembly.bodies[self.body].body), 0.0)
        except RunStopped as error:
            refuse([Finding(path, str(error))])
        return ActiveLoad(self, assembly)


class ActiveLoad(ActiveCondition):
    """A load on a body that is built."""

    def __init__(self, load: Load, assembly: "Assembly") -> None:
        self._body, self._load = assembly.bodies[load.body].body, load
        self._column = assembly.load_column(load.body, load.channel)

    def begin(self, time: float, dt: float) -> None:
        """Its forces over the step."""
        self._body.add_external_force(checked_forces(self._load, PointsView(self._body), time), self._column)


def checked_forces(load: Load, points: PointsView, time: float) -> np.ndarray:
    """The forces of a load [N], shape (n, 3), if they are what they must be. Raises RunStopped."""

    def stopped(why: str) -> RunStopped:
        return RunStopped(f'the load of kind "{load.kind}" on body {load.body} {why}', body=load.body)

    with failing_as(lambda why: stopped(f"fails in `forces` at t = {time:g} s: {why}"), load.forces):
        found = load.forces(points, time)
    try:
        forces = as_array(found, (len(points.mass), 3), load.forces)
    except WrongArray as error:
        raise stopped(f"gives no forces: `forces` {error}") from None
    if not np.isfinite(forces).all():
        point = int(np.flatnonzero(~np.isfinite(forces).all(axis=1))[0])
        place = ", ".join(f"{value:.6g}" for value in points.position[point])
        text = f"gives the force {forces[point]} N at t = {time:g} s on the point at ({place}) m"
        raise stopped(f"{text}; mend its `forces`, see {home_of(load.forces)}")
    return np.ascontiguousarray(forces)
