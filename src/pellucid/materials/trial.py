"""Trial of a material law: its functions are called once, at rest and in plain Python, so that errors of a user's material
are reported before any kernel is compiled."""

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.jit import implementation_of
from pellucid.jit.registry import follows_from_others
from pellucid.materials.law import (
    DEFAULTS,
    ZERO_GRADIENT,
    artificial_heating,
    diffusivity,
    dissipated_energy,
    point_pressure,
    signal_speed,
    stored_energy,
    update,
    volume_growth,
)
from pellucid.materials.membrane import (
    initial_shape,
    largest_strain,
    plane_response,
    plane_wave_speed,
    shape_of,
    smoothed,
    stretched,
    stretched_midway,
)
from pellucid.materials.point_state import load
from pellucid.materials.surface_law import (
    stretch_curvatures,
    stretch_energy,
    stretch_slopes,
    surface_energy,
    surface_stiffness,
    surface_tension,
)
from pellucid.state import FIELDS
from pellucid.tensors import ZERO_VECTOR
from pellucid.users.users_code import failing_as, file_of

if TYPE_CHECKING:
    from pellucid.materials.contract import PointMaterial
    from pellucid.materials.solid_membrane import SolidMembraneMaterial

Operation = Callable[..., Any]
RATE_FORM = (
    update,
    volume_growth,
    signal_speed,
    diffusivity,
    stored_energy,
    dissipated_energy,
    artificial_heating,
    point_pressure,
)
MEMBRANE: dict[Operation, int] = {
    initial_shape: 4,
    stretched: 4,
    stretched_midway: 4,
    shape_of: 4,
    smoothed: 2,
    plane_response: 4,
    largest_strain: 1,
    plane_wave_speed: 1,
}
"""Functions of a membrane law, with the number of values that each returns."""
UNSTRETCHED, UNDEFORMED = (1.0, 1.0), ((1.0, 0.0, 0.0, 1.0),)
SURFACE: dict[Operation, tuple[int, tuple[Any, ...]]] = {
    stretch_energy: (1, UNSTRETCHED),
    stretch_slopes: (2, UNSTRETCHED),
    stretch_curvatures: (3, UNSTRETCHED),
    surface_energy: (1, UNDEFORMED),
    surface_tension: (3, UNDEFORMED),
    surface_stiffness: (1, UNDEFORMED),
}
"""Functions of a surface law, with the number of values that each returns and the arguments at rest."""
AT_REST = 1e-9  # of the stiffness: stress that counts as none
DECORATE = "decorate it with `@rate_type`, `@finite_strain` or `@hyperelastic`, which register functions that most laws share"


class Call(NamedTuple):
    """A function of a material law with arguments for which it is evaluated once, at rest, to check the law."""

    operation: Operation  # function, such as `stored_energy`
    arguments: tuple[Any, ...]  # arguments of the function; the first is the law

    def result(self) -> Any:
        """Return the result of the call. Raises ValueError if the function fails."""
        name = self.operation.__name__
        with failing_as(lambda why: ValueError(f"`{name}` of the law {_named(self.arguments[0])} fails at rest: {why}")):
            return self.operation(*self.arguments)

    def number(self, least: float = -np.inf) -> float:
        """Return the result as a finite number, at least `least`. Raises ValueError otherwise."""
        return _number(self.result(), least, f"`{self.operation.__name__}` of the law {_named(self.arguments[0])}")


def calls_of(material: "PointMaterial", law: Any, state: Any) -> dict[Operation, Call]:
    """Return each function of a law of material points with the arguments of its trial call, for a point in the initial
    state `state` at rest: zero time step, cells of 1 m."""
    density = material.density
    arguments = {
        update: (law, state, density, ZERO_GRADIENT, 0.0, 1.0),
        volume_growth: (law, ZERO_GRADIENT, 0.0),
        signal_speed: (law, state, density, ZERO_GRADIENT, 1.0),
        diffusivity: (law, density),
        stored_energy: (law, state, density),
        dissipated_energy: (law, state, density),
        artificial_heating: (law, state, density, ZERO_GRADIENT, 1.0),
        point_pressure: (law, state, density),
    }
    return {operation: Call(operation, given) for operation, given in arguments.items()}


def try_material(material: "PointMaterial") -> None:
    """Evaluate the functions of a material law of points once, at rest. Raises ValueError if a function is missing, fails or
    returns an invalid value."""
    name = type(material).__name__
    if material.energy_kind not in ("internal", "strain"):
        raise ValueError(f'{name}.energy_kind = "{material.energy_kind}" must be "internal" or "strain"')
    with failing_as(lambda why: ValueError(f"{name}.law fails: {why}")):
        law = material.law()
    _check_parameters(law, name)
    _check_registered(material.operations(law))
    with failing_as(lambda why: ValueError(f"{name}.initial_state fails: {why}")):
        state = material.initial_state()
    if implementation_of(load, type(state)) is None:
        raise ValueError(
            f"{name}.initial_state returns {_named(state)}, which is not a state of a point: decorate it with `@point_state()`"
        )
    _check_state(state, state, f"{name}.initial_state")
    calls = calls_of(material, law, state)
    _check_state(calls[update].result(), state, f"`update` of the law {_named(law)}")
    growth = calls[volume_growth].number()
    if abs(growth - 1.0) > 1e-9:
        raise ValueError(
            f"`volume_growth` of the law {_named(law)} is {growth:g} without deformation; it must be 1, the volume ratio"
        )
    for operation in (signal_speed, diffusivity):
        calls[operation].number(least=0.0)
    for operation in (stored_energy, dissipated_energy, artificial_heating, point_pressure):
        calls[operation].number()
    for method in (material.wave_speeds, lambda: material.signals(1.0)):
        _check_numbers(material, method)
    with failing_as(lambda why: ValueError(f"{name}.problems fails: {why}")):
        list(material.problems())


def try_membrane(material: "SolidMembraneMaterial") -> None:
    """Evaluate the functions of the law of a membrane material once, for a membrane with a shape at rest. Raises ValueError
    if a function is missing, fails or returns an invalid value."""
    name = type(material).__name__
    with failing_as(lambda why: ValueError(f"{name}.elastic_law fails: {why}")):
        operations, law = material.operations(), material.law(1.0)
    (elastic,) = operations
    _check_parameters(elastic, name)
    _check_registered(operations)
    calls = calls_of_membrane(material, law)
    for operation, call in calls.items():
        size = MEMBRANE[operation] if operation in MEMBRANE else SURFACE[operation][0]
        _check_tuple(call.result(), size, f"`{operation.__name__}` of the law {_named(elastic)}")
    calls[plane_wave_speed].number(least=0.0)
    stress = plane_response(law, initial_shape(law))
    stiffness = material.density * calls[plane_wave_speed].number() ** 2
    if max(abs(s) for s in stress[:3]) > AT_REST * stiffness:
        raise ValueError(f"the law {_named(elastic)} has a stress at rest; its energy must be smallest at rest")


def calls_of_membrane(material: "SolidMembraneMaterial", law: Any) -> dict[Operation, Call]:
    """Return each function of a membrane law with the arguments of its trial call, for a point at rest and a zero time step:
    first the functions of its surface law, if any, then those of the law itself."""
    of_surface = {
        operation: Call(operation, (part, *SURFACE[operation][1]))
        for part, operations in material.operations().items()
        for operation in operations
        if operation in SURFACE
    }
    for call in of_surface.values():
        call.result()
    shape = Call(initial_shape, (law,)).result()
    arguments = {
        initial_shape: (law,),
        stretched: (law, shape, ZERO_VECTOR, 0.0),
        stretched_midway: (law, shape, ZERO_VECTOR, 0.0),
        shape_of: (law, ZERO_VECTOR, 1.0, 1.0),
        smoothed: (law, shape, 1.0, 1.0),
        plane_response: (law, shape),
        largest_strain: (law, shape),
        plane_wave_speed: (law, shape, material.density),
    }
    return of_surface | {operation: Call(operation, given) for operation, given in arguments.items()}


def _check_parameters(law: Any, name: str) -> None:
    """Raise ValueError unless the law is a NamedTuple of numbers, tuples of numbers and other laws; name: method or field
    that contains the law, for the message."""
    if not hasattr(law, "_fields"):
        raise ValueError(f"{name} gives the law {law!r}; it must be a NamedTuple of its parameters")
    for field, value in zip(law._fields, law, strict=True):
        if hasattr(value, "_fields"):
            _check_parameters(value, f"{name}.{field}")
        elif not all(
            isinstance(item, (bool, int, float, np.number)) for item in (value if isinstance(value, tuple) else (value,))
        ):
            raise ValueError(
                f"{_named(law)}.{field} = {value!r} is not a number; kernels accept numbers, tuples of numbers and laws"
            )


def _check_registered(operations: Mapping[Any, Sequence[Operation]]) -> None:
    """Raise ValueError unless every function is registered for the law that needs it; operations: functions that each law
    needs."""
    for law, wanted in operations.items():
        lacking = []
        for operation in wanted:
            name = operation.__name__
            with failing_as(lambda why, name=name: ValueError(f"{why}; register `{name}` of this law as well")):  # type: ignore[misc]
                if implementation_of(operation, type(law)) is None:
                    lacking.append(operation)
        lacking = [operation for operation in lacking if not follows_from_others(operation)] or lacking
        if lacking:
            names = ", ".join(f"`{operation.__name__}`" for operation in lacking)
            own = [operation for operation in lacking if operation not in DEFAULTS]
            remedies = [DECORATE] if len(own) < len(lacking) else []
            remedies += [f"register each, as `@point_function({own[0].__name__}, {type(law).__name__})`"] if own else []
            remedy = " and ".join(remedies)
            raise ValueError(f"the law {_named(law)} has no {names}; {remedy}")


def _check_state(found: Any, wanted: Any, what: str) -> None:
    """Raise ValueError unless the state `found` has the type of the initial state `wanted` and contains finite numbers;
    what: function that returned the state, for the message."""
    if type(found) is not type(wanted):
        raise ValueError(f"{what} returns {_named(found)}; it must return a {type(wanted).__name__}")
    for name, value in zip(wanted._fields, found, strict=True):
        _check_tuple(value, FIELDS[name].components, f"{what}: `{name}`")


def _check_tuple(value: Any, size: int, what: str) -> None:
    if size == 1:
        _number(value, -np.inf, what)
    elif not isinstance(value, tuple) or len(value) != size:
        raise ValueError(f"{what} is {value!r}; it must be a tuple of {size} numbers")
    else:
        for item in value:
            _number(item, -np.inf, what)


def _check_numbers(material: "PointMaterial", method: Callable[[], Any]) -> None:
    name = type(material).__name__
    with failing_as(lambda why: ValueError(f"the wave speeds of {name} fail: {why}")):
        speeds = method()
    _check_tuple(speeds, 2, f"the wave speeds of {name}")


def _number(value: Any, least: float, what: str) -> float:
    if not isinstance(value, (bool, int, float, np.number)):
        raise ValueError(f"{what} returns {value!r} at rest; it must return a number")
    if not (isfinite(value) and value >= least):
        raise ValueError(
            f"{what} returns {value} at rest; it must return a finite number" + (", not below 0" if least == 0.0 else "")
        )
    return float(value)


def _named(law: Any) -> str:
    """Return the name of the class of a law or state and its file, as text for messages."""
    return f"{type(law).__name__} ({file_of(type(law))})" if hasattr(law, "_fields") else f"a {type(law).__name__}"
