"""The parts of a case, and a view of all of them.

A part that is valid by itself checks its compatibility with the others: its method `problems` receives a view of all valid
parts. Parts do not depend on the kinds of other parts.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar, NamedTuple, TypeVar

from pellucid.findings import Finding, Path, hint, listed
from pellucid.geometry.shapes.contract import ActiveAxes
from pellucid.grid.model import GridCase
from pellucid.model import Model, Vector
from pellucid.users.users_code import failure, place_of


class Part(Model):
    """A table of a case that checks itself against the other tables."""

    unique_name: ClassVar[bool] = False
    """True if names must be unique in the list of these tables."""

    def problems(self, path: Path, parts: "Parts") -> Iterator[Finding]:
        """Yield errors by which this part contradicts other parts; path: location of this part in the case; parts: all valid
        parts."""
        yield from ()

    def needs_grid(self, parts: "Parts") -> bool:
        """Return True if this part requires a grid in this case; parts: all parts of the case."""
        return False


PartType = TypeVar("PartType", bound=Model)


class Section(NamedTuple):
    """The contents of a key of a case, one table or a list of tables: the tables with their class, and whether the case
    gives the key. `Parts` holds a section for each key."""

    base: type[Model]
    """Class of the tables, or the common base class of their kinds."""
    items: Sequence[Model | str | None]
    """Each table; for an invalid table only its name, or None."""
    is_list: bool  # True for a list of tables, False for one table
    is_written: bool = True  # False if the case omits the key


class Parts:
    """All parts (tables) of a case, by key."""

    def __init__(self, sections: Mapping[str, Section], gravity: Vector | None = None) -> None:
        self.sections = sections
        self.gravity = gravity
        """Acceleration of gravity [m/s²]; None if it is unknown because its table is invalid."""

    def placed(self, kind: type[PartType]) -> Iterator[tuple[Path, PartType]]:
        """Yield the valid parts (tables) of the case that belong to a class, `kind`, each with its path in the case."""
        for key, section in self.sections.items():
            for index, item in enumerate(section.items):
                if isinstance(item, kind):
                    yield ((key, index) if section.is_list else (key,)), item

    def of(self, kind: type[PartType]) -> list[PartType]:
        """Return the valid parts (tables) of the case that belong to a class, `kind`."""
        return [part for _, part in self.placed(kind)]

    def one(self, kind: type[PartType]) -> PartType | None:
        """Return the first valid part (table) of the case that belongs to a class, `kind`, or None."""
        return next(iter(self.of(kind)), None)

    @property
    def grid(self) -> GridCase | None:
        """The table [grid] of the case, if there is one and it is valid; otherwise None."""
        return self.one(GridCase)

    @property
    def active_axes(self) -> ActiveAxes:
        """Axes along which the grid is more than one cell thick: True for these; all axes if there is no grid."""
        return self.grid.active_axes() if self.grid else (True, True, True)

    def seam(self, path: Path, face: str) -> Iterator[Finding]:
        """Yield an error if a face of the grid, such as "x-lower", does not exist because the axis is periodic; path: location
        of the key that names the face."""
        if self.grid is not None and (reason := self.grid.seam(face)):
            yield Finding(path, *reason)

    @property
    def lacks_grid(self) -> bool:
        """True if the case has no table [grid], valid or not."""
        return not self.sections["grid"].is_written

    def no_grid(self, path: Path, why: str) -> Iterator[Finding]:
        """Yield the error that a key needs a grid and the case has none, unless another part that needs a grid reports it.

        path: location of the key in the case; why: reason, for the message.
        """
        if self.lacks_grid and not any(part.needs_grid(self) for part in self.of(Part)):
            yield Finding(path, f"needs a grid, and this case has none: {why}", "add a table [grid], or remove this key")

    def are_sound(self, kind: type[Model]) -> bool:
        """Return True if every part (table) of the case that belongs to a class, `kind`, is valid."""
        sections = [section for section in self.sections.values() if issubclass(section.base, kind)]
        return all(isinstance(item, Model) for section in sections for item in section.items)

    def names(self, kind: type[Model]) -> list[str]:
        """Return the names of all parts (tables) of the case that belong to a class, `kind`, including invalid ones whose
        name is known."""
        sections = [section for section in self.sections.values() if issubclass(section.base, kind)]
        names = (name_of(item) for section in sections for item in section.items)
        return [name for name in names if name is not None]

    def are_named(self, kind: type[Model]) -> bool:
        """Return True if the names of all parts (tables) of the case that belong to a class, `kind`, are known. Otherwise a
        name that is not found could belong to an invalid part."""
        sections = [section for section in self.sections.values() if issubclass(section.base, kind)]
        return len(self.names(kind)) == sum(len(section.items) for section in sections)

    def named(self, kind: type[PartType], name: str) -> PartType | None:
        """Return the valid part (table) of the case that belongs to a class, `kind`, and has this name, or None."""
        return next((part for part in self.of(kind) if name_of(part) == name), None)

    def unknown(self, kind: type[Model], path: Path, name: str) -> Iterator[Finding]:
        """Yield an error if no part (table) of the case that belongs to a class, `kind`, has this name; no error if the
        names of some such parts are not known. path: location of the key with the name."""
        names = self.names(kind)
        if name not in names and self.are_named(kind):
            what = " or ".join(key for key, section in self.sections.items() if issubclass(section.base, kind))
            yield Finding(path, f"no {what} has this name; available names: {listed(names) or 'none'}", hint(name, names))

    def findings(self) -> list[Finding]:
        """Return all errors by which parts of the case contradict each other."""
        repeated = (found for key, section in self.sections.items() for found in _repeated_names(key, section))
        return [*repeated, *(found for path, part in self.placed(Part) for found in _problems_of(part, path, self))]


def name_of(part: Model | str | None) -> str | None:
    """Return the name of a part (table) of a case, or None if the table has no name. part: the table; an invalid table is
    given by its name alone, or by None."""
    return part if part is None or isinstance(part, str) else getattr(part, "name", None)


def _problems_of(part: Part, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield the errors that a part (table) of a case reports (`Part.problems`), or an error if its code fails, as code of a
    user-defined part may.

    path: location of the part in the case; parts: all parts.
    """
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
            text = f"{key} number {names.index(name) + 1} already has this name"
            yield Finding((key, index, "name"), text, "choose different names")
