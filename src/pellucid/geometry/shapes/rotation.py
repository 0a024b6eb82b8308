"""Rotations of shapes, surfaces and meshes about axes."""

from collections.abc import Iterator
from math import cos, radians, sin
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field, field_validator

from pellucid.findings import Finding, Path, Refusal
from pellucid.geometry.shapes.contract import AXES, ActiveAxes
from pellucid.model import Model, Vector, check, parameter
from pellucid.units import in_degrees

QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))  # cosine and sine of 0, 90, 180, 270 degrees


class Rotation(Model):
    """A rotation about an axis through a point, counterclockwise seen against the direction of the axis."""

    axis: Vector = parameter("", "direction of the axis", (0.0, 0.0, 1.0))
    angle: float = parameter("", 'angle in degrees, or a text with a unit such as "0.3 rad"', ge=-360, le=360)
    centre: Vector | None = parameter("m", "a point on the axis. Default: the centre of the rotated object", None)

    _in_degrees = field_validator("angle", mode="before")(in_degrees)

    @check
    def _axis_has_a_direction(self) -> None:
        if not any(self.axis):
            raise Refusal("`axis` has zero length", "set a direction, such as [0, 0, 1]")

    def matrix(self) -> np.ndarray:
        """Return the rotation matrix, shape (3, 3), by Rodrigues' formula; exact for quarter turns about x, y and z."""
        turns, rest = divmod(self.angle, 90.0)
        c, s = QUARTERS[int(turns) % 4] if rest == 0.0 else (cos(radians(self.angle)), sin(radians(self.angle)))
        x, y, z = u = np.array(self.axis) / np.linalg.norm(self.axis)
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.asarray(c * np.eye(3) + (1.0 - c) * np.outer(u, u) + s * across)


Rotations = Rotation | Annotated[tuple[Rotation, ...], Field(min_length=1)] | None
"""The value of the key `rotate` in a case: one rotation, or a list of rotations, applied in their order."""


class Turn(NamedTuple):
    """A composed rotation of points: the point `before` moves to `after`, and all other points rotate about it."""

    matrix: np.ndarray  # (3, 3) rotation matrix
    before: np.ndarray  # (3,) position of a point before the rotation [m]
    after: np.ndarray  # (3,) position of this point after the rotation [m]

    def forth(self, points: np.ndarray) -> np.ndarray:
        """Return the positions to which the rotation moves points at given positions [m], shape (n, 3) each."""
        return self.after + _product(points - self.before, self.matrix)

    def along(self, vectors: np.ndarray) -> np.ndarray:
        """Return vectors, such as normals, after the rotation, without the translation, shape (n, 3)."""
        return _product(vectors, self.matrix)

    def back(self, points: np.ndarray) -> np.ndarray:
        """Return the positions from which the rotation moves points to given positions [m], shape (n, 3) each."""
        return self.before + _product(points - self.after, self.matrix.T)


def _product(vectors: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Multiply each of n vectors, shape (n, 3), by a matrix, shape (3, 3): shape (n, 3).

    The sum is explicit, as libraries may sum in an order that depends on the number of threads.
    """
    x, y, z = (vectors[:, axis, None] * matrix[:, axis] for axis in range(3))
    return np.asarray(x + y + z)


def as_list(rotate: Rotations) -> tuple[Rotation, ...]:
    """Return the value of a key `rotate` (none, one or several rotations) as a tuple."""
    return () if rotate is None else (rotate,) if isinstance(rotate, Rotation) else rotate


def turn_about(rotate: Rotations, centre: np.ndarray) -> Turn:
    """Return the composition of the rotations in the key `rotate` of a shape with this centre [m], shape (3,)."""
    matrix, after = np.eye(3), centre
    for rotation in as_list(rotate):
        fixed = after if rotation.centre is None else np.array(rotation.centre)
        after = fixed + _product((after - fixed)[None], rotation.matrix())[0]
        matrix = rotation.matrix() @ matrix
    return Turn(matrix, centre, after)


def rotate_parameter(what: str) -> Any:
    """Return the declaration of the key `rotate` for a table of a case. what: noun for the rotated object in the description of
    the key."""
    return parameter("", f"rotation of {what}, or a list of rotations in order of application", None)


def plane_problems(rotate: Rotations, path: Path, active: ActiveAxes) -> Iterator[Finding]:
    """Yield findings about rotations that rotate a region out of the plane or line of a grid with thin axes (one cell
    thick). path: path of the table with the key `rotate`; active: axes that are not thin."""
    thin = [name for name, counts in zip(AXES, active, strict=True) if not counts]
    for number, rotation in enumerate(as_list(rotate)):
        along = [name for name, component in zip(AXES, rotation.axis, strict=True) if component]
        if thin and along != thin:
            place = (*path, "rotate", "axis") if isinstance(rotate, Rotation) else (*path, "rotate", number, "axis")
            text = f"the grid is one cell thick along {' and '.join(thin)}, where regions have no extent: "
            if len(thin) > 1:
                yield Finding(place, f"{text}no region can be rotated", "remove `rotate`, or enlarge the grid along these axes")
                continue
            direction = [int(name == thin[0]) for name in AXES]
            text = f"{text}they can only be rotated about {thin[0]}, not about {list(rotation.axis)}"
            yield Finding(place, text, f"set `axis` to {direction}, or enlarge the grid along {thin[0]}")
