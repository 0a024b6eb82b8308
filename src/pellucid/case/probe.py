"""Probes: columns of `history.csv`, and the ways to make one number of a field that they can name."""

import re
from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from pellucid.energy import FIXED_COLUMNS
from pellucid.errors import RunStopped
from pellucid.findings import Finding, Path, hint, listed
from pellucid.model import Vector, check, name_parameter, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition, conditions_in_case
from pellucid.parts.part import Part, Parts
from pellucid.registry import OneNameOf, Registry
from pellucid.state import COMPONENT_NAMES, FIELDS, Field
from pellucid.units import check_si
from pellucid.users.users_code import WrongArray, as_array, failing_as, file_of, is_own

Fetch = Callable[[str], np.ndarray]
"""A field of a body by its name; one order of the points for all fields: for users' functions that of the points' numbers."""


ReductionFunction = Callable[[np.ndarray], Any]  # makes one number of the values of all points, shape (n,)
QuantityFunction = Callable[[Fetch], np.ndarray]


class Quantity(NamedTuple):
    """A function that works out a field of a body from those that it has."""

    function: Callable[[Fetch], np.ndarray]
    field: Field
    of_surface: bool = False
    """True if the function also asks for `TRIANGLES`, those of the body's surface, shape (t, 3), by numbers of its points."""


REDUCTIONS: Registry[ReductionFunction] = Registry("reduction")
QUANTITIES: Registry[Quantity] = Registry("quantity")
NAME = r"[A-Za-z][A-Za-z0-9_-]*"
REACTIONS = ("reaction", "torque")  # of a condition
TRIANGLES = "triangles"
PLACED = ("count", "nearest", "point")  # what needs a key of its own beside the values


def reduction(name: str) -> Callable[[ReductionFunction], ReductionFunction]:
    """Decorator: let probes name a function that makes one number of the values of all points, shape (n,)."""
    if not isinstance(name, str):
        raise TypeError(f'write `@reduction("name")` above {getattr(name, "__name__", name)}')
    _check_name("reduction", name)
    if name in PLACED:
        raise ValueError(f'the reduction "{name}" is taken by pellucid itself: choose another name')

    def add(function: ReductionFunction) -> ReductionFunction:
        REDUCTIONS.register(name, function, function)
        return function

    return add


def _check_name(what: str, name: str) -> None:
    if not re.fullmatch(NAME, name):
        raise ValueError(f'the {what} "{name}" must begin with a letter and hold only letters, digits, - and _')


def quantity(name: str, unit: str, meaning: str, components: int = 1) -> Callable[[QuantityFunction], QuantityFunction]:
    """Decorator: let probes name a field that a function works out from those of a body.

    The function takes `field`, which gives fields by name, and returns an array of shape (n,), or (n, components) where there
    are 3 or 6 of them. unit: in SI units, such as "m/s". Raises ValueError for another number of components or another unit.
    """
    if components not in (1, 3, 6):
        raise ValueError(
            f'the quantity "{name}" has {components} components; it can have 1, 3 (a vector) or 6 (a symmetric tensor)'
        )
    check_si(unit)
    _check_name("quantity", name)
    if name in FIELDS:
        raise ValueError(f'the quantity "{name}" is taken by the field of this name: choose another name')

    def add(function: QuantityFunction) -> QuantityFunction:
        QUANTITIES.register(name, Quantity(function, Field(components, unit, meaning)), function)
        return function

    return add


def surface_quantity(
    name: str, unit: str, meaning: str, components: tuple[str, ...] = ()
) -> Callable[[QuantityFunction], QuantityFunction]:
    """Decorator: the same of a body's surface, whose triangles `field(TRIANGLES)` gives; components: names, if several."""

    def add(function: QuantityFunction) -> QuantityFunction:
        known = Field(max(1, len(components)), unit, meaning, components)
        QUANTITIES.register(name, Quantity(function, known, of_surface=True), function)
        return function

    return add


reduction("mean")(np.mean)
reduction("max")(np.max)
reduction("min")(np.min)
reduction("sum")(np.sum)


@quantity("angular_velocity", "rad/s", "angular velocity with which a rigid body would have the angular momentum", 3)
def _angular_velocity(field: Fetch) -> np.ndarray:
    m, x, v = field("mass")[:, None], field("position"), field("velocity")
    r, u = (values - np.sum(m * values, axis=0) / np.sum(m) for values in (x, v))
    inertia = np.sum(m * r * r) * np.eye(3) - np.einsum("pi,pj->ij", m * r, r)
    turn = np.linalg.pinv(inertia, rcond=1e-10, hermitian=True) @ np.sum(m * np.cross(r, u), axis=0)
    return np.tile(turn, (len(x), 1))


OWN_REDUCTIONS = (*REDUCTIONS.entries, *PLACED)


COLUMNS = (
    *("time", "step", "dt", "kinetic_energy", "internal_energy", "strain_energy", "hourglass_energy", "dissipated_energy"),
    *("bending_energy", "constraint_energy"),
    *(channel.name for channel in FIXED_COLUMNS),
    *("inflow_energy", "inflow_work", "inflow_points", "inflow_mass"),
    *("outflow_energy", "outflow_work", "outflow_points", "outflow_mass"),
    *("artificial_heat", "transfer_error", "time_integration_error", "energy_error", "momentum_x", "momentum_y", "momentum_z"),
)
"""Columns of the history that probes cannot be called."""


def other_columns(parts: Parts) -> list[str]:
    """The columns that the history of a case may have beside those of probes."""
    conditions = conditions_in_case(parts)
    loads = (name for condition in conditions if (name := condition.load_channel()) is not None)
    channels = (channel.name for condition in conditions for channel in condition.channels())
    of_bodies = (channel.name for body in parts.of(BodyModel) for channel in body.channels())
    return [*COLUMNS, *loads, *channels, *of_bodies, *(name for condition in conditions for name in condition.columns())]


class Probe(Part):
    """A column of `history.csv`: a field of a body reduced to one number, or a reaction, at each probe instant."""

    unique_name: ClassVar[bool] = True

    name: str = name_parameter("name of the column")
    body: str | None = parameter("", "name of the body", None)
    quantity: str = parameter("", 'name of a field of the body, such as pressure, or "reaction" or "torque" of a condition')
    component: str | None = parameter("", "x, y, z or xx, yy, zz, yz, xz, xy; without it length or von Mises' stress", None)
    reduce: Annotated[str, OneNameOf(REDUCTIONS.entries, *PLACED)] = parameter(
        "",
        'how the points become one number: "count" those above a value; "nearest" takes the point that is nearest to a place '
        'at the moment, "point" follows the one that was nearest at the start',
        "mean",
    )
    at: Vector | None = parameter("m", 'place for "nearest" and "point"', None)
    above: float = parameter("", 'value that "count" compares with, in SI units', 0.0)
    change: bool = parameter("", "whether the value at the start is subtracted", False)
    carried: bool = parameter(
        "",
        'for the position of a "point": where the place `at` itself is, which moves as the point nearest to it, and on a rigid '
        "body with the body",
        False,
    )
    condition: str | None = parameter(
        "",
        'for quantity = "reaction": name of the support, motion, contact, wall, inflow, outflow or mean-velocity load; its '
        'mean force since the row before; for "torque": name of a motion that leads a rigid body; its mean torque about the '
        "centre of mass",
        None,
    )

    @check
    def _is_complete(self) -> None:
        if (self.reduce in ("nearest", "point")) != (self.at is not None):
            raise ValueError('`at = [x, y, z]` belongs to `reduce = "nearest"` or "point": give both or neither')
        if (self.quantity in REACTIONS) != (self.condition is not None):
            raise ValueError('`condition` belongs to `quantity = "reaction"` or "torque": give both or neither')
        if (self.body is None) != (self.condition is not None):
            raise ValueError("a probe needs the name of a `body`, or for a reaction that of a `condition`, and not both")
        if self.carried and (self.quantity, self.reduce) != ("position", "point"):
            raise ValueError('`carried` belongs to `quantity = "position"` with `reduce = "point"`')
        if self.carried and self.component is None:
            raise ValueError("`carried` needs a `component`, x, y or z")

    @property
    def unit(self) -> str:
        """SI unit of its column, "" for a pure number."""
        if self.body is None:
            return "N m" if self.quantity == "torque" else "N"
        return "" if self.reduce == "count" else self.field().unit

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Report an unknown body, field, component or condition."""
        if self.name in other_columns(parts):
            yield Finding((*path, "name"), f"the history has a column {self.name} of its own", "choose another name")
        if self.body is None:
            yield from self._reaction_problems(path, parts)
            choices = COMPONENT_NAMES[3]
        elif unknown := list(parts.unknown(BodyModel, (*path, "body"), self.body)):
            yield from unknown
            return
        else:
            body = parts.named(BodyModel, self.body)
            fields = [*(FIELDS if body is None else body.probed), *QUANTITIES.entries]
            if self.quantity not in fields:
                text = f"body {self.body} has no such field; it has {listed(fields)}"
                yield Finding((*path, "quantity"), text, hint(self.quantity, fields))
                return
            choices = self.field().names
            if body is not None and self.of_surface and not body.has_triangles:
                text = f"body {self.body} has no surface of triangles, of which {self.quantity} tells"
                yield Finding((*path, "quantity"), text, "name a membrane, a film in space or a meshless-solid")
        if self.component is not None and self.component not in choices:
            text = f"{self.quantity} has {f'the components {listed(choices)}' if choices else 'no components'}"
            yield Finding((*path, "component"), text, "" if choices else "leave `component` out")

    def _reaction_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        turns = self.quantity == "torque"
        every = parts.of(Condition)
        names = [name for other in every if (name := other.turning_reaction(parts) if turns else other.reaction())]
        if self.condition not in names and parts.are_sound(Condition):
            if turns:
                yield Finding((*path, "condition"), *self._no_turning_motion(names))
                return
            what = "support, motion, contact, wall, inflow, outflow or mean-velocity"
            text = f"no {what} has this name; there are {listed(names) or 'none with a name'}"
            yield Finding((*path, "condition"), text, hint(self.condition or "", names) or "give it a `name`")

    def _no_turning_motion(self, names: list[str]) -> tuple[str, str]:
        """Return what a torque needs, and what to do."""
        text = f"`torque` is that of a [[motion]] on a rigid body, and `{self.condition}` is none"
        if names:
            return f"{text}; such motions are {listed(names)}", hint(self.condition or "", names) or "name one of these"
        remedy = 'use quantity = "reaction", or name a [[motion]] whose body has `rigid = true`'
        return f"{text}; the case has no such motion with a name", remedy

    def field(self) -> Field:
        """Return components, unit and meaning of the quantity that the probe reads."""
        return QUANTITIES.entries[self.quantity].field if self.quantity in QUANTITIES.entries else FIELDS[self.quantity]

    @property
    def of_surface(self) -> bool:
        """True if its quantity is of the body's surface, and not of its points."""
        quantity = QUANTITIES.entries.get(self.quantity)
        return quantity is not None and quantity.of_surface

    @property
    def runs_users_code(self) -> bool:
        """True if its quantity or its reduction is not of the package."""
        quantity = QUANTITIES.entries.get(self.quantity)
        return self.reduce not in OWN_REDUCTIONS or (quantity is not None and not is_own(file_of(quantity.function)))

    def values(self, fetch: Fetch) -> np.ndarray:
        """The quantity of every point, shape (n,) or (n, components), from the fields that `fetch` gives by name."""
        own = QUANTITIES.entries.get(self.quantity)
        if own is None:
            return fetch(self.quantity)
        n, components = len(fetch("id")), own.field.components
        shape = (n,) if components == 1 else (n, components)
        return _checked(f'the quantity "{self.quantity}" of body {self.body}', own.function, fetch, shape)

    def reduced(self, values: np.ndarray) -> float:
        """The number that the registered reduction makes of the values of all points, shape (n,). Raises RunStopped."""
        what = f'the reduction "{self.reduce}" of the probe {self.name}'
        return float(_checked(what, REDUCTIONS.entries[self.reduce], values, ()))


def _checked(what: str, function: Callable[[Any], Any], given: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Call a function and return its result as an array of this shape. Raises RunStopped; what: name of the function in a
    message."""
    with failing_as(lambda why: RunStopped(f"{what} fails: {why}"), function):
        found = function(given)
    try:
        return as_array(found, shape, function)
    except WrongArray as error:
        raise RunStopped(f"{what} {error}") from None
