"""Boxes, balls and cylinders with their exact measures and bounds."""

from typing import Literal

import numpy as np

from pellucid.geometry.shapes.contract import AXES, ActiveAxes, Geometry
from pellucid.geometry.shapes.sharp_edges import SharpEdges, edges_of_box, edges_of_rectangle, edges_of_rims, no_edges
from pellucid.model import Vector, parameter


class Box(Geometry):
    """An axis-parallel box."""

    lower: Vector = parameter("m", "lower corner")
    upper: Vector = parameter("m", "upper corner")

    @property
    def is_convex(self) -> bool:
        return True

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return np.array(self.lower), np.array(self.upper)

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        keep = np.array(active)
        lower, upper = self.bounds()
        return np.all(((points >= lower) & (points <= upper))[:, keep], axis=1)

    def measure(self, active: ActiveAxes) -> float:
        lower, upper = self.bounds()
        return float(np.prod((upper - lower)[np.array(active)]))

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        if sum(active) < 2:
            return no_edges()
        return edges_of_box(*self.bounds()) if all(active) else edges_of_rectangle(*self.bounds(), active.index(False))


class Centred(Geometry):
    """A shape whose centre is given in the case."""

    centre_: Vector = parameter("m", "centre", alias="centre")

    def centre(self) -> np.ndarray:
        return np.array(self.centre_)


class Sphere(Centred):
    """A ball; on a grid with one thin axis a disc, with two thin axes a line segment."""

    radius: float = parameter("m", "radius", gt=0)

    @property
    def is_convex(self) -> bool:
        return True

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return self.centre() - self.radius, self.centre() + self.radius

    def reach(self, direction: np.ndarray) -> float:
        return float(np.array(self.centre_) @ direction + self.radius * np.linalg.norm(direction))

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        offset = (points - np.array(self.centre_))[:, np.array(active)]
        return np.einsum("ij,ij->i", offset, offset) <= self.radius**2

    def measure(self, active: ActiveAxes) -> float:
        return [1.0, 2.0, np.pi * self.radius, 4.0 / 3.0 * np.pi * self.radius**2][sum(active)] * self.radius


class Cylinder(Centred):
    """A circular cylinder along an axis; `centre` is the middle of its axis. On a grid that is thin along this axis, a disc."""

    centre_: Vector = parameter("m", "middle of the axis", alias="centre")
    radius: float = parameter("m", "radius", gt=0)
    axis: Literal["x", "y", "z"] = parameter("", "direction of the axis", "z")
    height: float = parameter("m", "length along the axis; ignored if that axis is thin", 0.0, ge=0)

    @property
    def is_convex(self) -> bool:
        return True

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        half = np.full(3, self.radius)
        half[AXES.index(self.axis)] = 0.5 * self.height
        return np.array(self.centre_) - half, np.array(self.centre_) + half

    def reach(self, direction: np.ndarray) -> float:
        along = AXES.index(self.axis)
        across = self.radius * np.linalg.norm(np.delete(direction, along))
        return float(np.array(self.centre_) @ direction + across + 0.5 * self.height * abs(direction[along]))

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        along = AXES.index(self.axis)
        offset = points - np.array(self.centre_)
        across = [a for a in range(3) if a != along and active[a]]
        inside = np.einsum("ij,ij->i", offset[:, across], offset[:, across]) <= self.radius**2
        if active[along]:
            inside &= np.abs(offset[:, along]) <= 0.5 * self.height
        return np.asarray(inside)

    def measure(self, active: ActiveAxes) -> float:
        along = AXES.index(self.axis)
        across = sum(active[a] for a in range(3) if a != along)
        section = (1.0, 2.0 * self.radius, np.pi * self.radius**2)[across]
        return float(section * (self.height if active[along] else 1.0))

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        along, thin = AXES.index(self.axis), [axis for axis in range(3) if not active[axis]]
        if len(thin) > 1 or thin == [along]:
            return no_edges()
        if thin:
            return edges_of_rectangle(*self.bounds(), thin[0])
        half = 0.5 * self.height * np.eye(3)[along]
        ends = [(self.centre() + sign * half, self.radius, sign) for sign in (-1.0, 1.0)]
        return edges_of_rims(ends, along, spacing)
