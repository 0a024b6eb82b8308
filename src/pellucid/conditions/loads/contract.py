"""Base classes of loads: `LoadModel` for all kinds, and `Load` for forces on the points of a body at the start of each step,
with the view of the points that user-defined loads read."""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property
from inspect import get_annotations
from typing import Any, ClassVar, NoReturn

import numpy as np

from pellucid.conditions.signals.time_table import ChangesInTime
from pellucid.energy import FIXED_COLUMNS
from pellucid.errors import RunStopped
from pellucid.findings import Finding, Path, absent, listed, refuse
from pellucid.geometry.region import Where, chosen_nodes, faults
from pellucid.model import parameter
from pellucid.parts.annotations import AssembledBody, Assembly, Body
from pellucid.parts.body_model import BodyModel, selectable_of
from pellucid.parts.capabilities import Membrane
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart
from pellucid.users.users_code import WrongArray, as_array, failing_as, home_of, read_only


class PointsView:
    """Read-only arrays of the points or nodes of a body at the start of a step, without points that left the grid.

    The order is the order of the point numbers (mesh, surface vertices or seeding); it does not change when the grid sorts
    the points. Attributes: position [m] and velocity [m/s], shape (n, 3); mass [kg] and number `id`, shape (n,); for
    membranes also normals, areas and triangles.
    """

    def __init__(self, body: Body) -> None:
        self._body, self._order = body, body.order()

    @cached_property
    def id(self) -> np.ndarray:
        """Point numbers, counted from 0, in ascending order, shape (n,)."""
        return self._seen("id")

    @cached_property
    def position(self) -> np.ndarray:
        """Positions [m], shape (n, 3)."""
        return self._seen("position")

    @cached_property
    def velocity(self) -> np.ndarray:
        """Velocities [m/s], shape (n, 3)."""
        return self._seen("velocity")

    @cached_property
    def mass(self) -> np.ndarray:
        """Masses [kg], shape (n,)."""
        return self._seen("mass")

    @cached_property
    def volume(self) -> np.ndarray:
        """Current volumes [m³], shape (n,); for a membrane, the volume of its material that belongs to each node."""
        return read_only(self._body.volumes()[self._order])

    @cached_property
    def triangles(self) -> np.ndarray:
        """Triangles of a membrane, shape (m, 3): indices of their corners in the arrays, counterclockwise about the normal;
        quadrilaterals are split in two."""
        self._membrane("triangles")
        return read_only(self._body.cells().surface())

    @cached_property
    def vector_area(self) -> np.ndarray:
        """Vector areas of a membrane's points [m²], shape (n, 3), i.e. the forces of a pressure of 1 Pa. Over a closed
        surface they sum to zero."""
        return read_only(self._membrane("vector areas").pressed_areas())

    @cached_property
    def normal(self) -> np.ndarray:
        """Unit normals of a membrane's points, shape (n, 3); zero where undefined."""
        size = np.linalg.norm(self.vector_area, axis=1, keepdims=True)
        return read_only(np.divide(self.vector_area, size, out=np.zeros_like(self.vector_area), where=size > 0.0))

    @cached_property
    def area(self) -> np.ndarray:
        """Areas of a membrane's points [m²], shape (n,)."""
        return read_only(self._membrane("areas").surface_areas())

    def as_stored(self, forces: np.ndarray) -> np.ndarray:
        """Reorder forces on the points [N], shape (n, 3), from the order of the point numbers to the storage order of the
        body, with zeros for points that left the grid."""
        stored = np.zeros((self._body.n_points, 3))
        stored[self._order] = forces
        return stored

    def _seen(self, name: str) -> np.ndarray:
        return read_only(self._body.arrays[name][self._order])

    def _membrane(self, what: str) -> Membrane:
        if not isinstance(self._body, Membrane):
            raise ValueError(f"body {self._body.name} is not a membrane: it has no {what}")
        return self._body

    def __getattr__(self, name: str) -> NoReturn:
        raise AttributeError(absent("`PointsView` has no", name, SEEN))


SEEN = [name for name, part in vars(PointsView).items() if isinstance(part, cached_property)]


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
