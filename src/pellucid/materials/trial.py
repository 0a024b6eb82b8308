"""Trial of a material law: its functions are called once, at rest and in plain Python, so that errors of a user's material
are reported before any kernel is compiled."""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.jit import implementation_of
from pellucid.jit.registry import source_of
from pellucid.materials.derivatives import NotTraced
from pellucid.materials.law import (
    DEFAULTS,
    ZERO_GRADIENT,
    artificial_heating,
    cauchy_stress,
    coupled_curvatures,
    coupled_energy,
    coupled_slopes,
    diffusivity,
    dissipated_energy,
    energy,
    invariant_curvatures,
    invariant_energy,
    invariant_slopes,
    isochoric_energy,
    isochoric_stiffness,
    isochoric_stress,
    point_pressure,
    signal_speed,
    stored_energy,
    update,
    volume_growth,
    volumetric_energy,
    volumetric_stiffness,
    volumetric_stress,
    wave_speed,
)
from pellucid.materials.membrane import (
    Shape,
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
from pellucid.tensors import IDENTITY, NO_STRESS, ZERO_VECTOR, Symmetric, Tensor, determinant, scale
from pellucid.users.users_code import failing_as, file_of, home_of, is_users, place_of

if TYPE_CHECKING:
    from pellucid.materials.contract import PointMaterial
    from pellucid.materials.membrane_material import SolidMembraneMaterial

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
HYPERELASTIC: dict[Operation, tuple[int, tuple[Any, ...]]] = {
    invariant_energy: (1, (0.0, 0.0)),
    invariant_slopes: (2, (0.0, 0.0)),
    invariant_curvatures: (3, (0.0, 0.0)),
    coupled_energy: (1, (0.0, 0.0, 1.0)),
    coupled_slopes: (3, (0.0, 0.0, 1.0)),
    coupled_curvatures: (6, (0.0, 0.0, 1.0)),
    isochoric_energy: (1, (IDENTITY,)),
    isochoric_stress: (6, (IDENTITY,)),
    isochoric_stiffness: (1, (IDENTITY,)),
    volumetric_energy: (1, (1.0,)),
    volumetric_stress: (1, (1.0,)),
    volumetric_stiffness: (1, (1.0,)),
    energy: (1, (IDENTITY,)),
    cauchy_stress: (6, (IDENTITY,)),
    wave_speed: (1, (IDENTITY,)),
}
"""Functions of a hyperelastic law, with the number of values that each returns and the arguments at rest. A function comes
after those from which it can follow."""
STRAINED: dict[str, Tensor] = {
    "a change of volume": (1.01, 0.0, 0.0, 0.0, 1.01, 0.0, 0.0, 0.0, 1.01),
    "a change of shape": (1.0100004848, 0.01 / 1.01, 8e-5, 4.848e-5, 1.0 / 1.01, 0.008, 0.00606, 0.0, 1.0),
}
STRETCHED: dict[str, Shape] = {"a stretch": (1.01, 0.006, -0.004, 0.995)}
"""Deformation gradients of solids and membranes at which a stress is compared with the derivative of the energy."""
STRAIN = 0.01  # of these deformation gradients
STEP = 1e-6  # change of a deformation gradient for central differences of the energy
DIFFERENT = 0.01  # of the largest component of two stresses: their difference if one of them is wrong
AT_REST = 1e-9  # of the stiffness: stress that counts as none
SMALLEST = "its energy must be smallest at rest"
TRACED = "use only + - * / **, `sqrt`, `exp`, `expm1`, `log`, `log1p`, `power` and functions marked with `@pointwise`"
DECORATE = "decorate it with `@rate_type`, `@finite_strain` or `@hyperelastic`, which register functions that most laws share"
DENSITY = "add a field `rho0` to it, the initial density [kg/m³]"
BY_HAND = "`energy`, `cauchy_stress`, `wave_speed`, `volumetric_energy` and `volumetric_stress`"
INSTEAD = {coupled_energy: f"derive the material from `HyperelasticMaterial`, and register {BY_HAND} instead of it"}
"""Remedies by energy, for an energy that cannot be differentiated if registering single functions is not enough."""


class Call(NamedTuple):
    """A function of a material law with arguments for which it is evaluated once, at rest, to check the law."""

    operation: Operation  # function, such as `stored_energy`
    arguments: tuple[Any, ...]  # arguments of the function; the first is the law

    def result(self) -> Any:
        """Return the result of the call. Raises ValueError if the function fails."""

        def told(why: str) -> ValueError:
            remedy = (
                DENSITY if "'rho0'" in why else "the derivatives of the energy must be finite at rest" if self.source else ""
            )
            return ValueError(f"{self.what} fails at rest: {why}{remedy and f'; {remedy}'}")

        with failing_as(told), np.errstate(all="ignore"):
            return self.operation(*self.arguments)

    def number(self, least: float = -np.inf) -> float:
        """Return the result as a finite number, at least `least`. Raises ValueError otherwise."""
        return _number(self.result(), least, self.what)

    def check(self, size: int) -> None:
        """Raise ValueError unless the result consists of `size` finite numbers."""
        _check_tuple(self.result(), size, self.what)

    @property
    def what(self) -> str:
        """Name of the function and its law, as text for messages; of a derived function also of its source."""
        origin = f", derived from `{self.source.__name__}`," if self.source else ""
        return f"`{self.operation.__name__}`{origin} of the law {_named(self.arguments[0])}"

    @property
    def source(self) -> Operation | None:
        """The operation of the law from which the function was derived; None if a user registered the function."""
        kind, source = type(self.arguments[0]), source_of(self.operation)
        if source is None or implementation_of(source, kind) is None:
            return None
        function: Any = implementation_of(self.operation, kind)
        return None if is_users(function.__code__.co_filename) else source


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
    for one in material.operations(law):
        _check_hyperelastic(one)
    _check_moduli(law, material.moduli_at_rest(), "Pa", may_vanish=False)
    calls = calls_of(material, law, state)
    _check_state(calls[update].result(), state, f"`update` of the law {_named(law)}")
    growth = calls[volume_growth].number()
    if abs(growth - 1.0) > 1e-9:
        raise ValueError(
            f"`volume_growth` of the law {_named(law)} is {growth:g} without deformation; it must be 1, the volume ratio"
        )
    for operation in (signal_speed, diffusivity):
        calls[operation].number(least=0.0)
    if implementation_of(cauchy_stress, type(law)) is not None and state.stress == NO_STRESS:
        stiffness = material.density * calls[signal_speed].number() ** 2
        largest = max(cauchy_stress(law, IDENTITY), key=abs)
        if abs(largest) > AT_REST * stiffness:
            sums = ": 2 W₁ + 4 W₂ + W_J must be 0 there" if implementation_of(coupled_energy, type(law)) else ""
            raise ValueError(f"the law {_named(law)} has a stress of {largest:.3g} Pa at rest; {SMALLEST}{sums}")
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
        if operation in SURFACE:
            call.check(SURFACE[operation][0])
        else:
            _check_tuple(call.result(), MEMBRANE[operation], f"`{operation.__name__}` of the law {_named(elastic)}")
    for part, wanted in operations.items():
        if any(operation in SURFACE for operation in wanted):
            _check_stress(part, surface_energy, surface_tension, STRETCHED)
    _check_moduli(elastic, material.moduli_at_rest(), "N/m", may_vanish=True)
    calls[plane_wave_speed].number(least=0.0)
    stress = plane_response(law, initial_shape(law))
    stiffness = material.density * calls[plane_wave_speed].number() ** 2
    if max(abs(s) for s in stress[:3]) > AT_REST * stiffness:
        raise ValueError(f"the law {_named(elastic)} has a stress at rest; {SMALLEST}")


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
    """Raise ValueError unless every function is registered for the law that needs it, or follows from a registered one;
    operations: functions that each law needs."""
    for law, wanted in operations.items():
        lacking = [operation for operation in wanted if _is_lacking(operation, type(law))]
        if not lacking:
            continue
        follow = {source: [one for one in wanted if source_of(one) is source] for source in map(source_of, lacking) if source}
        stated = {source: those for source, those in follow.items() if set(those) <= set(lacking)}
        own = list(dict.fromkeys(_first_source(one, stated) for one in lacking))
        remedies = [DECORATE] if any(operation in DEFAULTS for operation in own) else []
        first = next((operation for operation in own if operation not in DEFAULTS), None)
        remedies += [f"register each, as `@point_function({first.__name__}, {type(law).__name__})`"] if first else []
        remedy = "; then ".join(remedies)
        for source in stated.keys() & set(own):
            if others := [one for one in lacking if one is not source and _first_source(one, stated) is source]:
                verb = "follow" if len(others) > 1 else "follows"
                remedy += f"; {_listed(others)} {verb} from `{source.__name__}` or can be registered instead of it"
        raise ValueError(f"the law {_named(law)} has no {_listed(own)}; {remedy}")


def _first_source(operation: Operation, stated: Collection[Operation]) -> Operation:
    """Return the operation among `stated` from which an operation follows, directly or through others; else the operation."""
    source = source_of(operation)
    return operation if source is None or source not in stated else _first_source(source, stated)


def _is_lacking(operation: Operation, kind: type) -> bool:
    """Return True if an operation has no function for a type of laws. Raises ValueError if its energy cannot be
    differentiated."""
    try:
        return implementation_of(operation, kind) is None
    except NotTraced as error:
        source = source_of(operation)
        place = place_of(error) or home_of(implementation_of(source, kind) if source else None)
        instead = f"register `{operation.__name__}` of this law as well"
        remedy = error.remedy or f"{TRACED}, or {INSTEAD.get(source, instead) if source else instead}"
        raise ValueError(f"{error}, at {place}; {remedy}") from error


def _listed(operations: Sequence[Operation]) -> str:
    return ", ".join(f"`{operation.__name__}`" for operation in operations)


def _check_hyperelastic(law: Any) -> None:
    """Raise ValueError if a function of a hyperelastic law is invalid at rest, or if its stress is not the derivative of its
    energy."""
    for operation, (size, arguments) in HYPERELASTIC.items():
        with suppress(NotTraced):  # a function that the law does not need, since it registers those that follow
            if implementation_of(operation, type(law)) is not None:
                Call(operation, (law, *arguments)).check(size)
    if all(implementation_of(operation, type(law)) for operation in (energy, cauchy_stress)):
        _check_stress(law, energy, _kirchhoff_stress, STRAINED)


def _kirchhoff_stress(law: Any, F: Tensor) -> Symmetric:
    return scale(determinant(F), cauchy_stress(law, F))


def _check_stress(law: Any, energy: Operation, stress: Operation, strained: Mapping[str, tuple[float, ...]]) -> None:
    """Raise ValueError if the Kirchhoff stress of a law is not the derivative of its energy at deformation gradients where both
    are defined. strained: the deformation gradients, by their descriptions."""
    found: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for change, F in strained.items():
        with suppress(ArithmeticError, ValueError), np.errstate(all="ignore"):
            both = _full(stress(law, F)), _derivative(law, energy, F)
            if np.isfinite(both).all():
                found[change] = both
    if not found:
        return
    small = AT_REST * max(np.abs(both).max() for both in found.values()) / STRAIN  # above the error of the differences
    for change, (one, other) in found.items():
        apart, size = np.abs(one - other).max(), np.abs((one, other)).max()
        if apart > DIFFERENT * size + small:
            text = f"the stress of the law {_named(law)} is not the derivative of its energy"
            text += f": at {change} with strains of 1 % they differ by {apart / size:.0%}"
            raise ValueError(
                f"{text}; correct the function that is wrong, or register the energy alone where the stress follows"
            )


def _derivative(law: Any, energy: Operation, F: tuple[float, ...]) -> np.ndarray:
    """Return ∂W/∂F Fᵀ at a deformation gradient F, by central differences of the energy W."""
    n, result = round(len(F) ** 0.5), np.zeros(len(F))
    for k in range(len(F)):
        ahead, behind = ((*F[:k], F[k] + step, *F[k + 1 :]) for step in (STEP, -STEP))
        result[k] = (energy(law, ahead) - energy(law, behind)) / (2.0 * STEP)
    return result.reshape(n, n) @ np.reshape(F, (n, n)).T


def _full(stress: tuple[float, ...]) -> np.ndarray:
    """Return a stress of 6 or, in a plane, 3 components as a matrix."""
    places = [[0, 5, 4], [5, 1, 3], [4, 3, 2]] if len(stress) == 6 else [[0, 2], [2, 1]]
    return np.array(stress)[places]


def _check_moduli(law: Any, moduli: Mapping[str, float], unit: str, may_vanish: bool) -> None:
    """Raise ValueError for a modulus at rest that is negative, or zero unless it may vanish; moduli: by name."""
    limit = "not be below 0" if may_vanish else "be above 0"
    for what, value in moduli.items():
        if not (value > 0.0 or (may_vanish and value == 0.0)):
            text = f"the {what} of the law {_named(law)} is {value:g} {unit} at rest; it must {limit}"
            raise ValueError(f"{text}: correct its energy or its parameters")


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
            f"{what} returns {value} at rest; it must return a finite number"
            + (", not below 0" if least == 0.0 else "")
            + ("" if isfinite(value) else ": check logarithms, roots and divisions at rest")
        )
    return float(value)


def _named(law: Any) -> str:
    """Return the name of the class of a law or state and its file, as text for messages."""
    return f"{type(law).__name__} ({file_of(type(law))})" if hasattr(law, "_fields") else f"a {type(law).__name__}"
