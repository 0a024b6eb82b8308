"""Initial velocity, stress and state of the points of a body: a uniform state plus initial fields; and checks of these
fields."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pellucid.bodies.initial.contract import InitialField
from pellucid.errors import CaseError, Problem
from pellucid.findings import Finding, Path, listed
from pellucid.geometry.shapes.contract import AXES
from pellucid.model import Vector
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts
from pellucid.users.users_code import WrongArray, as_array, failing_as, file_of, home_of, is_own, read_only

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
