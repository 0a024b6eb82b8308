"""Settings of a body of material points in a case file, and their checks."""

from collections.abc import Iterator, Sequence
from math import hypot
from typing import ClassVar, Literal

from pellucid.bodies.initial import initial_problems, plane_velocity_problems
from pellucid.bodies.material_points.checks import (
    cell_pressure_problems,
    cut_problems,
    even_points_problems,
    grid_problems,
    hydrostatic_problems,
    implicit_pressure_problems,
    outside_problems,
    rigid_problems,
    stress_problems,
)
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.placing import COMMON_FIELDS, place_problems
from pellucid.energy import FLUID_VISCOUS_HEAT, IMPLICIT_VISCOUS_HEAT, Channel
from pellucid.findings import Finding, Path
from pellucid.geometry.shapes.rotation import plane_problems
from pellucid.materials.contract import ImplicitStress
from pellucid.model import parameter
from pellucid.parts.annotations import Body, Placement
from pellucid.parts.condition import is_driven
from pellucid.parts.part import Parts
from pellucid.step.limit import StepLimit, motion_in_cells, signals_in_cells


class MaterialPointsCase(SeededBody):
    """A fluid or solid body of material points."""

    kind: Literal["material-points"] = "material-points"
    rigid: bool = parameter("", "true: a solid moves as a rigid body; its elasticity then has no effect", False)

    def build(self, placement: Placement) -> Body:
        from pellucid.bodies.material_points.body import MaterialPoints

        return MaterialPoints(self, *placement.on_grid(), placement.velocity_transfer, placement.gravity)

    @property
    def is_rigid(self) -> bool:
        return self.rigid

    separate_points: ClassVar[bool] = True

    @property
    def deforms_in_contact(self) -> bool:
        """True for solids, which have contact by their surface; a fluid has no surface of its own."""
        return not self.material.flows

    @property
    def is_fluid(self) -> bool:
        return self.material.flows

    @property
    def shear_viscosity(self) -> float:
        return self.material.shear_viscosity() if self.is_fluid and not self.rigid else 0.0

    @property
    def probed(self) -> tuple[str, ...]:
        return (*COMMON_FIELDS, *self.material.probed_fields, *(("angle",) if self.rigid else ()))

    def channels(self) -> Sequence[Channel]:
        heat = FLUID_VISCOUS_HEAT, IMPLICIT_VISCOUS_HEAT
        return heat if self.implicit_stress is not None else ()

    @property
    def implicit_stress(self) -> ImplicitStress | None:
        return self.material.implicit_stress()

    def step_limit(self, cell: float | None, is_driven: bool) -> StepLimit | None:
        """Return the largest step in which the fastest wave crosses one cell, of edge length `cell` [m]; None for bodies that
        are rigid or have a prescribed motion (`is_driven`), since there are no waves in them.
        """
        if cell is None or self.rigid or is_driven or any(self.material.problems()):
            return None
        return signals_in_cells(cell, *self.material.signals(cell), hypot(*self.velocity))

    def limit_in_motion(self, cell: float | None, is_driven: bool) -> StepLimit | None:
        """Return the step limit for the initial motion of the body; for a fluid it includes the artificial viscosity, which
        raises the signal speed under compression. cell: edge length of the cells [m], None without a grid; is_driven: True
        if motions prescribe the whole body."""
        if cell is None:
            return None
        if self.rigid or is_driven:
            return motion_in_cells(cell, self.fastest_at_start(self.places_between_bounds()))
        (wave, spread), compressed = self.material.signals(cell), self.material.signals_compressed(cell)
        found = signals_in_cells(cell, compressed, spread, self.fastest_at_start(self.places_between_bounds()))
        return found._replace(reason=f"{found.reason} with artificial viscosity") if compressed > wave else found

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings (errors of the case) for settings that do not fit the grid, other bodies or supports.

        path: path of the body in the data of the case; parts: all parts of the case.
        """
        yield from super().problems(path, parts)
        yield from initial_problems(self.initial, ("velocity", *self.material.state_fields), path)
        grid = parts.grid
        yield from plane_velocity_problems(self, path, parts)
        yield from rigid_problems(self, path)
        yield from hydrostatic_problems(self, path, parts)
        yield from stress_problems(self, path)
        yield from plane_problems(self.shape.rotate, (*path, "shape"), parts.active_axes)
        if grid is not None:
            yield from grid_problems(self, path, grid)
            goes_on = {"fills": True, "flows": self.material.flows and not self.rigid}
            yield from place_problems((*path, self.place), self.bounds(), grid, self.is_surface, self.cut_at, **goes_on)
            yield from cut_problems(self, path, grid, parts)
        yield from outside_problems(self, path, parts)
        yield from cell_pressure_problems(self, path, parts)
        yield from implicit_pressure_problems(self, path, parts)
        yield from even_points_problems(self, path, parts)
        if not (self.rigid or is_driven(self.name, parts)):
            yield from (Finding((*path, "material", key), text, remedy) for key, text, remedy in self.material.problems())
