"""Base classes of loads: `LoadModel` for all kinds, and `Load` for forces on the points of a body at the start of each
step."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from inspect import get_annotations
from typing import Any, ClassVar

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loads.points_view import PointsView
from pellucid.energy import FIXED_COLUMNS
from pellucid.errors import RunStopped
from pellucid.findings import Finding, Path, listed, refuse
from pellucid.geometry.region import Where, chosen_nodes, faults
from pellucid.model import parameter
from pellucid.parts.annotations import AssembledBody, Assembly
from pellucid.parts.body_model import BodyModel, selectable_of
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart
from pellucid.users.users_code import WrongArray, as_array, failing_as, home_of

OTHER_CHANNELS = [channel.name for channel in FIXED_COLUMNS]


class LoadModel(Condition):
    """Base of the data models of all kinds of loads."""

    channel: ClassVar[str] = "load_work"
    """Column of `history.csv` that contains the work of the load; its name ends in `_work`. The work of loads with the
    same channel is summed."""

    kind: str
    body: str = parameter("", "name of the body")

    @classmethod
    def __pydantic_init_subclass__(cls, **arguments: Any) -> None:
        """Check the attribute `channel` (history column of the work) of a new subclass. Raises TypeError if its name is not
        allowed for a load."""
        super().__pydantic_init_subclass__(**arguments)
        if cls.channel in OTHER_CHANNELS or not cls.channel.endswith("_work"):
            raise TypeError(
                f'{cls.__name__}.channel = "{cls.channel}" must end in "_work" and be none of {listed(OTHER_CHANNELS)}'
            )

    @abstractmethod
    def active(self, assembly: Assembly, path: Path) -> StepPart:
        """Build the condition that applies the load in a run; path: path of the load in the case, for a CaseError."""

    def load_channel(self) -> str:
        return self.channel

    @classmethod
    def activate(cls, conditions: Sequence["LoadModel"], assembly: Assembly) -> Sequence[StepPart]:
        return [load.active(assembly, ("load", number)) for number, load in enumerate(conditions)]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that does not exist or has no inertia. path: location of the condition in the case;
        parts: all parts of the case."""
        yield from super().problems(path, parts)
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        body = parts.named(BodyModel, self.body)
        if body is not None and not body.moves:
            yield Finding((*path, "body"), f"body {self.body} does not move: it has no inertia", "remove this load")


class Load(ChangesInTime, LoadModel):
    """Forces on the points of a body at the start of each step. A new kind of load is a subclass with its own `kind`.

    A kind that declares a key common to all loads, such as `rise`, defines its own meaning of the key.
    """

    where: Where | None = parameter("", "points of the body on which the load acts; default: all", None)

    @classmethod
    def __pydantic_init_subclass__(cls, **arguments: Any) -> None:
        super().__pydantic_init_subclass__(**arguments)
        kinds = cls.__mro__[: cls.__mro__.index(Load)]
        cls.declared_anew = frozenset(name for kind in kinds for name in get_annotations(kind))

    @abstractmethod
    def forces(self, points: PointsView, time: float) -> np.ndarray:
        """Return the forces [N], shape (n, 3), on the points over the step that begins at a time [s]; they are multiplied
        by the fraction from `rise` or `amplitude`."""

    @property
    def region(self) -> Where | None:
        """Region of the points on which the load acts; None for all points."""
        return None if "where" in self.declared_anew else self.where

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        yield from super().problems(path, parts)
        if self.region is not None:
            yield from chosen_problems(self.region, self.body, path, parts)

    def active(self, assembly: Assembly, path: Path) -> StepPart:
        return ActiveLoad(self, assembly, path)


class ActiveLoad(StepPart):
    """Applies the forces of a `Load` in each step to the body that the load names."""

    def __init__(self, load: Load, assembly: Assembly, path: Path) -> None:
        from pellucid.parts.families import GridBody

        member = assembly.bodies[load.body]
        self._body, self._load, self._path = member.body, load, path
        if isinstance(self._body, GridBody):
            self._body.storage.keep_whole()  # `forces` see all points
        self._chosen = None if load.region is None else chosen_points(load.region, member, path)
        self._add = assembly.forces_on(load.body, load.channel)

    def try_out(self) -> None:
        """Evaluate the forces at the start, so that an invalid load stops the run before the results of an earlier run are
        replaced."""
        try:
            checked_forces(self._load, PointsView(self._body), 0.0)
        except RunStopped as error:
            refuse([Finding(self._path, str(error))])

    def begin(self, time: float, dt: float) -> None:
        points = PointsView(self._body)
        forces = self._load.share(time) * checked_forces(self._load, points, time)
        if self._chosen is not None:
            forces[~self._chosen[points.id]] = 0.0
        self._add(points.as_stored(forces))


def checked_forces(load: Load, points: PointsView, time: float) -> np.ndarray:
    """Return the forces of a load [N], shape (n, 3), on the points at a time [s]. Raises RunStopped if their shape is wrong
    or a value is not finite."""

    def stopped(why: str) -> RunStopped:
        return RunStopped(f'the load of kind "{load.kind}" on body {load.body} {why}', body=load.body)

    with failing_as(lambda why: stopped(f"fails in `forces` at t = {time:g} s: {why}"), load.forces):
        found = load.forces(points, time)
    try:
        forces = as_array(found, (len(points.id), 3), load.forces)
    except WrongArray as error:
        raise stopped(f"returns no forces: `forces` {error}") from None
    if not np.isfinite(forces).all():
        point = int(np.flatnonzero(~np.isfinite(forces).all(axis=1))[0])
        place = ", ".join(f"{value:.6g}" for value in points.position[point])
        text = f"returns the force {forces[point]} N at t = {time:g} s on the point at ({place}) m"
        raise stopped(f"{text}; correct its `forces`, see {home_of(load.forces)}")
    return np.ascontiguousarray(forces)


def chosen_problems(where: Where, name: str, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield a finding if a region (`where`, at `path` in the case) contains none of the nodes of the body named `name`;
    bodies whose nodes are known only when they are built are not checked."""
    body = parts.named(BodyModel, name)
    if body is not None and (start := selectable_of(body, parts)) is not None:
        yield from faults(where, start, (*path, "where"), name, parts.active_axes)


def chosen_points(where: Where, member: AssembledBody, path: Path) -> np.ndarray:
    """Return a mask of the points of a built body in the region `where` of a load, by number of the point, shape (n,).

    path: path of the region in the case. Raises CaseError if there is no point in it.
    """
    start, body = member.selectable(), member.body
    refuse(faults(where, start, (*path, "where"), body.name, member.active_axes))
    chosen = np.zeros(body.n_points, bool)
    chosen[body.stored_array("id")[chosen_nodes(where, start, member.active_axes)]] = True
    return chosen
