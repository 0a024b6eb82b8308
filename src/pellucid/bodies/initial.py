"""Initial fields: additions to the uniform initial state of a body, such as a velocity gradient; the initial state of the
points that follows from them, and checks of these fields.
"""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from math import factorial, pi, sqrt
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from numpy.polynomial.legendre import Legendre
from pydantic import model_validator

from pellucid.errors import CaseError, Problem
from pellucid.findings import Finding, Path, listed
from pellucid.geometry.shapes.contract import AXES
from pellucid.model import Model, Vector, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts
from pellucid.registry import Family, OneOf
from pellucid.users.users_code import WrongArray, as_array, failing_as, file_of, home_of, is_own, read_only


class InitialField(Model):
    """Field added to a quantity of a body at the start. A new kind is a subclass with its own `kind`."""

    quantity: ClassVar[str] = "velocity"
    """The array of the points to which the field is added: the velocity, or a state of the material such as the stress."""

    kind: str

    @abstractmethod
    def at(self, position: np.ndarray) -> np.ndarray:
        """Return the values that the field adds at positions [m], shape (n, 3): one row per position, for velocities [m/s]
        shape (n, 3)."""


class SineWave(InitialField):
    """An initial velocity a sin(k·x + φ) at positions x, with an amplitude vector a, a wave vector k and a phase φ."""

    kind: Literal["sine-wave"] = "sine-wave"
    amplitude: Vector = parameter("m/s", "amplitude a")
    wave_vector: Vector = parameter("rad/m", "wave vector k")
    phase: float = parameter("rad", "phase φ", 0.0)

    def at(self, position: np.ndarray) -> np.ndarray:
        return np.sin(position @ np.array(self.wave_vector) + self.phase)[:, None] * np.array(self.amplitude)


class Polynomial(InitialField):
    """A concentration a (x - x₁)(x - x₂)... of the position x along an axis, with zeros x₁, x₂, ... [m]."""

    quantity: ClassVar[str] = "concentration"

    kind: Literal["polynomial"] = "polynomial"
    factor: float = parameter("", "factor a of the polynomial", 1.0)
    zeros: tuple[float, ...] = parameter("m", "zeros x₁, x₂, ... of the polynomial", ())
    axis: Literal["x", "y", "z"] = parameter("", "axis along which the added field varies", "x")

    def at(self, position: np.ndarray) -> np.ndarray:
        x = position[:, "xyz".index(self.axis)]
        return self.factor * np.prod(x[:, None] - np.array(self.zeros), axis=1)


class SphericalHarmonic(InitialField):
    """A concentration a Y_lm that depends on the direction from a centre. Y_lm is the real spherical harmonic whose square
    has the integral 1 over the unit sphere."""

    quantity: ClassVar[str] = "concentration"

    kind: Literal["spherical-harmonic"] = "spherical-harmonic"
    amplitude: float = parameter("", "factor a of the harmonic", 1.0)
    degree: int = parameter("", "degree l of the harmonic", ge=0, le=20)
    order: int = parameter("", "order m: cos(mφ) for positive m, sin(|m|φ) for negative m; φ is the angle about z from x", 0)
    centre: Vector = parameter("m", "centre", (0.0, 0.0, 0.0))

    @model_validator(mode="after")
    def _has_an_order(self) -> Self:
        if abs(self.order) > self.degree:
            raise ValueError(f"`order` = {self.order} must be between -`degree` and `degree`, here {self.degree}")
        return self

    def at(self, position: np.ndarray) -> np.ndarray:
        """Return the concentration, shape (n,), at positions [m], shape (n, 3). No position may be the centre."""
        offset = position - np.array(self.centre)
        x, y, z = (offset / np.linalg.norm(offset, axis=1)[:, None]).T
        m = abs(self.order)
        around = (x + 1j * y) ** m
        norm = sqrt((2 * self.degree + 1) / (4.0 * pi) * factorial(self.degree - m) / factorial(self.degree + m))
        wave = around.imag if self.order < 0 else around.real
        return self.amplitude * norm * (sqrt(2.0) if m else 1.0) * Legendre.basis(self.degree).deriv(m)(z) * wave


NONE = (0.0, 0.0, 0.0)


class VelocityGradient(InitialField):
    """An initial velocity L (x - x₀) at positions x, with the velocity gradient L and the point x₀ at rest."""

    kind: Literal["velocity-gradient"] = "velocity-gradient"
    x: Vector = parameter("1/s", "gradient of the x velocity component, the first row of L", NONE)
    y: Vector = parameter("1/s", "gradient of the y velocity component", NONE)
    z: Vector = parameter("1/s", "gradient of the z velocity component", NONE)
    origin: Vector = parameter("m", "position x₀ of zero velocity", NONE)

    def at(self, position: np.ndarray) -> np.ndarray:
        return np.asarray((position - np.array(self.origin)) @ np.array((self.x, self.y, self.z)).T)


INITIAL_FIELDS = Family("initial field", InitialField)
Initial = Annotated[InitialField, OneOf(INITIAL_FIELDS)]
INITIAL_MEANING = "fields added to the initial state"

INITIAL_FIELDS.add(SineWave)
INITIAL_FIELDS.add(Polynomial)
INITIAL_FIELDS.add(SphericalHarmonic)
INITIAL_FIELDS.add(VelocityGradient)


Stress = tuple[float, float, float, float, float, float]
"""Stress components xx, yy, zz, yz, xz, xy [Pa]."""


def initial_velocity(uniform: Vector, body: str, fields: Sequence[InitialField], position: np.ndarray) -> np.ndarray:
    """Return the sum of a uniform velocity [m/s] and the initial velocity fields of a body [m/s], shape (n, 3), at positions
    [m], shape (n, 3). body: name of the body.
    """
    velocity = np.tile(np.array(uniform), (len(position), 1))
    for added in added_velocities(body, fields, position):
        velocity += added
    return velocity


def added_velocities(body: str, fields: Sequence[InitialField], position: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the velocity [m/s], shape (n, 3), that each initial field adds at positions [m], shape (n, 3). body: name of the
    body. Raises CaseError if a field fails.
    """
    for number, field in enumerate(fields):
        if field.quantity == "velocity":
            yield _added(field, position, position.shape, f"body.{body}.initial.{number}")


def initial_stress(
    uniform: Stress | None, body: str, fields: Sequence[InitialField], position: np.ndarray
) -> np.ndarray | None:
    """Return the sum of a uniform stress [Pa] and the initial stress fields of a body, shape (n, 6), at positions [m], shape
    (n, 3); None if there is neither. body: name of the body. Raises CaseError if a field fails.
    """
    adding = [(number, field) for number, field in enumerate(fields) if field.quantity == "stress"]
    if uniform is None and not adding:
        return None
    stress = np.tile(np.array(uniform or np.zeros(6)), (len(position), 1))
    for number, field in adding:
        stress += _added(field, position, stress.shape, f"body.{body}.initial.{number}")
    return stress


def add_initial_state(body: str, fields: Sequence[InitialField], arrays: Mapping[str, np.ndarray]) -> None:
    """Add initial fields of quantities other than the velocity, such as the stress or a state variable of the material, to the
    arrays of a body's points, in place. body: name of the body. Raises CaseError if a field fails.
    """
    for number, field in enumerate(fields):
        if field.quantity != "velocity":
            state = arrays[field.quantity]
            state += _added(field, arrays["position"], state.shape, f"body.{body}.initial.{number}")


def _added(field: InitialField, position: np.ndarray, shape: tuple[int, ...], key: str) -> np.ndarray:
    """Return the values that a field adds at positions [m], shape (n, 3). Raises CaseError if the array of the values does
    not have the shape `shape` or contains values that are not finite numbers. key: path of the field in the case, for the
    message."""
    what = f'the initial field of kind "{field.kind}"'
    with failing_as(lambda why: CaseError(Problem(f"{what} fails in `at`: {why}", key)), field.at):
        found = field.at(read_only(position))
    try:
        added = as_array(found, shape, field.at)
    except WrongArray as error:
        raise CaseError(Problem(f"{what} is invalid for the {field.quantity}: `at` {error}", key)) from None
    if not np.isfinite(added).all():
        point = int(np.flatnonzero(~np.isfinite(added).reshape(len(added), -1).all(axis=1))[0])
        place = ", ".join(f"{value:.6g}" for value in position[point])
        text = f"{what} adds {added[point]} to the {field.quantity} of the point at ({place}) m"
        raise CaseError(Problem(text, key, remedy=f"correct its `at`, see {home_of(field.at)}"))
    return added


def initial_problems(fields: Sequence[InitialField], quantities: Sequence[str], path: Path) -> Iterator[Finding]:
    """Yield findings (errors of the case) for initial fields of a quantity that the points of the body at `path` do not
    have. quantities: names of the quantities that the points have."""
    for index, field in enumerate(fields):
        if field.quantity not in quantities:
            text = f'kind "{field.kind}" sets `{field.quantity}`, but the points of this body do not have it'
            yield Finding((*path, "initial", index), text, f"use one of {listed(quantities)}")


def plane_velocity_problems(body: BodyModel, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for initial velocities of a body along or about axes on which the grid allows no
    motion.

    path: path of the body in the data of the case; parts: all parts of the case.
    """
    thin = [axis for axis, counts in enumerate(parts.active_axes) if not counts]
    along = listed([AXES[axis] for axis in thin])
    why = f"the grid is one cell thick along {along}"
    turns = f"bodies rotate about {along} only" if len(thin) == 1 else "nothing rotates"
    for axis in thin:
        enlarge = f"or enlarge the grid along {AXES[axis]}"
        if body.velocity[axis]:
            text = (
                f"the velocity has the component {body.velocity[axis]:g} m/s along "
                f"{AXES[axis]}, but {why} and nothing moves there"
            )
            yield Finding((*path, "velocity"), text, f"set its {AXES[axis]} component to 0, {enlarge}")
        for key in _moving_along(body, axis):
            text = f"gives the body a velocity along {AXES[axis]}, but {why} and nothing moves there"
            yield Finding((*path, *key), text, f"set its {AXES[axis]} component to 0, {enlarge}")
    for axis, rate in enumerate(getattr(body, "angular_velocity", ())):
        if rate and any(other != axis for other in thin):
            text = f"the angular velocity has the component {rate:g} rad/s about {AXES[axis]}, but {why}: {turns}"
            enlarge = f"enlarge the grid along {listed([AXES[other] for other in thin if other != axis])}"
            yield Finding((*path, "angular_velocity"), text, f"set its {AXES[axis]} component to 0, or {enlarge}")


def _moving_along(body: BodyModel, axis: int) -> Iterator[Path]:
    """Yield the paths, within the body, of the initial velocity keys that have a component along an axis. Fields defined by
    users are not evaluated.
    """
    wave, fields = getattr(body, "velocity_wave", None), getattr(body, "initial", ())
    keys: list[tuple[Path, InitialField]] = [] if wave is None else [(("velocity_wave",), wave)]
    keys += [(("initial", number), field) for number, field in enumerate(fields) if field.quantity == "velocity"]
    for key, field in keys:
        if is_own(file_of(type(field))) and field.at(body.places_between_bounds())[:, axis].any():
            yield key
