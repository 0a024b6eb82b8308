"""Settings of a body of material points that define its initial state: region, material, initial fields."""

from collections.abc import Mapping, Sequence
from math import prod
from typing import ClassVar, Self

import numpy as np
from pydantic import PrivateAttr, field_validator

from pellucid.bodies.damped_model import DampedModel
from pellucid.bodies.initial import (
    INITIAL_MEANING,
    Initial,
    SineWave,
    Stress,
    add_initial_state,
    added_velocities,
    initial_velocity,
)
from pellucid.bodies.material_points.edge_points import EdgePoints, edge_points
from pellucid.bodies.material_points.hydrostatic import Hydrostatic
from pellucid.bodies.material_points.seeding import Seeds, Wanted, everywhere, points_along_axes, seed
from pellucid.errors import CaseError, Problem
from pellucid.geometry.region import Shape, images, within
from pellucid.geometry.shapes.boundary_points import boundary_points
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.rotation import Remainder, Shifted
from pellucid.geometry.surfaces.quadrilaterals import Face
from pellucid.grid.model import GridCase
from pellucid.materials import Material
from pellucid.model import Vector, parameter
from pellucid.parts.body_model import BodyModel, Standing
from pellucid.users.users_code import file_of, is_own

ON_THE_SEAM = 1e-6  # relative tolerance of positions on the seam of a periodic grid
ZERO = (0.0, 0.0, 0.0)
SOFT, HARD = 2, 4
"""Minimum number of surface points along the edge of a cell, for bodies that deform (SOFT) and for those that do not
(HARD). A body that rolls on its surface points rolls like a polygon, so a hard body needs more."""


class SeededBody(DampedModel):
    """Settings of a body whose points fill a shape, minus the regions of other bodies, and of its initial state."""

    place: ClassVar[str] = "shape"
    start_only: ClassVar[tuple[str, ...]] = (
        *BodyModel.start_only,
        *("hydrostatic", "initial_stress", "angular_velocity", "velocity_wave", "material.pressure"),
    )
    strained_from_place: ClassVar[bool] = False

    shape: Shape = parameter("", "initial shape of the body")
    outside: tuple[str, ...] = parameter(
        "",
        "bodies whose regions are excluded from the shape: the shape of material points, or the inside of a closed membrane",
        (),
    )
    cut_at: tuple[Face, ...] = parameter(
        "",
        "faces of the grid that cut the shape: planes of symmetry, or for a fluid faces opened by an [[inflow]] or [[outflow]]",
        (),
    )
    points_per_cell: int | tuple[int, int, int] | None = parameter(
        "", "points per cell: along each axis, or in total; default: two along each axis that is not thin", None
    )
    material: Material = parameter("", "material of the body")
    hydrostatic: Hydrostatic | None = parameter(
        "",
        "a fluid initially in hydrostatic equilibrium; default: a uniform state",
        None,
    )
    initial_stress: Stress | None = parameter(
        "Pa",
        "initial stress of a solid, components xx, yy, zz, yz, xz, xy; a hyperelastic solid is stretched to have this stress, "
        "and its `density` is the density without stress",
        None,
    )
    cell_pressure: bool = parameter(
        "",
        "true: integrate the mean pressure over full cells instead of summing over points",
        False,
    )
    velocity: Vector = parameter("m/s", "initial velocity", ZERO)
    angular_velocity: Vector = parameter("rad/s", "initial angular velocity about the shape's centre", ZERO)
    velocity_wave: SineWave | None = parameter("", "initial sinusoidal velocity, added to the other initial velocities", None)
    initial: tuple[Initial, ...] = parameter("", INITIAL_MEANING, ())

    _excluded: tuple[Geometry, ...] = PrivateAttr(())
    _walls: tuple[Geometry, ...] = PrivateAttr(())
    _filling: dict[tuple[object, ...], tuple[Geometry, ...]] = PrivateAttr(default_factory=dict)
    """Walls that contain points of the shape, by grid; copies of the settings share them."""

    def contains(self, places: np.ndarray, active: tuple[bool, bool, bool], periods: Vector = ZERO) -> np.ndarray:
        inside = super().contains(places, active, periods)
        for other in (*self.excluded, *self._walls):
            inside &= ~within(other, places, active, periods)
        return inside

    def with_others(self, bodies: Sequence[BodyModel]) -> Self:
        """Return a copy of these settings that also stores the regions of the other bodies named in `outside`, which are
        excluded from the shape. bodies: the bodies of the case. Raises KeyError for an unknown name.
        """
        if not self.outside:
            return self
        places = {body.name: body for body in bodies}
        aware = self.model_copy()
        aware._excluded = tuple(region for name in self.outside if (region := places[name].occupied()) is not None)
        return aware

    def keep_out_of(self, walls: Sequence[Geometry]) -> Self:
        if tuple(walls) == self._walls:
            return self
        aware = self.model_copy()
        aware._walls, aware._filling = tuple(walls), {}
        return aware

    @property
    def excluded(self) -> tuple[Geometry, ...]:
        """Regions of other bodies that are excluded from the shape. Only the model returned by `with_others` contains them."""
        if len(self._excluded) < len(self.outside):
            raise RuntimeError(
                f"body {self.name} excludes other bodies, which it has not received; call body.with_others(bodies)"
            )
        return self._excluded

    def left_out(self, grid: GridCase) -> tuple[Geometry, ...]:
        """Return the regions that are excluded from the shape: of other bodies, and of walls that contain points of the shape
        on this grid."""
        if not self._walls:
            return self.excluded
        key = (grid.lower, grid.extent_upper(), grid.cell, grid.periodic, self.points_per_cell, self.shape.model_dump_json())
        if key not in self._filling:
            active = grid.active_axes()
            per_cell = points_along_axes(self.points_per_cell, grid.thin())
            places = seed(self.shape.geometry(), grid, per_cell).position
            self._filling[key] = tuple(wall for wall in self._walls if within(wall, places, active, grid.periods()).any())
        return (*self.excluded, *self._filling[key])

    def _left_out_in(self, grid: GridCase) -> list[Geometry]:
        """Return the excluded regions, including their periodic images that intersect the shape."""
        found: list[Geometry] = []
        for other in self.left_out(grid):
            for way in images(grid.periods(), other.bounds(), self.bounds()):
                x, y, z = way.tolist()
                found.append(Shifted(shape=other, by=(x, y, z)) if way.any() else other)
        return found

    def wall_region(self, grid: GridCase) -> Geometry | None:
        left_out = self._left_out_in(grid)
        return Remainder(shape=self.occupied(), left_out=tuple(left_out)) if left_out else self.occupied()

    def excluded_bodies(self) -> tuple[str, ...]:
        return self.outside

    def occupied(self) -> Geometry:
        return self.shape.geometry()

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return self.shape.geometry().bounds()

    def seeded(self, grid: GridCase, wanted: Wanted = everywhere) -> Seeds:
        """Return the initial points of the body that `wanted` selects.

        wanted: function that returns the indices of the selected positions. Raises CaseError if no point of the body lies in
        the shape, or if the remaining part of the shape is too thin.
        """
        remedy = "use a smaller grid.cell or more points_per_cell"
        per_cell = points_along_axes(self.points_per_cell, grid.thin())
        try:
            seeds = seed(self.shape.geometry(), grid, per_cell, self._left_out_in(grid), wanted)
        except ValueError as error:
            key = "outside" if self.outside else "shape"
            raise CaseError(Problem(str(error), f"body.{self.name}.{key}", remedy=remedy)) from None
        left_out = self.left_out(grid) if not seeds.n else ()
        if left_out and seed(self.shape.geometry(), grid, per_cell).n:
            others = ["the bodies that `outside` names"] if self.outside else []
            others += ["the shapes of supports, which stop fluids"] if len(left_out) > len(self.excluded) else []
            text = f"no point of the shape is outside {' and '.join(others)}"
            text += ": nothing is left, or only gaps thinner than the distance between points"
            remedy = f"make these shapes smaller, or move them; for gaps, {remedy}"
            raise CaseError(Problem(text, f"body.{self.name}.{'outside' if self.outside else 'shape'}", remedy=remedy))
        if not seeds.n:
            text = "no material point is inside the shape: it is thinner than the distance between points"
            raise CaseError(Problem(text, f"body.{self.name}.shape", remedy=remedy))
        return seeds

    def standing(self, grid: GridCase) -> Standing:
        seeds = self.seeded(grid)
        return Standing(seeds.position, volume=seeds.volume)

    def touching_places(self, grid: GridCase, hard: bool) -> np.ndarray:
        return self.boundary(grid, hard)[0]

    def boundary_spacing(self, grid: GridCase, hard: bool) -> float:
        """Return the spacing of the contact points on the surface of the body on this grid [m]. hard: True if the body does
        not deform.
        """
        return grid.cell / max(HARD if hard else SOFT, self._points_per_edge(grid))

    def _points_per_edge(self, grid: GridCase) -> int:
        """Return the smallest number of material points along the edge of a cell."""
        per_cell = points_along_axes(self.points_per_cell, grid.thin())
        return min(n for n, thin in zip(per_cell, grid.thin(), strict=True) if not thin)

    def boundary(self, grid: GridCase, hard: bool, spacing: float | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return the initial contact points on the surface within the grid [m], and their outward vector areas [m²], shape (m,
        3) each. A cut at a face of the grid is not a surface. hard: True if the body does not deform; spacing: distance of the
        points [m], by default `boundary_spacing`.
        """
        active = grid.active_axes()

        left_out = self._left_out_in(grid)

        def contains(places: np.ndarray) -> np.ndarray:
            inside = self.shape.geometry().contains(places, active)
            for other in left_out:
                inside &= ~other.contains(places, active)
            return inside

        spacing = spacing or self.boundary_spacing(grid, hard)
        place, area = boundary_points(contains, *self.bounds(), spacing, active, grid.slice_thickness())
        flat, low, high = np.array(grid.thin()), np.array(grid.lower, float), np.array(grid.extent_upper(), float)
        depth, slack = 0.5 * grid.cell / self._points_per_edge(grid), 1e-9 * grid.cell
        anchor = place - depth * area / np.linalg.norm(area, axis=1, keepdims=True)
        folds = np.array(grid.is_periodic())
        anywhere = flat | folds
        within = (((place > low - slack) & (place < high + slack) & (anchor > low) & (anchor < high)) | anywhere).all(axis=1)
        for axis in np.flatnonzero(
            folds & (np.subtract(*self.bounds()[::-1]) > (1.0 - ON_THE_SEAM) * (high - low))
        ):  # there it goes on
            ends = np.abs(place[:, [axis]] - np.stack(self.bounds())[:, axis]).min(axis=1) < ON_THE_SEAM * spacing
            within &= ~(ends & (np.abs(area[:, axis]) > 0.5 * np.linalg.norm(area, axis=1)))
        place[:, flat] = (0.5 * (low + high))[flat]
        return place[within], area[within]

    def edge_points(self, grid: GridCase, side: float) -> EdgePoints:
        """Return contact points on the sharp edges of a body that does not deform. side: area of the largest side of the
        body [m²]."""
        active = grid.active_axes()
        others, spacing = self._left_out_in(grid), self.boundary_spacing(grid, hard=True)

        def left_out(places: np.ndarray) -> np.ndarray:
            return np.any([other.contains(places, active) for other in others], axis=0)

        found = self.shape.geometry().sharp_edges(active, spacing)
        return edge_points(found, grid, self.bounds(), spacing, side, left_out if others else None)

    def n_points(self, grid: GridCase | None) -> float:
        """Return an estimate of the number of points from the volume of the shape, accurate to one layer of points. Regions of
        other bodies are subtracted only in the model that `with_others` returns.
        """
        if grid is None:
            raise RuntimeError(f"body {self.name} needs a grid for its points, but there is none")
        active = grid.active_axes()
        geometry = self.shape.geometry()
        own = geometry.n_own_points()
        if own is not None and not self.outside:
            return own
        cells = geometry.measure(active) - sum(other.measure(active) for other in self._excluded)
        cells = max(cells, 0.0) / grid.cell ** sum(active)
        return cells * prod(points_along_axes(self.points_per_cell, grid.thin()))

    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        velocity = initial_velocity(self.velocity, self.name, (), position)
        velocity += np.cross(self.angular_velocity, position - self.shape.geometry().centre())
        if self.velocity_wave is not None:
            velocity += self.velocity_wave.at(position)
        for added in added_velocities(self.name, self.initial, position):
            velocity += added
        return velocity

    @property
    def has_users_fields(self) -> bool:
        """True if an initial field is defined by user code. Such fields are evaluated only at the points of the body, in
        the order of the points."""
        return not all(is_own(file_of(type(field))) for field in self.initial)

    def add_initial_state(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Add the initial fields of the material's state to the arrays of the points, in place. arrays: by name, with one row
        per point.
        """
        add_initial_state(self.name, self.initial, arrays)

    def wave_speeds(self) -> tuple[float, float]:
        return self.material.wave_speeds()

    @field_validator("points_per_cell")
    @classmethod
    def _positive(cls, value: int | tuple[int, int, int] | None) -> int | tuple[int, int, int] | None:
        if value is not None and min(value if isinstance(value, tuple) else (value,)) < 1:
            raise ValueError("points_per_cell must be at least 1 along every axis")
        return value
