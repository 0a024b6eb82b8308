"""Shapes with exact measures and bounds: boxes, balls, cylinders, hollow balls and cylinders, cushions."""

from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, PositiveFloat

from pellucid.geometry.shapes.contract import (
    AXES,
    ActiveAxes,
    Geometry,
    SharpEdges,
    edges_of_box,
    edges_of_rectangle,
    edges_of_rims,
    no_edges,
)
from pellucid.model import AtLeastOne, AtLeastThree, Model, Vector, check, parameter


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


class Hollow(Centred):
    """Base of hollow shapes: the region between an inner and an outer radius."""

    centre_: Vector = parameter("m", "centre; for a pipe, the middle of its axis", alias="centre")
    outer_radius: float = parameter("m", "outer radius", gt=0)
    inner_radius: float = parameter("m", "inner radius, smaller than the outer radius", gt=0)

    @check
    def _has_a_wall(self) -> None:
        if self.inner_radius >= self.outer_radius:
            text = f"inner_radius = {self.inner_radius:g} m must be smaller than outer_radius = {self.outer_radius:g} m"
            raise ValueError(f"{text}; decrease `inner_radius`")

    def _in_the_wall(self, offset: np.ndarray) -> np.ndarray:
        distance = np.einsum("ij,ij->i", offset, offset)
        return (distance >= self.inner_radius**2) & (distance <= self.outer_radius**2)


class Shell(Hollow):
    """A hollow sphere; on a grid with one thin axis a ring, with two thin axes two line segments."""

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return self.centre() - self.outer_radius, self.centre() + self.outer_radius

    def reach(self, direction: np.ndarray) -> float:
        return Sphere(centre_=self.centre_, radius=self.outer_radius).reach(direction)

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        return self._in_the_wall((points - self.centre())[:, np.array(active)])

    def measure(self, active: ActiveAxes) -> float:
        n = sum(active)
        unit = (0.0, 2.0, np.pi, 4.0 / 3.0 * np.pi)[n]
        return float(unit * (self.outer_radius**n - self.inner_radius**n))


class Pipe(Hollow):
    """A hollow circular cylinder; a ring if its axis is thin. With `points` it is filled by its own lattice, in rings."""

    axis: Literal["x", "y", "z"] = parameter("", "direction of the axis", "z")
    height: float = parameter("m", "length along the axis; ignored if that axis is thin", 0.0, ge=0)
    points: tuple[AtLeastOne, AtLeastThree, AtLeastOne] | None = parameter(
        "",
        "number of points across the wall, around the circumference and along the axis. "
        "Default: the points of the grid's lattice that lie inside",
        None,
    )

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        half = np.full(3, self.outer_radius)
        half[AXES.index(self.axis)] = 0.5 * self.height
        return self.centre() - half, self.centre() + half

    def reach(self, direction: np.ndarray) -> float:
        full = Cylinder(centre_=self.centre_, radius=self.outer_radius, axis=self.axis, height=self.height)
        return full.reach(direction)

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        along = AXES.index(self.axis)
        offset = points - self.centre()
        inside = self._in_the_wall(offset[:, [a for a in range(3) if a != along and active[a]]])
        if active[along]:
            inside &= np.abs(offset[:, along]) <= 0.5 * self.height
        return inside

    def measure(self, active: ActiveAxes) -> float:
        along = AXES.index(self.axis)
        across = sum(active[a] for a in range(3) if a != along)
        section = (0.0, 2.0, np.pi)[across] * (self.outer_radius**across - self.inner_radius**across)
        return float(section * (self.height if active[along] else 1.0))

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        along = AXES.index(self.axis)
        if not all(active):  # the points of the surface already represent the walls of a cross-section
            return no_edges()
        half = 0.5 * self.height * np.eye(3)[along]
        radii = (self.outer_radius, -self.inner_radius)
        ends = [(self.centre() + sign * half, radius, sign) for sign in (-1.0, 1.0) for radius in radii]
        return edges_of_rims(ends, along, spacing)

    def n_own_points(self) -> int | None:
        return None if self.points is None else int(np.prod(self.points))

    def own_points(self) -> tuple[np.ndarray, np.ndarray]:
        """Return points in the middle of equal parts of the wall thickness, the circumference and the height [m], shape (n,
        3), and their volumes [m³], shape (n,).

        The volume of each point is exactly the volume of its ring sector, θ (r₁² - r₀²) Δz / 2.
        """
        if self.points is None:
            raise ValueError("a pipe without `points` has no lattice of its own")
        across, around, along = self.points
        edges = np.linspace(self.inner_radius, self.outer_radius, across + 1)
        r = 0.5 * (edges[:-1] + edges[1:])
        angle = 2.0 * np.pi * (np.arange(around) + 0.5) / around
        z = self.height * ((np.arange(along) + 0.5) / along - 0.5)
        rr, turn, zz = (a.ravel() for a in np.meshgrid(r, angle, z, indexing="ij"))
        axis = AXES.index(self.axis)
        position = np.empty((len(rr), 3))
        position[:, axis] = zz
        position[:, (axis + 1) % 3] = rr * np.cos(turn)
        position[:, (axis + 2) % 3] = rr * np.sin(turn)
        sector = np.pi / around * (edges[1:] ** 2 - edges[:-1] ** 2) * self.height / along
        return self.centre() + position, np.repeat(sector, around * along)


STEPS = 4001  # samples along a side in the search for the reach: accurate to 1e-7 of the height


def _each_once(axes: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(axes)) < len(axes):
        raise ValueError(f"{', '.join(axes)} names an axis twice: name each once")
    return axes


Halves = Annotated[tuple[Literal["x", "y", "z"], ...], AfterValidator(_each_once)]
"""Axes along which only the upper half of a cushion is kept, as in a model with planes of symmetry."""


class CushionDimensions(Model):
    """Position and size of a cushion, shared by its inside and its surface."""

    centre_: Vector = parameter("m", "centre of the cushion", alias="centre")
    sides: tuple[PositiveFloat, PositiveFloat] = parameter("m", "lengths along x and y")
    height: float = parameter("m", "distance of the two sheets at the centre of the cushion", gt=0)
    halved: Halves = parameter(
        "", "axes along which only the upper half is kept, for a model with planes of symmetry through the centre", ()
    )


class Cushion(CushionDimensions, Geometry):
    """The inside of two domed rectangular sheets that are joined at their four edges.

    At distances ξ and η from the middle, divided by half the sides, the sheets lie at ± height/2 (1 - ξ²)(1 - η²) from the
    plane of their edges. The shape is a rectangle if z is thin; if x or y is, it is the section through the middle.
    """

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        half, kept = 0.5 * np.array([*self.sides, self.height]), np.array([axis in self.halved for axis in AXES])
        return np.array(self.centre_) - np.where(kept, 0.0, half), np.array(self.centre_) + half

    def reach(self, direction: np.ndarray) -> float:
        """Return the maximum of x·d over the positions x of the cushion [m] for a direction d. The coordinate η is sampled
        finely; over ξ, the maximum of a ξ + k (1 - ξ²) is exact (at a/2k or at an end)."""
        first, kept = np.array([-1.0, -1.0, -1.0]), [axis in self.halved for axis in AXES]
        first[kept] = 0.0
        a, b, c = direction * 0.5 * np.array([*self.sides, self.height])
        eta = np.linspace(first[1], 1.0, STEPS)
        up = max(c, c * first[2])
        k = up * (1.0 - eta**2)
        xi = np.clip(np.divide(0.5 * a, k, out=np.full(STEPS, np.copysign(np.inf, a)), where=k > 0.0), first[0], 1.0)
        return float(np.array(self.centre_) @ direction + (a * xi + b * eta + up * dome(xi, eta)).max())

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        offset = np.where(active, points - np.array(self.centre_), 0.0)
        xi, eta, zeta = (offset / (0.5 * np.array([*self.sides, self.height]))).T
        inside = (np.abs(xi) <= 1.0) & (np.abs(eta) <= 1.0) & (np.abs(zeta) <= dome(xi, eta))
        for axis in self.halved:
            inside &= offset[:, AXES.index(axis)] >= 0.0
        return np.asarray(inside)

    def measure(self, active: ActiveAxes) -> float:
        x, y, z = active
        across = self.sides[0] ** x * self.sides[1] ** y
        up = self.height * (2.0 / 3.0) ** (x + y) if z else 1.0  # the mean of 1 - ξ² is 2/3
        return across * up * 0.5 ** sum(active[AXES.index(axis)] for axis in self.halved)


def dome(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
    """Return the height of a domed sheet divided by the height in the middle, (1 - ξ²)(1 - η²); xi, eta: distances ξ and η
    from the middle divided by half the sides."""
    return np.asarray((1.0 - xi**2) * (1.0 - eta**2))
