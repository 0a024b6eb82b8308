"""Declarations of nodal arrays, i.e. arrays with values at the nodes of the grid.

A set of nodal arrays is a named tuple that is passed to kernels. The annotation of a member declares it as a `NodalField`,
or as a `View` of some components of a field. Memory, views and clearing (`pellucid.grid.clearing`) follow from these
declarations, and so does the table in docs/reference/nodal-arrays.md. A set may have further members without such an
annotation.

If several processes share a grid, points of two processes contribute to the nodes between their parts. A field that is not
FOUND is complete only with the contributions of both.
"""

from collections.abc import Mapping
from functools import cache
from math import inf
from typing import Any, Final, Literal, NamedTuple, TypeVar, get_type_hints

import numpy as np

from pellucid.jit.registry import LINE

Combine = Literal["sum", "max", "min", "or", "found"]
"""Ways to combine the contributions of points or conditions to a field; found: a pass over the nodes computes the field."""
Cleared = Literal["step", "remap", "run"]
"""When a field is reset to zero: "step": in each step; "remap": before momentum is mapped again; "run": never during a run."""
SUM: Final = "sum"
MAX: Final = "max"
MIN: Final = "min"
OR: Final = "or"
FOUND: Final = "found"
STEP: Final = "step"
REMAP: Final = "remap"
RUN: Final = "run"
START = {MAX: -inf, MIN: inf}
"""Initial values of fields, if not zero, by the way in which contributions are combined."""
ROW = 4
"""Number of components that are stored for a node of a field in rows, equal to the lanes of a kernel vector."""
VECTOR = slice(0, 3)

Arrays = TypeVar("Arrays", bound=tuple[Any, ...])


class NodalField(NamedTuple):
    """Declaration of a nodal array, shape (n, components), or (n,) for one component: unit, meaning, initial value and time of
    its reset."""

    components: int  # number of components per node
    combine: Any  # how contributions are combined: a `Combine` for all components, or a tuple of one per component
    cleared: Cleared  # time of the reset to the initial value, such as STEP
    unit: str  # SI unit
    meaning: str  # description, for the table of nodal arrays in the documentation
    dtype: Any = np.float64  # type of the numbers
    in_rows: bool = False  # True: flat array, shape (ROW n,), aligned in memory
    several: bool = False  # True: several such arrays, shape (m, n, components)

    @property
    def start(self) -> Any:
        """Initial value of the field, which depends on how contributions of points are combined (`combine`); a list with
        one number per component if the components are combined differently."""
        if isinstance(self.combine, tuple):
            return [START.get(how, 0.0) for how in self.combine]
        return START.get(self.combine, 0)

    def allocate(self, n: int, several: int = 0) -> np.ndarray:
        """Return the array of the field for n nodes, filled with its initial value; several: number of arrays, if the field
        is declared with `several`."""
        if self.in_rows:
            return aligned_rows(n).reshape(-1)
        shape = (*([several] if self.several else []), n, *([self.components] if self.components > 1 else []))
        start = self.start
        # what is zero takes no memory of the machine before it is used
        return np.zeros(shape, self.dtype) if start == 0 else np.full(shape, start, self.dtype)


def rows(combine: Combine, cleared: Cleared, unit: str, meaning: str) -> NodalField:
    """Return the declaration of a field stored in rows of four numbers, for vector kernels; arguments: see `NodalField`."""
    return NodalField(ROW, combine, cleared, unit, meaning, in_rows=True)


class View(NamedTuple):
    """Declaration of a view of some components of another nodal field, whose rows hold four numbers per node."""

    of: str  # name of the field
    part: int | slice  # its components
    unit: str  # SI unit
    meaning: str  # description, for the table of nodal arrays in the documentation
    cleared: Cleared | None = None  # time of clearing, if not together with the whole field


def aligned_rows(n: int) -> np.ndarray:
    """Return rows of zeros for n nodes, shape (n, 4), aligned so that no row crosses a cache line, which would slow down
    additions."""
    row = ROW * np.dtype(float).itemsize
    memory = np.zeros(n * row + LINE, np.uint8)
    start = -memory.ctypes.data % LINE
    return memory[start : start + n * row].view(float).reshape(n, ROW)


@cache
def declared(kind: type[tuple[Any, ...]]) -> Mapping[str, NodalField | View]:
    """Return the fields and views that a set of nodal arrays (the class of a named tuple) declares, by name; kind: this
    class."""
    hints = get_type_hints(kind, include_extras=True)
    found = {name: getattr(hint, "__metadata__", (None,))[0] for name, hint in hints.items()}
    return {name: one for name, one in found.items() if isinstance(one, NodalField | View)}


@cache
def fields_of(kind: type[tuple[Any, ...]]) -> Mapping[str, NodalField]:
    """Return the fields that a set of nodal arrays (the class of a named tuple) declares, without views, by name."""
    return {name: one for name, one in declared(kind).items() if isinstance(one, NodalField)}


@cache
def views_of(kind: type[tuple[Any, ...]]) -> Mapping[str, View]:
    """Return the views that a set of nodal arrays (the class of a named tuple) declares, by name."""
    return {name: one for name, one in declared(kind).items() if isinstance(one, View)}


def bytes_of(kind: type[tuple[Any, ...]]) -> int:
    """Return the memory of all fields of a set of nodal arrays (the class of a named tuple) per node [bytes]."""
    return sum(one.components * np.dtype(one.dtype).itemsize for one in fields_of(kind).values())


def allocate(kind: type[Arrays], n: int, several: int = 0) -> Arrays:
    """Allocate a set of nodal arrays that consists of fields and views only, for n nodes; n = 0 for a set that is not used.

    kind: class of the set, a named tuple; several: number of arrays in the fields declared with `several`.
    """
    without: Any = [None] * len(declared(kind))
    return with_fields(kind(*without), {name: one.allocate(n, several) for name, one in fields_of(kind).items()})


def with_fields(arrays: Arrays, new: Mapping[str, np.ndarray]) -> Arrays:
    """Return the set of nodal arrays with some fields replaced by the arrays `new`, by name, and with new views of them."""
    shown = [(name, view) for name, view in views_of(type(arrays)).items() if view.of in new]
    new = dict(new) | {name: new[view.of].reshape(-1, ROW)[:, view.part] for name, view in shown}
    return arrays._replace(**new)  # type: ignore[attr-defined]


def with_memory(arrays: Arrays, n: int, *names: str) -> Arrays:
    """Return the set of nodal arrays in which the fields with the given names have memory for n nodes; fields that are
    allocated already are kept."""
    several = {name: len(getattr(arrays, name)) for name in names}
    lacking = [name for name in names if not getattr(arrays, name).size]
    return with_fields(arrays, {name: fields_of(type(arrays))[name].allocate(n, several[name]) for name in lacking})
