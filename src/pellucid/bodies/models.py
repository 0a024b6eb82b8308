"""Bodies as the user describes them; a new kind of body is one class here in the union and one file beside this."""

from collections.abc import Iterator, Sequence
from math import prod
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, PrivateAttr, Tag, field_validator

from pellucid.bodies.material_points.seeding import points_along_axes
from pellucid.bodies.membrane_elements.model import FIELD_MEANING, MembraneElementsCase, longest_edge
from pellucid.geometry.box_surface import Face
from pellucid.geometry.shapes import Box, Geometry, Inside, Shape
from pellucid.geometry.surface_checks import faults
from pellucid.geometry.surfaces import Surface
from pellucid.grid.model import GridCase
from pellucid.materials import Material, MembraneMaterial
from pellucid.materials.damage import DamageRecord
from pellucid.model import Model, Vector, kind_of, parameter

ZERO = (0.0, 0.0, 0.0)
CLOSE_IT = "use a surface that encloses a volume; a file that does says `closed = true`"
NEEDS_SPACE = "needs a grid that is more than one cell thick along every axis"
FEWEST_PER_CELL = 2.0  # membrane points for each cell that the surface crosses
ALIKE = 1e-6  # of a cell; points that differ by less are one
COMFORTABLE = 0.6  # length of an edge in cells that gives enough points
COMMON_FIELDS = ("position", "velocity", "density", "pressure", "stress", "mass", "kinetic_energy", "stored_energy")


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
    field: str = parameter("", FIELD_MEANING, "common", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    shape: Shape = parameter("", "where the body is at the start")
    outside: tuple[str, ...] = parameter(
        "", "bodies whose place is left out of the shape: the shape of material points, the inside of a closed membrane", ()
    )
    cut_at: tuple[Face, ...] = parameter(
        "", "faces of the grid at which the shape ends: planes of symmetry, beyond which lies its mirror image", ()
    )
    points_per_cell: int | tuple[int, int, int] | None = parameter(
        "", "points in a cell: along each axis, or their number; without it two along each axis that is not thin", None
    )
    material: Material = parameter("", "what the body is made of")
    velocity: Vector = parameter("m/s", "initial velocity", ZERO)
    angular_velocity: Vector = parameter("rad/s", "initial angular velocity about the shape's centre", ZERO)
    velocity_wave: SineWave | None = parameter("", "initial sinusoidal velocity, added to the others", None)
    rigid: bool = parameter("", "whether a solid moves as a rigid body; its elasticity then does not count", False)

    place: ClassVar[str] = "shape"  # the key that says where the body is
    _left_out: tuple[Geometry, ...] = PrivateAttr(())

    def knowing(self, bodies: "Sequence[Body]") -> "MaterialPointsCase":
        """The same body, aware of the places of those that it lies outside of. Raises KeyError for an unknown name."""
        if not self.outside:
            return self
        places = {body.name: body for body in bodies}
        aware = self.model_copy()
        aware._left_out = tuple(places[name].occupied() for name in self.outside)
        return aware

    @property
    def moves_rigidly(self) -> bool:
        """Whether it moves as a rigid body."""
        return self.rigid

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of plane pressure and shear waves at the start [m/s]."""
        return self.material.wave_speeds()

    def occupied(self) -> Geometry:
        """The place that bodies outside it leave out."""
        return self.shape.geometry()

    @property
    def left_out(self) -> tuple[Geometry, ...]:
        """The places that are left out of the shape; known to what `knowing` returns."""
        if len(self._left_out) < len(self.outside):
            raise RuntimeError(f"body {self.name} lies outside others and does not know them; use body.knowing(bodies)")
        return self._left_out

    @property
    def probed(self) -> tuple[str, ...]:
        """The fields that probes can read."""
        return (*COMMON_FIELDS, *self.material.probed_fields)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner [m]."""
        return self.shape.geometry().bounds()

    def grid_problems(self, grid: GridCase) -> Iterator[tuple[str, str, str]]:
        """What does not fit the grid: key, text, remedy."""
        try:
            points_along_axes(self.points_per_cell, grid.thin())
        except ValueError as error:
            yield "points_per_cell", str(error), ""
        geometry = self.shape.geometry()
        if any(grid.thin()) and (geometry.n_own_points() is not None or isinstance(geometry, Inside)):
            what = "a lattice of its own" if geometry.n_own_points() is not None else "the inside of a surface"
            yield "shape", f"{what} {NEEDS_SPACE}", "enlarge the grid"
        if isinstance(geometry, Inside):
            if not geometry.surface.closed:
                yield "shape", "the surface is open: it has no inside", CLOSE_IT
            for text, remedy in faults(*geometry.surface.triangulate(), geometry.surface.closed):
                yield "shape", text, remedy
        if geometry.n_own_points() is not None and self.outside:
            text = "a shape with a lattice of its own is filled wholly: no other body's place can be left out of it"
            yield "outside", text, "leave out `points` of the shape, or `outside`"
        if self.cut_at and isinstance(geometry, Box):
            yield "cut_at", "a box fills its own lattice, which no face cuts", "let the box end at the face"
        elif self.cut_at and geometry.n_own_points() is not None:
            yield "cut_at", "a shape with a lattice of its own is filled wholly", "leave out `points` of the shape, or `cut_at`"

    def size(self, grid: GridCase) -> float:
        """Number of points, from the measure of the shape: good to a layer of points.

        What is left out is taken off where the body knows it, which it does after `knowing`.
        """
        x, y, z = (not thin for thin in grid.thin())
        geometry = self.shape.geometry()
        own = geometry.n_own_points()
        if own is not None and not self.outside:
            return own
        cells = geometry.measure((x, y, z)) - sum(other.measure((x, y, z)) for other in self._left_out)
        cells = max(cells, 0.0) / grid.cell ** (x + y + z)
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
    field: str = parameter("", FIELD_MEANING, "common", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
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

    def knowing(self, bodies: "Sequence[Body]") -> "MembranePointsCase":
        """Itself: a membrane leaves nothing out."""
        return self

    @property
    def moves_rigidly(self) -> bool:
        """No: a membrane has no rigidity."""
        return False

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of pressure and shear waves in its plane at the start [m/s]."""
        return self.material.wave_speeds()

    def occupied(self) -> Geometry:
        """What it encloses: the place that bodies outside it leave out."""
        return Inside(surface=self.surface)

    def size(self, grid: GridCase) -> float:
        """Number of points."""
        return len(self.surface.triangulate().vertices)

    def grid_problems(self, grid: GridCase) -> Iterator[tuple[str, str, str]]:
        """What does not fit the grid: key, text, remedy."""
        vertices, triangles = self.surface.triangulate()
        wrong = [("surface", text, remedy) for text, remedy in faults(vertices, triangles, self.surface.closed)]
        yield from wrong
        if wrong:
            return
        yield from self._radius_problems(grid)
        across = np.where(grid.thin(), 0.0, vertices)  # along a thin axis nothing varies, so that distances do not count
        samples = np.concatenate([across, across[triangles].mean(axis=1)])
        cells = np.floor((samples - samples.min(axis=0)) / grid.cell).astype(int)
        crossed = len(np.unique(np.ravel_multi_index(tuple(cells.T), tuple(cells.max(axis=0) + 1))))
        per_cell = len(np.unique(np.round(across / (ALIKE * grid.cell)), axis=0)) / crossed
        longest = longest_edge(across[triangles])
        if longest > grid.cell:
            finer = int(np.ceil(longest / (COMFORTABLE * grid.cell)))
            yield (
                "surface",
                f"has a triangle with an edge of {longest:.3g} m, longer than a cell of {grid.cell:g} m: the grid tears the "
                f"membrane between its points",
                f"make its triangles {finer} times as fine along each edge, or use a larger grid.cell",
            )
            return
        if per_cell < FEWEST_PER_CELL:
            more = FEWEST_PER_CELL / per_cell
            yield (
                "surface",
                f"has {per_cell:.2g} points for each grid cell that it crosses; with fewer than {FEWEST_PER_CELL:g} the grid "
                f"tears the membrane",
                f"give it about {more:.2g} times as many points, or use a larger grid.cell",
            )

    def _radius_problems(self, grid: GridCase) -> Iterator[tuple[str, str, str]]:
        radius = self.material.damage.radius if self.material.damage else None
        if radius is not None and radius < grid.cell:
            text = f"damage.radius = {radius:g} m is less than grid.cell = {grid.cell:g} m: the mean tells no more than a point"
            yield "material", text, "make it three cells or more, use a finer grid, or leave it out for local damage"


Membrane = MembranePointsCase | MembraneElementsCase


def kind_of_body(value: Any) -> Any:
    """The `kind` of a body; material points where none is given."""
    return kind_of(value) or "material-points"


Body = Annotated[
    Annotated[MaterialPointsCase, Tag("material-points")]
    | Annotated[MembranePointsCase, Tag("membrane-points")]
    | Annotated[MembraneElementsCase, Tag("membrane-elements")],
    Discriminator(kind_of_body),
]
