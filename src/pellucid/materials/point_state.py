"""State of points for their material law: of a single point, and of all points as arrays.

A state is a NamedTuple of numbers and of tuples of numbers, decorated with `point_state`. The same type holds the arrays of
a body: `FluidState(stress, internal_energy)` of one point is (6-tuple, float), of n points (array (n, 6), array (n,)). The
names of its fields are the names of the arrays in results and checkpoints.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Protocol, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from pellucid.jit import generic, point_function
from pellucid.state import FIELDS, Field, declare_field
from pellucid.tensors import Symmetric
from pellucid.units import check_si

SHARED = ("stress", "internal_energy", "strain_energy", "dissipated_energy", "deformation_gradient")
"""Fields of `FIELDS` that states may use without declaring them."""


class PointState(Protocol):
    """State of a point under any material law: a NamedTuple whose fields include the Cauchy stress [Pa]."""

    @property
    def _fields(self) -> tuple[str, ...]: ...

    @property
    def stress(self) -> Symmetric: ...

    def __iter__(self) -> Iterator[object]: ...


StateType = TypeVar("StateType", bound=PointState)


@generic
def load(arrays: PointState, p: int) -> PointState:
    """Return the state of point p from the arrays of a body."""


@generic
def store(arrays: PointState, p: int, state: PointState) -> None:
    """Write the state of point p to the arrays of a body."""


def initial_arrays(state: PointState, n: int) -> dict[str, np.ndarray]:
    """Return the arrays, by field name with one row per point, of n points that all have one state."""
    values = {name: np.array(value, dtype=float) for name, value in zip(state._fields, state, strict=True)}
    return {name: np.full((n, *value.shape), value) for name, value in values.items()}


def in_arrays(state: StateType, arrays: Mapping[str, np.ndarray]) -> StateType:
    """Return the states of all points of a body, of the same type as `state`, from the arrays of the body by name."""
    holder: Any = type(state)
    return holder(*(arrays[name] for name in state._fields))


def point_state(**own: tuple[str, str]) -> Callable[[type[StateType]], type[StateType]]:
    """Class decorator: declare a type of states, stored in arrays with as many components as its annotations define.

    own: unit and meaning of each field that `pellucid.state.FIELDS` does not contain, e.g. `@point_state(overstress=("Pa",
    "stress of the Maxwell branch"))`. Raises TypeError for a state that cannot be stored.
    """

    def declare(state: type[StateType]) -> type[StateType]:
        sizes = {name: _components(state, name, kind) for name, kind in get_type_hints(state).items()}
        if sizes.get("stress") != 6:
            raise TypeError(f"{state.__name__} has no `stress: Symmetric`, which every state of a point has")
        if surplus := own.keys() - sizes.keys():
            raise TypeError(f"{state.__name__} has no field `{min(surplus)}`, for which point_state is given a unit")
        for name, size in sizes.items():
            _declare_field(state, name, size, own.get(name))
        _register(state, sizes)
        return state

    return declare


def _components(state: type, name: str, kind: object) -> int:
    if kind is float:
        return 1
    parts = get_args(kind)
    if get_origin(kind) is tuple and len(parts) > 1 and set(parts) == {float}:
        return len(parts)
    raise TypeError(f"{state.__name__}.{name} must be a float, or a tuple of two or more floats whose number is fixed")


def _declare_field(state: type, name: str, size: int, unit_and_meaning: tuple[str, str] | None) -> None:
    if unit_and_meaning is not None:
        field = Field(size, *unit_and_meaning)
        check_si(field.unit)
        declare_field(name, field, state.__name__)
    elif name not in SHARED:
        raise TypeError(f'{state.__name__}.{name}: declare it with @point_state({name}=("unit", "meaning"))')
    elif FIELDS[name].components != size:
        raise TypeError(f"{state.__name__}.{name} has {FIELDS[name].components} components, not {size}")


def _register(state: type, sizes: dict[str, int]) -> None:
    """Generate the functions `load` and `store` for a class of states: numba needs every component written out. sizes:
    number of components of each field."""
    values, lines = [], []
    for name, size in sizes.items():
        places = [f"arrays.{name}[p]"] if size == 1 else [f"arrays.{name}[p, {k}]" for k in range(size)]
        values.append(places[0] if size == 1 else f"({', '.join(places)})")
        lines += [f"{place} = state.{name}" + (f"[{k}]" if size > 1 else "") for k, place in enumerate(places)]
    source = f"def load(arrays, p):\n    return {state.__name__}({', '.join(values)})\n"
    source += "\ndef store(arrays, p, state):\n" + "".join(f"    {line}\n" for line in lines)
    names: dict[str, Any] = {state.__name__: state, "__name__": state.__module__}
    exec(source, names)
    point_function(load, state)(names["load"])
    point_function(store, state)(names["store"])
