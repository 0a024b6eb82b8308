"""Arrays over the nodes of a grid, each declared once.

A set of them is a named tuple, as kernels take it. The annotation of a member says what it is: a `NodalField`, or a `View` of
some numbers of one. Memory, views and clearing (`pellucid.grid.clearing`) follow from these declarations, and so does the table
in docs/reference/nodal-arrays.md. Sets may hold other members beside them.

Points on both sides of a cut of the grid give to the nodes between them: what is not FOUND is whole only with both.
"""

from collections.abc import Mapping
from functools import cache
from math import inf
from typing import Any, Final, Literal, NamedTuple, TypeVar, get_type_hints

import numpy as np

from pellucid.jit.kernels import LINE

Combine = Literal["sum", "max", "min", "or", "found"]
"""How contributions of points, or of conditions at points, combine; found: a pass over nodes sets the field."""
Cleared = Literal["step", "remap", "run"]
"""When a field is set to zero: in each step, before momentum is mapped again, or never in a run."""
SUM: Final = "sum"
MAX: Final = "max"
MIN: Final = "min"
OR: Final = "or"
FOUND: Final = "found"
STEP: Final = "step"
REMAP: Final = "remap"
RUN: Final = "run"
START = {MAX: -inf, MIN: inf}
"""What fields hold to which nothing was given, where that is not zero."""
ROW = 4
"""Numbers of a row: as many as a vector of kernels has."""
VECTOR = slice(0, 3)

Arrays = TypeVar("Arrays", bound=tuple[Any, ...])


class NodalField(NamedTuple):
    """An array over nodes, shape (n, components), or (n,) where it has one component."""

    components: int
    combine: Any  # a `Combine`, or one for each component
    cleared: Cleared
    unit: str
    meaning: str
    dtype: Any = np.float64
    in_rows: bool = False  # flat, shape (ROW n,), and aligned in memory
    several: bool = False  # of several such arrays, shape (m, n, components)

    @property
    def start(self) -> Any:
        """Initial value; a number for each of several components."""
        if isinstance(self.combine, tuple):
            return [START.get(how, 0.0) for how in self.combine]
        return START.get(self.combine, 0)

    def allocate(self, n: int, several: int = 0) -> np.ndarray:
        """Allocate the memory for n nodes with initial values."""
        if self.in_rows:
            return aligned_rows(n).reshape(-1)
        shape = (*([several] if self.several else []), n, *([self.components] if self.components > 1 else []))
        start = self.start
        # what is zero takes no memory of the machine before it is used
        return np.zeros(shape, self.dtype) if start == 0 else np.full(shape, start, self.dtype)


def rows(combine: Combine, cleared: Cleared, unit: str, meaning: str) -> NodalField:
    """A field of four numbers, as kernels with vectors take it."""
    return NodalField(ROW, combine, cleared, unit, meaning, in_rows=True)


class View(NamedTuple):
    """Some numbers of the rows of a field."""

    of: str
    part: int | slice
    unit: str
    meaning: str
    cleared: Cleared | None = None  # where that is not with all of the field


def aligned_rows(n: int) -> np.ndarray:
    """Rows of zeros, shape (n, ROW), two to a line of the cache: a row that lies in two lines takes longer to add to."""
    row = ROW * np.dtype(float).itemsize
    memory = np.zeros(n * row + LINE, np.uint8)
    start = -memory.ctypes.data % LINE
    return memory[start : start + n * row].view(float).reshape(n, ROW)


@cache
def declared(kind: type[tuple[Any, ...]]) -> Mapping[str, NodalField | View]:
    """Return the declared fields of a set, by name."""
    hints = get_type_hints(kind, include_extras=True)
    found = {name: getattr(hint, "__metadata__", (None,))[0] for name, hint in hints.items()}
    return {name: one for name, one in found.items() if isinstance(one, NodalField | View)}


@cache
def fields_of(kind: type[tuple[Any, ...]]) -> Mapping[str, NodalField]:
    """The fields of a set, by name."""
    return {name: one for name, one in declared(kind).items() if isinstance(one, NodalField)}


@cache
def views_of(kind: type[tuple[Any, ...]]) -> Mapping[str, View]:
    """The views of a set, by name."""
    return {name: one for name, one in declared(kind).items() if isinstance(one, View)}


def bytes_of(kind: type[tuple[Any, ...]]) -> int:
    """Memory that the fields of a set take for each node."""
    return sum(one.components * np.dtype(one.dtype).itemsize for one in fields_of(kind).values())


def allocate(kind: type[Arrays], n: int, several: int = 0) -> Arrays:
    """A set that is nothing but fields and views, with memory for n nodes; of 0 nodes, one that nobody uses.

    several: of how many arrays those fields are made which are of several.
    """
    without: Any = [None] * len(declared(kind))
    return with_fields(kind(*without), {name: one.allocate(n, several) for name, one in fields_of(kind).items()})


def with_fields(arrays: Arrays, new: Mapping[str, np.ndarray]) -> Arrays:
    """The set with other memory for some of its fields, and the views of these."""
    shown = [(name, view) for name, view in views_of(type(arrays)).items() if view.of in new]
    new = dict(new) | {name: new[view.of].reshape(-1, ROW)[:, view.part] for name, view in shown}
    return arrays._replace(**new)  # type: ignore[attr-defined]


def with_memory(arrays: Arrays, n: int, *names: str) -> Arrays:
    """The set with memory for n nodes for these fields, where they had none yet."""
    several = {name: len(getattr(arrays, name)) for name in names}
    lacking = [name for name in names if not getattr(arrays, name).size]
    return with_fields(arrays, {name: fields_of(type(arrays))[name].allocate(n, several[name]) for name in lacking})
