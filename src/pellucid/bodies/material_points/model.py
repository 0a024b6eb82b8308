"""Bodies of material points as the user describes them."""

from collections.abc import Iterator, Mapping, Sequence
from math import prod
from typing import TYPE_CHECKING, ClassVar, Literal, Self

import numpy as np
from pydantic import PrivateAttr, field_validator

from pellucid.bodies.initial import (
    INITIAL_MEANING,
    Initial,
    SineWave,
    add_initial_state,
    added_velocities,
    initial_problems,
    initial_velocity,
)
from pellucid.bodies.material_points.checks import cut_problems, grid_problems, outside_problems
from pellucid.bodies.material_points.seeding import points_along_axes
from pellucid.bodies.placing import COMMON_FIELDS, limit_in_cells, place_problems
from pellucid.findings import Finding, Path, Reason
from pellucid.geometry.box_surface import Face
from pellucid.geometry.shapes import Geometry, Shape
from pellucid.grid.model import GridCase
from pellucid.materials import Material
from pellucid.model import Vector, parameter
from pellucid.parts import BodyModel, Parts, StepLimit

if TYPE_CHECKING:
    from pellucid.bodies.contract import Body, Placement

ZERO = (0.0, 0.0, 0.0)


class MaterialPointsCase(BodyModel):
    """A fluid or solid body of material points."""

    place: ClassVar[str] = "shape"

    kind: Literal["material-points"] = "material-points"
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
    initial: tuple[Initial, ...] = parameter("", INITIAL_MEANING, ())
    rigid: bool = parameter("", "whether a solid moves as a rigid body; its elasticity then does not count", False)

    _excluded: tuple[Geometry, ...] = PrivateAttr(())

    def build(self, placement: "Placement") -> "Body":
        """Its points on the grid."""
        from pellucid.bodies.material_points.body import MaterialPoints

        return MaterialPoints(self, *placement.on_grid(), placement.velocity_transfer)

    @property
    def is_rigid(self) -> bool:
        """Whether it moves as a rigid body."""
        return self.rigid

    def contains(self, places: np.ndarray, active: tuple[bool, bool, bool]) -> np.ndarray:
        """Which places lie inside its shape and not in what is left out of it."""
        inside = super().contains(places, active)
        for other in self.left_out:
            inside &= ~other.contains(places, active)
        return inside

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of plane pressure and shear waves in its material at the start [m/s]."""
        return self.material.wave_speeds()

    def with_others(self, bodies: Sequence[BodyModel]) -> Self:
        """The same model with the regions of the bodies that it leaves out. Raises KeyError for an unknown name."""
        if not self.outside:
            return self
        places = {body.name: body for body in bodies}
        aware = self.model_copy()
        aware._excluded = tuple(places[name].occupied() for name in self.outside)
        return aware

    @property
    def left_out(self) -> tuple[Geometry, ...]:
        """The regions that are left out of the shape; the model that `with_others` returns has them."""
        if len(self._excluded) < len(self.outside):
            raise RuntimeError(
                f"body {self.name} leaves out other bodies, which it has not been given; use body.with_others(bodies)"
            )
        return self._excluded

    def excluded_bodies(self) -> tuple[str, ...]:
        """Names of the bodies whose place it leaves out of its own."""
        return self.outside

    def occupied(self) -> Geometry:
        """The region that it occupies, which other bodies may leave out."""
        return self.shape.geometry()

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner [m]."""
        return self.shape.geometry().bounds()

    @property
    def probed(self) -> tuple[str, ...]:
        """The fields that probes can read."""
        return (*COMMON_FIELDS, *self.material.probed_fields)

    def n_points(self, grid: GridCase | None) -> float:
        """Number of points, from the measure of the shape: good to a layer of points.

        What is left out is subtracted after `with_others`.
        """
        if grid is None:
            raise RuntimeError(f"body {self.name} is seeded by the cells of a grid, and there is none")
        x, y, z = (not thin for thin in grid.thin())
        geometry = self.shape.geometry()
        own = geometry.n_own_points()
        if own is not None and not self.outside:
            return own
        cells = geometry.measure((x, y, z)) - sum(other.measure((x, y, z)) for other in self._excluded)
        cells = max(cells, 0.0) / grid.cell ** (x + y + z)
        return cells * prod(points_along_axes(self.points_per_cell, grid.thin()))

    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        """Velocities at the start [m/s], shape (n, 3), at positions [m], shape (n, 3)."""
        velocity = initial_velocity(self.velocity, self.name, (), position)
        velocity += np.cross(self.angular_velocity, position - self.shape.geometry().centre())
        if self.velocity_wave is not None:
            velocity += self.velocity_wave.at(position)
        for added in added_velocities(self.name, self.initial, position):
            velocity += added
        return velocity

    def add_initial_state(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Add the initial fields of the material's state to the arrays of the points, in place."""
        add_initial_state(self.name, self.initial, arrays)

    def why_no_motion(self) -> Reason | None:
        """A rigid body moves by itself."""
        if not self.rigid:
            return None
        text = f"body {self.name} is rigid: its points cannot follow a motion as well"
        return Reason(text, "leave `rigid = true` out: a body that follows a motion as a whole is rigid")

    def step_limit(self, cell: float, is_driven: bool) -> StepLimit | None:
        """Signals cross no more than a cell in a step; a rigid body has no waves."""
        if self.rigid or is_driven or any(self.material.problems()):
            return None
        return limit_in_cells(self.name, self.material.signals(cell), self.velocity, cell)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """What does not fit the grid, other bodies, supports."""
        yield from super().problems(path, parts)
        yield from initial_problems(self.initial, ("velocity", *self.material.state_fields), path)
        grid = parts.grid
        if grid is not None:
            yield from grid_problems(self, path, grid)
            yield from place_problems((*path, self.place), self.bounds(), grid, self.is_surface, self.cut_at)
            yield from cut_problems(self, path, grid, parts)
        yield from outside_problems(self, path, parts)
        if not (self.rigid or parts.is_driven(self.name)):
            yield from (Finding((*path, "material", key), text, remedy) for key, text, remedy in self.material.problems())

    @field_validator("points_per_cell")
    @classmethod
    def _positive(cls, value: int | tuple[int, int, int] | None) -> int | tuple[int, int, int] | None:
        if value is not None and min(value if isinstance(value, tuple) else (value,)) < 1:
            raise ValueError("points_per_cell must be at least 1 along every axis")
        return value
