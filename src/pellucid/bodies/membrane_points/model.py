"""Settings of a membrane of material points in a case file, and their checks."""

from collections.abc import Iterator
from math import ceil
from typing import ClassVar, Literal

import numpy as np

from pellucid.bodies.membranes.bending_case import BendingCase
from pellucid.bodies.membranes.model import MembraneCase
from pellucid.bodies.membranes.plane_slice import slice_problems
from pellucid.bodies.placing import COMMON_FIELDS, longest_edge, place_problems
from pellucid.findings import Finding, Path
from pellucid.geometry.checks.surface_checks import faults
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import Triangulation, bounding_box
from pellucid.grid.model import GridCase
from pellucid.materials import AnyMembraneMaterial
from pellucid.materials.damage import DamageRecord, Elastodamage
from pellucid.model import parameter
from pellucid.parts.annotations import Body, Placement
from pellucid.parts.body_model import Standing
from pellucid.parts.part import Parts
from pellucid.step.limit import StepLimit, bending_in_cells, signals_in_cells, tightest

FEWEST_PER_CELL = 2.0  # least number of membrane points for each cell that the surface crosses
ALIKE = 1e-6  # distance below which two points count as one, in cells
COMFORTABLE = 0.6  # recommended length of an edge, in cells


class MembranePointsCase(MembraneCase):
    """A membrane whose material points are the vertices of a triangulated surface."""

    strained_from_place: ClassVar[bool] = False

    kind: Literal["membrane-points"] = "membrane-points"
    material: AnyMembraneMaterial = parameter("", "material of the membrane")

    bending: BendingCase | None = parameter("", "bending stiffness; default: none", None)

    def build(self, placement: Placement) -> Body:
        from pellucid.bodies.membrane_points.body import MembranePoints

        return MembranePoints(self, *placement.on_grid(), placement.velocity_transfer)

    remedy_for_node_contact: ClassVar[str] = 'use kind = "membrane-elements", or a smaller grid.cell'

    @property
    def probed(self) -> tuple[str, ...]:
        return (
            *COMMON_FIELDS,
            "strain_energy",
            "tension",
            *(("curvature", "bending_energy") if self.bending is not None else ()),
            *(DamageRecord._fields if isinstance(self.material.damage_law(), Elastodamage) else self.losses()),
        )

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return bounding_box(self.surface.triangulate().vertices)

    def standing(self, grid: GridCase) -> Standing:
        return Standing(*self.surface.triangulate())

    def n_points(self, grid: GridCase | None) -> float:
        return len(self.surface.triangulate().vertices)

    def step_limit(self, cell: float | None, is_driven: bool) -> StepLimit | None:
        """Return the largest stable time step by in-plane waves, viscosity and bending across one grid cell, of edge length
        `cell` [m]. is_driven: a motion prescribes the whole body.
        """
        if cell is None:
            return None
        fastest = self.fastest_at_start(self.surface.triangulate().vertices)
        signals = signals_in_cells(cell, *self.signals_at_start(), fastest, "membrane")
        rigidity = 0.0 if self.bending is None else self.bending.rigidity
        return tightest([signals, bending_in_cells(cell, rigidity / (self.material.density * self.thickness))])

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings (errors of the case) for settings that do not fit the grid, damage with bending, and points that are
        too far apart.

        path: path of the body in the data of the case; parts: all parts of the case.
        """
        yield from super().problems(path, parts)
        grid, place = parts.grid, (*path, self.place)
        if grid is None:
            return
        vertices, triangles = self.surface.triangulate()
        wrong = [Finding(place, text, remedy) for text, remedy in faults(vertices, triangles, self.surface.closed, True)]
        if wrong:
            yield from wrong
        else:
            yield from slice_problems(place, Triangulation(vertices, triangles), grid)
            yield from self._damage_problems(path, grid)
            yield from self._bending_problems((*path, "bending"), vertices, triangles, grid)
        outside = list(place_problems(place, self.bounds(), grid, self.is_surface))
        if not (wrong or outside):
            yield from self._density_problems(place, grid)
        yield from outside

    def _bending_problems(self, path: Path, vertices: np.ndarray, triangles: np.ndarray, grid: GridCase) -> Iterator[Finding]:
        if self.bending is None:
            return
        yield from self.bending.problems(
            path, Mesh(vertices, triangles=triangles), self.material, any(grid.thin()), grid.functions
        )
        if isinstance(self.material.damage_law(), Elastodamage):
            text = "failed points would still resist bending"
            yield Finding(path, text, "remove `bending`, or `damage` of the material")

    def _damage_problems(self, path: Path, grid: GridCase) -> Iterator[Finding]:
        radius = self.material.damage_radius
        if radius is not None and radius < grid.cell:
            text = f"damage.radius = {radius:g} m is less than grid.cell = {grid.cell:g} m: the average contains only one point"
            remedy = "use three cells or more, a finer grid, or remove `radius` for local damage"
            yield Finding((*path, "material"), text, remedy)

    def _density_problems(self, place: Path, grid: GridCase) -> Iterator[Finding]:
        """Yield a finding (an error of the case) if points are so far apart that the grid does not transfer forces between
        them. place: path of the surface in the data of the case.
        """
        vertices, triangles = self.surface.triangulate()
        across = np.where(grid.thin(), 0.0, vertices)  # along a thin axis nothing varies, so that distances do not count
        samples = np.concatenate([across, across[triangles].mean(axis=1)])
        cells = np.floor((samples - samples.min(axis=0)) / grid.cell).astype(int)
        crossed = len(np.unique(cells, axis=0))
        per_cell = len(np.unique(np.round(across / (ALIKE * grid.cell)), axis=0)) / crossed
        longest = longest_edge(across[triangles])
        if longest > grid.cell:
            finer = int(np.ceil(longest / (COMFORTABLE * grid.cell)))
            text = (
                f"the membrane has a triangle with an edge of {longest:.3g} m, longer "
                f"than a cell of {grid.cell:g} m: the grid tears the "
                f"membrane between its points"
            )
            yield Finding(place, text, f"refine its triangles {finer} times along each edge, or use a larger grid.cell")
        elif per_cell < FEWEST_PER_CELL:
            more = FEWEST_PER_CELL / per_cell
            text = (
                f"has {per_cell:.2g} points per grid cell that it crosses; with fewer than {FEWEST_PER_CELL:g} the grid "
                f"tears the membrane"
            )
            yield Finding(place, text, f"use {ceil(100.0 * more) / 100.0:g} times as many points, or a larger grid.cell")
