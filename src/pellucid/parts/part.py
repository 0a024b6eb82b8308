"""The parts of a case, and a view of all of them.

A part that is right in itself checks whether it fits the others: its method `problems` gets a view of those that are right in
themselves too. No part needs to know of what kind another is.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar, NamedTuple, TypeVar

from pellucid.findings import Finding, Path, hint, listed
from pellucid.geometry.shapes.contract import ActiveAxes
from pellucid.grid.model import GridCase
from pellucid.model import Model, Vector
from pellucid.users.users_code import failure, place_of


class Part(Model):
    """A table of a case that checks itself against the others."""

    unique_name: ClassVar[bool] = False
    """Whether no two in its list may have the same name."""

    def problems(self, path: Path, parts: "Parts") -> Iterator[Finding]:
        """What does not fit the other parts; `path` is its place in the case."""
        yield from ()

    def needs_grid(self, parts: "Parts") -> bool:
        """Whether it cannot do without a grid in this case."""
        return False


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

    def __init__(self, sections: Mapping[str, Section], gravity: Vector | None = None) -> None:
        self.sections = sections
        self.gravity = gravity
        """The acceleration of gravity [m/s²]; None where it is not known, something else being wrong in itself."""

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
    def active_axes(self) -> ActiveAxes:
        """The axes along which the grid is more than one cell thick; all where there is none."""
        x, y, z = self.grid.thin() if self.grid else (False, False, False)
        return not x, not y, not z

    def seam(self, path: Path, face: str) -> Iterator[Finding]:
        """The finding that a face is none, as the grid goes on there."""
        if self.grid is not None and (reason := self.grid.seam(face)):
            yield Finding(path, *reason)

    @property
    def lacks_grid(self) -> bool:
        """Whether the case names no grid, be it right or wrong."""
        return not self.sections["grid"].is_written

    def no_grid(self, path: Path, why: str) -> Iterator[Finding]:
        """The finding that what is at a path needs a grid, and why; none where another part that needs one reports it."""
        if self.lacks_grid and not any(part.needs_grid(self) for part in self.of(Part)):
            yield Finding(path, f"needs a grid, and this case has none: {why}", "add a table [grid], or leave this out")

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

    def named(self, kind: type[PartType], name: str) -> PartType | None:
        """The sound part of a class that has this name."""
        return next((part for part in self.of(kind) if name_of(part) == name), None)

    def unknown(self, kind: type[Model], path: Path, name: str) -> Iterator[Finding]:
        """The finding that no part of a class has this name."""
        names = self.names(kind)
        if name not in names and self.are_named(kind):
            what = " or ".join(key for key, section in self.sections.items() if issubclass(section.base, kind))
            yield Finding(path, f"no {what} has this name; there are {listed(names)}", hint(name, names))

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
