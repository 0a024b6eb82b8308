"""Rotations of shapes, surfaces and meshes about axes; rotated and translated shapes."""

from collections.abc import Iterator
from math import cos, radians, sin
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field, field_validator

from pellucid.findings import Finding, Path, Refusal
from pellucid.geometry.shapes.contract import AXES, ActiveAxes, Geometry, SharpEdges
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


class Rotated(Geometry):
    """A shape rotated about axes. On a grid with a thin axis it can only be rotated about that axis."""

    shape: Geometry = parameter("", "shape that is rotated")
    rotate: Rotations = parameter("", "the rotations, in order of application")

    @property
    def turn(self) -> Turn:
        """The composed rotation from the original to the rotated position."""
        return turn_about(self.rotate, self.shape.centre())

    @property
    def is_convex(self) -> bool:
        return self.shape.is_convex

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a box around the rotated shape, computed from the extents of the original shape (`reach`) along the axes
        rotated back."""
        turn = self.turn
        start = turn.after - turn.matrix @ turn.before
        lower, upper = [-self.shape.reach(-row) for row in turn.matrix], [self.shape.reach(row) for row in turn.matrix]
        return start + lower, start + upper

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        return self.shape.contains(self.turn.back(points), active)

    def measure(self, active: ActiveAxes) -> float:
        return self.shape.measure(active)

    def centre(self) -> np.ndarray:
        return self.turn.after

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        turn, own = self.turn, self.shape.sharp_edges(active, spacing)
        return own._replace(
            corner=turn.forth(own.corner), corner_normal=turn.along(own.corner_normal), edge_normal=turn.along(own.edge_normal)
        )

    def in_own_frame(self, points: np.ndarray) -> tuple[Geometry, np.ndarray]:
        return self.shape.in_own_frame(self.turn.back(points))

    def n_own_points(self) -> int | None:
        return self.shape.n_own_points()

    def own_points(self) -> tuple[np.ndarray, np.ndarray]:
        points, volumes = self.shape.own_points()
        return self.turn.forth(points), volumes


class Remainder(Geometry):
    """A shape without the parts inside other shapes."""

    shape: Geometry = parameter("", "shape from which others are removed")
    left_out: tuple[Geometry, ...] = parameter("", "shapes that are removed")

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return self.shape.bounds()

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        inside = self.shape.contains(points, active)
        for other in self.left_out:
            inside &= ~other.contains(points, active)
        return inside

    def measure(self, active: ActiveAxes) -> float:
        return self.shape.measure(active)


class Shifted(Geometry):
    """A shape translated by a vector."""

    shape: Geometry = parameter("", "shape that is translated")
    by: Vector = parameter("m", "translation")

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        lower, upper = self.shape.bounds()
        return lower + self.by, upper + self.by

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        return self.shape.contains(points - np.array(self.by), active)

    def measure(self, active: ActiveAxes) -> float:
        return self.shape.measure(active)

    def centre(self) -> np.ndarray:
        return self.shape.centre() + np.array(self.by)
