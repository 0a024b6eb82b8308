"""The parts of a case: the interfaces of the models of bodies and conditions, and a view of all parts.

A part that is right in itself checks whether it fits the others: its method `problems` gets a view of those that are right in
themselves too. No part needs to know of what kind a body or a condition is.
"""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple, Self, TypeVar

import numpy as np

from pellucid.findings import Finding, Path, Reason, hint, listed
from pellucid.geometry.geometry import Geometry
from pellucid.grid.model import GridCase
from pellucid.materials.contract import BodyMaterial
from pellucid.model import Model, Vector, parameter
from pellucid.users_code import failure, place_of

if TYPE_CHECKING:
    from pellucid.bodies.contract import Body, Placement
    from pellucid.conditions.contract import ActiveCondition, Assembly

FIELD_MEANING = "velocity field: bodies of one field move together, those of different fields touch by contact"


class Part(Model):
    """A table of a case that checks itself against the others."""

    unique_name: ClassVar[bool] = False
    """Whether no two in its list may have the same name."""

    def problems(self, path: Path, parts: "Parts") -> Iterator[Finding]:
        """What does not fit the other parts; `path` is its place in the case."""
        yield from ()


PartType = TypeVar("PartType", bound=Model)


class Section(NamedTuple):
    """What stands under a key of a case: one table, or a list of them."""

    base: type[Model]
    """The class of the tables, or that which their kinds share."""
    items: Sequence[Model | str | None]
    """Each table; its name alone, or None, where it is wrong in itself."""
    is_list: bool
    is_written: bool = True


class Parts:
    """The parts of a case, by their keys."""

    def __init__(self, sections: Mapping[str, Section]) -> None:
        self.sections = sections

    def placed(self, kind: type[PartType]) -> Iterator[tuple[Path, PartType]]:
        """The sound parts of a class, each with its path."""
        for key, section in self.sections.items():
            for index, item in enumerate(section.items):
                if isinstance(item, kind):
                    yield ((key, index) if section.is_list else (key,)), item

    def of(self, kind: type[PartType]) -> list[PartType]:
        """The sound parts of a class."""
        return [part for _, part in self.placed(kind)]

    def one(self, kind: type[PartType]) -> PartType | None:
        """The sound part of a class that a case has once, if it is there."""
        return next(iter(self.of(kind)), None)

    @property
    def grid(self) -> GridCase | None:
        """The grid, if it is there and right in itself."""
        return self.one(GridCase)

    @property
    def lacks_grid(self) -> bool:
        """Whether the case names no grid, be it right or wrong."""
        return not self.sections["grid"].is_written

    def no_grid(self, path: Path, why: str) -> Iterator[Finding]:
        """The finding that what is at a path needs a grid, and why; none where a body that needs one reports it."""
        if self.lacks_grid and not any(body.needs_grid(self) for body in self.of(BodyModel)):
            yield Finding(path, f"needs a grid, and this case has none: {why}", "add a table [grid], or leave this out")

    def is_driven(self, body: str) -> bool:
        """Whether a body as a whole follows a prescribed motion along every axis that counts: it is rigid then."""
        grid = self.grid
        free = {axis for axis in range(3) if grid is None or not grid.thin()[axis]}
        return any(free <= condition.prescribed_axes(body) for condition in self.of(Condition))

    def are_sound(self, kind: type[Model]) -> bool:
        """Whether every part that could be of a class is right in itself."""
        sections = [section for section in self.sections.values() if issubclass(section.base, kind)]
        return all(isinstance(item, Model) for section in sections for item in section.items)

    def names(self, kind: type[Model]) -> list[str]:
        """The names of all that could be of a class, also of what is wrong but for its name."""
        sections = [section for section in self.sections.values() if issubclass(section.base, kind)]
        names = (name_of(item) for section in sections for item in section.items)
        return [name for name in names if name is not None]

    def are_named(self, kind: type[Model]) -> bool:
        """Whether all names of a class are known: one that is not may be the one that is looked for."""
        sections = [section for section in self.sections.values() if issubclass(section.base, kind)]
        return len(self.names(kind)) == sum(len(section.items) for section in sections)

    def body(self, name: str) -> "BodyModel | None":
        """The sound body of this name."""
        return next((body for body in self.of(BodyModel) if body.name == name), None)

    def unknown_body(self, path: Path, name: str) -> Iterator[Finding]:
        """The finding that no body has this name."""
        names = self.names(BodyModel)
        if name not in names and self.are_named(BodyModel):
            yield Finding(path, f"no body has this name; there are {listed(names)}", hint(name, names))

    def findings(self) -> list[Finding]:
        """Everything that does not fit together."""
        repeated = (found for key, section in self.sections.items() for found in _repeated_names(key, section))
        return [*repeated, *(found for path, part in self.placed(Part) for found in _problems_of(part, path, self))]


def name_of(part: Model | str | None) -> str | None:
    """The name of a part that has one; of what is wrong in itself, its name is all that there is."""
    return part if part is None or isinstance(part, str) else getattr(part, "name", None)


def _problems_of(part: Part, path: Path, parts: Parts) -> Iterator[Finding]:
    """What a part finds; that of a user's kind may fail."""
    try:
        found = list(part.problems(path, parts))
    except Exception as error:
        if not place_of(error):
            raise
        found = [Finding(path, f"cannot be checked: {failure(error)}")]
    for item in found:
        wrong = f"`problems` of {type(part).__name__} yields {item!r}; it must yield `pellucid.findings.Finding`"
        yield item if isinstance(item, Finding) else Finding(path, wrong)


def _repeated_names(key: str, section: Section) -> Iterator[Finding]:
    names = [name_of(item) for item in section.items]
    for index, name in enumerate(names):
        if issubclass(section.base, Part) and section.base.unique_name and name is not None and name in names[:index]:
            text = f"{key} number {names.index(name) + 1} has this name already"
            yield Finding((key, index, "name"), text, "give each its own name")


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


class StepLimit(NamedTuple):
    """The largest stable step at the start [s], and why."""

    step: float
    reason: str


class BodyModel(Part):
    """A body as the user describes it. A new kind is a subclass with a `kind` of its own."""

    unique_name: ClassVar[bool] = True
    place: ClassVar[str]
    """The key that says where it is at the start."""
    is_surface: ClassVar[bool] = False
    """Whether it is a membrane, which has two sides and no volume of its own."""

    kind: str
    name: str = parameter("", "name of the body, used for its files and in probes", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    field: str = parameter("", FIELD_MEANING, "common", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")

    if TYPE_CHECKING:  # each kind declares them among its own keys, in the order of the reference
        material: BodyMaterial
        velocity: Vector

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """That there is no grid, reported by the first body that needs one."""
        needing = (body for body in parts.of(BodyModel) if body.needs_grid(parts))
        if parts.lacks_grid and next(needing, None) is self:
            text = f"is missing: body {self.name} needs one"
            yield Finding(("grid",), text, "add a table [grid] with `lower`, `upper` and `cell`")

    @abstractmethod
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner at the start [m], each of shape (3,)."""

    @abstractmethod
    def occupied(self) -> Geometry:
        """The region that it occupies at the start, which other bodies can leave out of theirs."""

    @property
    @abstractmethod
    def probed(self) -> tuple[str, ...]:
        """The fields that probes can read."""

    @abstractmethod
    def n_points(self, grid: GridCase | None) -> float:
        """Number of points, good to a layer of them; None where the case has no grid."""

    @abstractmethod
    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        """Velocities at the start [m/s], shape (n, 3), at positions [m], shape (n, 3)."""

    @abstractmethod
    def build(self, placement: "Placement") -> "Body":
        """Build the body; in a case with several, from the model that `with_others` returns."""

    def owns_nodes(self, alone: bool) -> bool:
        """Whether it has nodes of its own, not those of the grid; `alone`: whether it has a velocity field to itself."""
        return False

    @property
    def is_rigid(self) -> bool:
        """Whether it moves as a rigid body."""
        return False

    def with_others(self, bodies: "Sequence[BodyModel]") -> Self:
        """The same model with the others of its case, whose regions it may leave out."""
        return self

    def contains(self, places: np.ndarray, active: tuple[bool, bool, bool]) -> np.ndarray:
        """Which places [m], shape (n, 3), lie inside it at the start, shape (n,), along the axes that are `active`."""
        return self.occupied().contains(places, active)

    def needs_grid(self, parts: Parts) -> bool:
        """Whether it cannot do without a grid in this case."""
        return True

    def excluded_bodies(self) -> tuple[str, ...]:
        """Names of the bodies whose regions it leaves out of its own."""
        return ()

    def why_not_excluded(self, grid: GridCase | None) -> Reason | None:
        """Why another body cannot leave out its region, if so."""
        return None

    def why_no_motion(self) -> Reason | None:
        """Why it cannot follow a prescribed motion, if so."""
        return None

    def has_volume_waves(self) -> bool:
        """Whether plane waves cross it, which a face of the grid can absorb."""
        return not self.is_surface

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of plane pressure and shear waves at the start [m/s], of a body that such waves cross."""
        raise ValueError(f"body {self.name} has no plane waves")

    def step_limit(self, cell: float, is_driven: bool) -> StepLimit | None:
        """The largest stable step at the start in cells of this edge [m], None where the cells do not bound it.

        is_driven: whether the whole body follows a prescribed motion along every axis.
        """
        return None
