"""Probes: columns of `history.csv`, and the registered reductions and quantities that they can name; all columns that plots and
checks may name, and their units, before a run."""

import re
from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from pellucid.case.steady import SteadyCase
from pellucid.energy import FIXED_COLUMNS
from pellucid.errors import RunStopped
from pellucid.findings import Finding, Path, hint, listed
from pellucid.geometry.meshes.enclosure import ellipsoid_of, surface_area, volume_with_lids
from pellucid.model import Vector, check, name_parameter, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition, conditions_in_case
from pellucid.parts.part import Part, Parts
from pellucid.registry import OneNameOf, Registry
from pellucid.state import COMPONENT_NAMES, FIELDS, Field
from pellucid.units import check_si
from pellucid.users.users_code import WrongArray, as_array, failing_as, file_of, is_own

Fetch = Callable[[str], np.ndarray]
"""Function that returns a field of a body by name. All fields have the same order of points; for user-defined functions
this is the order of the point numbers."""


ReductionFunction = Callable[[np.ndarray], Any]  # makes one number of the values of all points, shape (n,)
QuantityFunction = Callable[[Fetch], np.ndarray]


class Quantity(NamedTuple):
    """A registered quantity: a field of a body that probes can name and that a function computes from other fields.
    `function` receives a function that returns other fields by name, and returns the values, shape (n,) or (n, components);
    `field` holds components, unit and meaning."""

    function: Callable[[Fetch], np.ndarray]
    field: Field
    of_surface: bool = False
    """True if the function also requires `TRIANGLES`: the triangles of the body's surface, shape (t, 3), as point numbers."""


REDUCTIONS: Registry[ReductionFunction] = Registry("reduction")
QUANTITIES: Registry[Quantity] = Registry("quantity")
NAME = r"[A-Za-z][A-Za-z0-9_-]*"
REACTIONS = ("reaction", "torque")  # quantities of a condition
TRIANGLES = "triangles"
PLACED = ("count", "nearest", "point")  # reductions that need a further key


def reduction(name: str) -> Callable[[ReductionFunction], ReductionFunction]:
    """Decorator that registers a function under `name` as a reduction, which probes can name. The function receives the
    values of all points of a body, shape (n,), and returns one number."""
    if not isinstance(name, str):
        raise TypeError(f'write `@reduction("name")` above {getattr(name, "__name__", name)}')
    _check_name("reduction", name)
    if name in PLACED:
        raise ValueError(f'the reduction "{name}" is reserved by pellucid; choose another name')

    def add(function: ReductionFunction) -> ReductionFunction:
        REDUCTIONS.register(name, function, function)
        return function

    return add


def _check_name(what: str, name: str) -> None:
    if not re.fullmatch(NAME, name):
        raise ValueError(f'the {what} "{name}" must start with a letter and contain only letters, digits, - and _')


def quantity(name: str, unit: str, meaning: str, components: int = 1) -> Callable[[QuantityFunction], QuantityFunction]:
    """Decorator that registers a function under `name` as a quantity (a field of a body), which probes can name.

    The function receives `field`, a function that returns other fields of the body by name, and returns an array of shape (n,),
    or (n, components) for 3 or 6 components. unit: SI unit, such as "m/s". meaning: description. Raises ValueError for another
    number of components or another unit.
    """
    if components not in (1, 3, 6):
        raise ValueError(f'the quantity "{name}" has {components} components; use 1, 3 (a vector) or 6 (a symmetric tensor)')
    check_si(unit)
    _check_name("quantity", name)
    if name in FIELDS:
        raise ValueError(f'the quantity "{name}" has the name of a field; choose another name')

    def add(function: QuantityFunction) -> QuantityFunction:
        QUANTITIES.register(name, Quantity(function, Field(components, unit, meaning)), function)
        return function

    return add


def surface_quantity(
    name: str, unit: str, meaning: str, components: tuple[str, ...] = ()
) -> Callable[[QuantityFunction], QuantityFunction]:
    """Decorator that registers a quantity of a body's surface under `name`, which probes can name. The function receives
    `field`, as in `quantity`; `field(TRIANGLES)` returns the triangles of the surface, shape (t, 3).

    unit: SI unit. meaning: description. components: names of the components if there are several.
    """

    def add(function: QuantityFunction) -> QuantityFunction:
        known = Field(max(1, len(components)), unit, meaning, components)
        QUANTITIES.register(name, Quantity(function, known, of_surface=True), function)
        return function

    return add


reduction("mean")(np.mean)
reduction("max")(np.max)
reduction("min")(np.min)
reduction("sum")(np.sum)


@quantity(
    "angular_velocity",
    "rad/s",
    "angular momentum divided by the inertia tensor: angular velocity of an equivalent rigid body",
    3,
)
def _angular_velocity(field: Fetch) -> np.ndarray:
    m, x, v = field("mass")[:, None], field("position"), field("velocity")
    r, u = (values - np.sum(m * values, axis=0) / np.sum(m) for values in (x, v))
    inertia = np.sum(m * r * r) * np.eye(3) - np.einsum("pi,pj->ij", m * r, r)
    turn = np.linalg.pinv(inertia, rcond=1e-10, hermitian=True) @ np.sum(m * np.cross(r, u), axis=0)
    return np.tile(turn, (len(x), 1))


OWN_REDUCTIONS = (*REDUCTIONS.entries, *PLACED)


COLUMNS = (
    *("time", "step", "dt", "kinetic_energy", "internal_energy", "strain_energy", "hourglass_energy", "dissipated_energy"),
    *("bending_energy", "constraint_energy", "staggering_energy"),
    *(channel.name for channel in FIXED_COLUMNS),
    *("mass_matrix_work", "inflow_energy", "inflow_work", "inflow_points", "inflow_mass"),
    *("outflow_energy", "outflow_work", "outflow_points", "outflow_mass"),
    *("artificial_heat", "transfer_error", "time_integration_error", "energy_error", "momentum_x", "momentum_y", "momentum_z"),
)
"""Columns of the history whose names probes cannot have."""


def other_columns(parts: Parts) -> list[str]:
    """Return the names of the columns that the history of a case has in addition to its probes. parts: parts (tables) of
    the case."""
    conditions = conditions_in_case(parts)
    loads = (name for condition in conditions if (name := condition.load_channel()) is not None)
    channels = (channel.name for condition in conditions for channel in condition.channels())
    of_bodies = (channel.name for body in parts.of(BodyModel) for channel in body.channels())
    return [*COLUMNS, *loads, *channels, *of_bodies, *state_columns(parts)]


def state_columns(parts: Parts) -> dict[str, str]:
    """Return names and SI units of the columns of the history that show the state of conditions and of a steady analysis.
    parts: parts (tables) of the case."""
    shown: list[Condition | SteadyCase] = [*conditions_in_case(parts), *parts.of(SteadyCase)]
    return {name: unit for part in shown for name, unit in part.columns().items()}


class Probe(Part):
    """A column of `history.csv`: a field of a body reduced to one number, or a reaction, at the time of each row."""

    unique_name: ClassVar[bool] = True

    name: str = name_parameter("name of the column")
    body: str | None = parameter("", "name of the body", None)
    quantity: str = parameter("", 'name of a field of the body, such as pressure, or "reaction" or "torque" of a condition')
    component: str | None = parameter(
        "", "x, y, z or xx, yy, zz, yz, xz, xy (default: magnitude of a vector, von Mises equivalent of a stress)", None
    )
    reduce: Annotated[str, OneNameOf(REDUCTIONS.entries, *PLACED)] = parameter(
        "",
        'reduction over the points of the body; "count": number of points above a value; "nearest": the point '
        "currently nearest "
        'to `at`; "point": the point initially nearest to `at`',
        "mean",
    )
    at: Vector | None = parameter("m", 'position at which reduce = "nearest" and "point" look for a point', None)
    above: float = parameter("", 'threshold of reduce = "count", in SI units', 0.0)
    change: bool = parameter("", "True: subtract the initial value", False)
    carried: bool = parameter(
        "",
        'True, for the position of a "point": the current position of the material place `at`, moved with the nearest point or '
        "with the rigid body",
        False,
    )
    condition: str | None = parameter(
        "",
        'for quantity = "reaction": name of the support, motion, contact, wall, inflow, outflow or mean-velocity load '
        "(mean force "
        'since the previous row); for "torque": name of the motion of a rigid body (mean torque about the centre of mass since '
        "the previous row)",
        None,
    )

    @check
    def _is_complete(self) -> None:
        if (self.reduce in ("nearest", "point")) != (self.at is not None):
            raise ValueError(
                '`at = [x, y, z]` is required for `reduce = "nearest"` or "point", and only for these; add or remove it'
            )
        if (self.quantity in REACTIONS) != (self.condition is not None):
            raise ValueError(
                '`condition` is required for `quantity = "reaction"` or "torque", and only for these; add or remove it'
            )
        if (self.body is None) != (self.condition is not None):
            raise ValueError("a probe requires a `body`, or, for a reaction, a `condition`; set one of the two")
        if self.carried and (self.quantity, self.reduce) != ("position", "point"):
            raise ValueError('`carried` is allowed only for `quantity = "position"` with `reduce = "point"`; remove it')
        if self.carried and self.component is None:
            raise ValueError("`carried` requires a `component`; set x, y or z")

    @property
    def unit(self) -> str:
        """SI unit of the history column of the probe, "" for a dimensionless number."""
        if self.body is None:
            return "N m" if self.quantity == "torque" else "N"
        return "" if self.reduce == "count" else self.field().unit

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for an unknown body, field, component or condition, and for a reserved name.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        if self.name in other_columns(parts):
            yield Finding((*path, "name"), "the name is reserved for a column of the history", "Choose another name.")
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
                text = f"body {self.body} has no field of this name; available: {listed(fields)}"
                yield Finding((*path, "quantity"), text, hint(self.quantity, fields))
                return
            choices = self.field().names
            if body is not None and self.of_surface and not body.has_triangles:
                text = f"{self.quantity} requires a surface of triangles, which body {self.body} does not have"
                yield Finding((*path, "quantity"), text, "Set `body` to a membrane, a film in space or a meshless-solid.")
        if self.component is not None and self.component not in choices:
            text = f"{self.quantity} has {f'the components {listed(choices)}' if choices else 'no components'}"
            yield Finding((*path, "component"), text, "" if choices else "Remove `component`.")

    def _reaction_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        turns = self.quantity == "torque"
        every = parts.of(Condition)
        names = [name for other in every if (name := other.turning_reaction(parts) if turns else other.reaction())]
        if self.condition not in names and parts.are_sound(Condition):
            if turns:
                yield Finding((*path, "condition"), *self._no_turning_motion(names))
                return
            what = "support, motion, contact, wall, inflow, outflow or mean-velocity"
            text = f"no {what} has this name; available: {listed(names) or 'none with a name'}"
            yield Finding((*path, "condition"), text, hint(self.condition or "", names) or "Add this `name` to the condition.")

    def _no_turning_motion(self, names: list[str]) -> tuple[str, str]:
        """Return the text of the problem and the remedy for a probe of a torque whose condition is not a motion of a rigid
        body. names: motions of rigid bodies in the case."""
        text = f"`torque` requires a [[motion]] of a rigid body, but `{self.condition}` is not one"
        if names:
            return (
                f"{text}; available: {listed(names)}",
                hint(self.condition or "", names) or "Set `condition` to one of these.",
            )
        remedy = 'Use quantity = "reaction", or set `condition` to a [[motion]] of a body with `rigid = true`.'
        return f"{text}; the case has no named motion of a rigid body", remedy

    def field(self) -> Field:
        """Return components, unit and meaning of the quantity that the probe reads."""
        return QUANTITIES.entries[self.quantity].field if self.quantity in QUANTITIES.entries else FIELDS[self.quantity]

    @property
    def of_surface(self) -> bool:
        """True if the quantity of the probe belongs to the surface of the body (`surface_quantity`), not to its points."""
        quantity = QUANTITIES.entries.get(self.quantity)
        return quantity is not None and quantity.of_surface

    @property
    def runs_users_code(self) -> bool:
        """True if the quantity or the reduction of the probe is a function of the user."""
        quantity = QUANTITIES.entries.get(self.quantity)
        return self.reduce not in OWN_REDUCTIONS or (quantity is not None and not is_own(file_of(quantity.function)))

    def values(self, fetch: Fetch) -> np.ndarray:
        """Return the quantity of the probe at every point, shape (n,) or (n, components) in SI units. fetch: function that
        returns a field of the probe's body by name."""
        own = QUANTITIES.entries.get(self.quantity)
        if own is None:
            return fetch(self.quantity)
        n, components = len(fetch("id")), own.field.components
        shape = (n,) if components == 1 else (n, components)
        return _checked(f'the quantity "{self.quantity}" of body {self.body}', own.function, fetch, shape)

    def reduced(self, values: np.ndarray) -> float:
        """Reduce the values of all points, shape (n,), to one number with the registered reduction of the probe. Raises
        RunStopped if the reduction fails or does not return a number."""
        what = f'the reduction "{self.reduce}" of the probe {self.name}'
        return float(_checked(what, REDUCTIONS.entries[self.reduce], values, ()))


def _checked(what: str, function: Callable[[Any], Any], given: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return `function(given)`, the result of a function that may be user code, as an array of the given shape. Raises
    RunStopped if the function fails or returns another shape; what: name of the function in the message."""
    with failing_as(lambda why: RunStopped(f"{what} raised an error: {why}"), function):
        found = function(given)
    try:
        return as_array(found, shape, function)
    except WrongArray as error:
        raise RunStopped(f"{what} {error}") from None


ROUND = 1e-4  # smallest relative difference of two axes that defines a direction: meshes of balls differ less


@surface_quantity("surface_area", "m^2", "area of a surface, or of the outer faces of a solid")
def _surface_area(field: Fetch) -> np.ndarray:
    return _everywhere(field, surface_area(field("position"), field(TRIANGLES)))


@surface_quantity("enclosed_volume", "m^3", "volume enclosed by a surface; an open surface is closed by lids over its rims")
def _enclosed_volume(field: Fetch) -> np.ndarray:
    return _everywhere(field, volume_with_lids(field("position"), field(TRIANGLES)))


@surface_quantity(
    "taylor_deformation",
    "",
    "(L - B)/(L + B) of the longest axis L and the shortest axis B of the ellipsoid with the inertia of the enclosed volume",
)
def _taylor_deformation(field: Fetch) -> np.ndarray:
    return _everywhere(field, ellipsoid_of(field("position"), field(TRIANGLES)).deformation)


@surface_quantity(
    "inclination",
    "rad",
    "angle between x and the longest axis of the ellipsoid with the inertia of the enclosed volume; nan for a ball",
)
def _inclination(field: Fetch) -> np.ndarray:
    found = ellipsoid_of(field("position"), field(TRIANGLES))
    long, middle, _ = found.axes
    along = found.directions[0] if long - middle > ROUND * long else np.full(3, np.nan)
    return _everywhere(field, np.arctan2(np.hypot(along[1], along[2]), abs(along[0])))


@surface_quantity(
    "semi_axes", "m", "semi-axes of the ellipsoid with the inertia of the enclosed volume", ("long", "middle", "short")
)
def _semi_axes(field: Fetch) -> np.ndarray:
    return _everywhere(field, ellipsoid_of(field("position"), field(TRIANGLES)).axes)


@quantity("extent", "m", "extent of the body along each axis, between its outermost points", 3)
def _extent(field: Fetch) -> np.ndarray:
    return _everywhere(field, np.ptp(field("position"), axis=0))


def _everywhere(field: Fetch, value: float | np.ndarray) -> np.ndarray:
    return np.tile(value, (len(field("id")), *[1] * np.ndim(value)))


COLUMN_UNITS = {
    "time": "s",
    "dt": "s",
    "step": "",
    "energy_error": "",
    "inflow_points": "",
    "inflow_mass": "kg",
    "outflow_points": "",
    "outflow_mass": "kg",
}
MOMENTUM, ENERGY = "kg m/s", "J"


def unit_of(name: str, parts: Parts) -> str | None:
    """Return the SI unit of the column `name` of the history, "" for a dimensionless number; None if the history of a case
    with the given parts (tables of the case) has no column with this name."""
    probe = parts.named(Probe, name)
    if probe is not None:
        return probe.unit
    if name in COLUMN_UNITS:
        return COLUMN_UNITS[name]
    if (unit := state_columns(parts).get(name)) is not None:
        return unit
    if name.startswith("momentum_"):
        return MOMENTUM
    return ENERGY if name in other_columns(parts) else None


def beyond_end(time: float, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield a finding at `path` if a time [s] is later than the end of the run. parts: the parts of the case."""
    clock: Any = parts.sections["time"].items[0]
    if hasattr(clock, "passed") and clock.passed(time):
        yield Finding(path, f"{time:g} s is later than time.end = {clock.end:g} s", "Set a time up to time.end.")


def unknown_column(name: str, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield a finding at `path` if the history will have no column `name`; no finding while a probe or condition is invalid.
    parts: the parts of the case."""
    sound = parts.are_sound(Probe) and parts.are_sound(Condition)
    if sound and unit_of(name, parts) is None:
        names = [*parts.names(Probe), "time", *other_columns(parts)]
        told = list(state_columns(parts))
        text = f"not a column of the history; available probes: {listed(parts.names(Probe)) or 'none'}"
        text += f"; other columns: {', '.join([*told, 'time', 'energies'])}"
        yield Finding(path, text, hint(name, names) or "Add a [[probe]] with this name.")
