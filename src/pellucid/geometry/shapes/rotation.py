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
    """A turn about an axis through a point, counterclockwise for who looks against the axis."""

    axis: Vector = parameter("", "direction of the axis", (0.0, 0.0, 1.0))
    angle: float = parameter("", 'angle in degrees, or a text with a unit such as "0.3 rad"', ge=-360, le=360)
    centre: Vector | None = parameter("m", "a point on the axis; without it the centre of what is turned", None)

    _in_degrees = field_validator("angle", mode="before")(in_degrees)

    @check
    def _axis_has_a_direction(self) -> None:
        if not any(self.axis):
            raise Refusal("`axis` has no length", "give a direction, such as [0, 0, 1]")

    def matrix(self) -> np.ndarray:
        """The matrix of the rotation, shape (3, 3), by Rodrigues' formula; exact for quarter turns about x, y and z."""
        turns, rest = divmod(self.angle, 90.0)
        c, s = QUARTERS[int(turns) % 4] if rest == 0.0 else (cos(radians(self.angle)), sin(radians(self.angle)))
        x, y, z = u = np.array(self.axis) / np.linalg.norm(self.axis)
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.asarray(c * np.eye(3) + (1.0 - c) * np.outer(u, u) + s * across)


Rotations = Rotation | Annotated[tuple[Rotation, ...], Field(min_length=1)] | None
"""How a case says `rotate`: one rotation, or a list of them, of which the first is done first."""


class Turn(NamedTuple):
    """Rotations in one: a point `before` comes to `after` [m], shape (3,) each; what lies about it is turned by `matrix`."""

    matrix: np.ndarray
    before: np.ndarray
    after: np.ndarray

    def forth(self, points: np.ndarray) -> np.ndarray:
        """Return the places of points [m], shape (n, 3), after the rotation."""
        return self.after + _product(points - self.before, self.matrix)

    def along(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors of the shape, shape (n, 3), turned."""
        return _product(vectors, self.matrix)

    def back(self, points: np.ndarray) -> np.ndarray:
        """Return the places of points [m], shape (n, 3), before the rotation."""
        return self.before + _product(points - self.after, self.matrix.T)


def _product(vectors: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Each vector multiplied by a matrix; summed here, as libraries may sum in another order on another number of threads."""
    x, y, z = (vectors[:, axis, None] * matrix[:, axis] for axis in range(3))
    return np.asarray(x + y + z)


def as_list(rotate: Rotations) -> tuple[Rotation, ...]:
    """The rotations that a case says."""
    return () if rotate is None else (rotate,) if isinstance(rotate, Rotation) else rotate


def turn_about(rotate: Rotations, centre: np.ndarray) -> Turn:
    """The rotations of a shape whose centre [m], shape (3,), is given."""
    matrix, after = np.eye(3), centre
    for rotation in as_list(rotate):
        fixed = after if rotation.centre is None else np.array(rotation.centre)
        after = fixed + _product((after - fixed)[None], rotation.matrix())[0]
        matrix = rotation.matrix() @ matrix
    return Turn(matrix, centre, after)


def rotate_parameter(what: str) -> Any:
    """Declare the key `rotate` of a table."""
    return parameter("", f"how {what} is turned: a rotation, or a list of rotations in their order", None)


def plane_problems(rotate: Rotations, path: Path, active: ActiveAxes) -> Iterator[Finding]:
    """Rotations, said at a path, that turn a region out of the plane or the line of a grid with thin axes."""
    thin = [name for name, counts in zip(AXES, active, strict=True) if not counts]
    for number, rotation in enumerate(as_list(rotate)):
        along = [name for name, component in zip(AXES, rotation.axis, strict=True) if component]
        if thin and along != thin:
            place = (*path, "rotate", "axis") if isinstance(rotate, Rotation) else (*path, "rotate", number, "axis")
            text = f"the grid is one cell thick along {' and '.join(thin)}, where regions have no extent: "
            if len(thin) > 1:
                yield Finding(place, f"{text}nothing can turn", "leave `rotate` out, or enlarge the grid")
                continue
            direction = [int(name == thin[0]) for name in AXES]
            text = f"{text}they turn about {thin[0]} alone, not about {list(rotation.axis)}"
            yield Finding(place, text, f"let the axis be {direction}, or enlarge the grid")
