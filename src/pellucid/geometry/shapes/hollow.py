"""Hollow spheres and hollow cylinders."""

from typing import Literal

import numpy as np

from pellucid.geometry.shapes.contract import AXES, ActiveAxes
from pellucid.geometry.shapes.sharp_edges import SharpEdges, edges_of_rims, no_edges
from pellucid.geometry.shapes.solids import Centred, Cylinder, Sphere
from pellucid.model import AtLeastOne, AtLeastThree, Vector, check, parameter


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
