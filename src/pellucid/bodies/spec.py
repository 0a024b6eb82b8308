"""Bodies as the user describes them; a new kind of body is one class here in the union and one file beside this."""

from collections.abc import Iterator
from math import prod
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, Tag, field_validator

from pellucid.bodies.seeding import points_along_axes
from pellucid.geometry.shapes import Shape
from pellucid.geometry.surfaces import Surface
from pellucid.grid.spec import GridCase
from pellucid.materials import Material, MembraneMaterial
from pellucid.materials.damage import DamageRecord
from pellucid.model import Model, Vector, kind_of, parameter

ZERO = (0.0, 0.0, 0.0)
FEWEST_PER_CELL = 2.0  # membrane points for each cell that the surface crosses
COMMON_FIELDS = ("position", "velocity", "density", "pressure", "stress", "mass")


class SineWave(Model):
    """An initial velocity a sin(k·x + φ)."""

    amplitude: Vector = parameter("m/s", "amplitude a")
    wave_vector: Vector = parameter("rad/m", "wave vector k")
    phase: float = parameter("rad", "phase φ", 0.0)

    def at(self, position: np.ndarray) -> np.ndarray:
        """Velocity [m/s], shape (n, 3), at positions [m], shape (n, 3)."""
        return np.sin(position @ np.array(self.wave_vector) + self.phase)[:, None] * np.array(self.amplitude)


class MaterialPointsCase(Model):
    """A fluid or solid body of material points."""

    kind: Literal["material-points"] = "material-points"
    name: str = parameter("", "name of the body, used for its files and in probes", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    shape: Shape = parameter("", "where the body is at the start")
    points_per_cell: int | tuple[int, int, int] | None = parameter(
        "", "points in a cell: along each axis, or their number; without it two along each axis that is not thin", None
    )
    material: Material = parameter("", "what the body is made of")
    velocity: Vector = parameter("m/s", "initial velocity", ZERO)
    angular_velocity: Vector = parameter("rad/s", "initial angular velocity about the shape's centre", ZERO)
    velocity_wave: SineWave | None = parameter("", "initial sinusoidal velocity, added to the others", None)

    place: ClassVar[str] = "shape"  # the key that says where the body is

    @property
    def probed(self) -> tuple[str, ...]:
        """The fields that probes can read."""
        own = {"fluid": ("internal_energy",), "linear-elastic": ("strain_energy",)}.get(self.material.kind, ())
        return (*COMMON_FIELDS, *own)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner [m]."""
        return self.shape.geometry().bounds()

    def misfits(self, grid: GridCase) -> Iterator[tuple[str, str, str]]:
        """What does not fit the grid: key, text, remedy."""
        try:
            points_along_axes(self.points_per_cell, grid.thin())
        except ValueError as error:
            yield "points_per_cell", str(error), ""

    def size(self, grid: GridCase) -> float:
        """Number of points, from the measure of the shape: good to a layer of points."""
        x, y, z = (not thin for thin in grid.thin())
        cells = self.shape.geometry().measure((x, y, z)) / grid.cell ** (x + y + z)
        return cells * prod(points_along_axes(self.points_per_cell, grid.thin()))

    @field_validator("points_per_cell")
    @classmethod
    def _positive(cls, value: int | tuple[int, int, int] | None) -> int | tuple[int, int, int] | None:
        if value is not None and min(value if isinstance(value, tuple) else (value,)) < 1:
            raise ValueError("points_per_cell must be at least 1 along every axis")
        return value


class MembranePointsCase(Model):
    """A membrane whose material points are the vertices of a triangulated surface."""

    kind: Literal["membrane-points"] = "membrane-points"
    name: str = parameter("", "name of the body, used for its files and in probes", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    surface: Surface = parameter("", "where the membrane is at the start")
    thickness: float = parameter("m", "initial thickness", gt=0)
    material: MembraneMaterial = parameter("", "what the membrane is made of")
    velocity: Vector = parameter("m/s", "initial velocity", ZERO)

    place: ClassVar[str] = "surface"

    @property
    def probed(self) -> tuple[str, ...]:
        """The fields that probes can read."""
        return (*COMMON_FIELDS, "strain_energy", *(DamageRecord._fields if self.material.damage else ()))

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner [m]."""
        vertices = self.surface.triangulate().vertices
        return vertices.min(axis=0), vertices.max(axis=0)

    def size(self, grid: GridCase) -> float:
        """Number of points."""
        return len(self.surface.triangulate().vertices)

    def misfits(self, grid: GridCase) -> Iterator[tuple[str, str, str]]:
        """What does not fit the grid: key, text, remedy."""
        vertices, triangles = self.surface.triangulate()
        samples = np.concatenate([vertices, vertices[triangles].mean(axis=1)])
        crossed = len(np.unique(np.floor(samples / grid.cell), axis=0))
        per_cell = len(vertices) / crossed
        if per_cell < FEWEST_PER_CELL:
            more = FEWEST_PER_CELL / per_cell
            yield (
                "surface",
                f"has {per_cell:.2g} points for each grid cell that it crosses; with fewer than {FEWEST_PER_CELL:g} the grid "
                f"tears the membrane",
                f"give it about {more:.2g} times as many points, or use a larger grid.cell",
            )


def kind_of_body(value: Any) -> Any:
    """The `kind` of a body; material points where none is given."""
    return kind_of(value) or "material-points"


Body = Annotated[
    Annotated[MaterialPointsCase, Tag("material-points")] | Annotated[MembranePointsCase, Tag("membrane-points")],
    Discriminator(kind_of_body),
]
