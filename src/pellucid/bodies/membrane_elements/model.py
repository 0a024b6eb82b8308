"""Settings of a membrane of finite elements in a case file, and their checks."""

from collections.abc import Callable, Iterator, Sequence
from math import ceil, hypot, pi, sqrt
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import PrivateAttr

from pellucid.bodies.membrane_elements.constraints import Constraints, slopes_of
from pellucid.bodies.membrane_elements.forces_ahead import share_of_viscosity
from pellucid.bodies.membrane_elements.hourglass import HourglassCase
from pellucid.bodies.membrane_elements.mesh import ElementMesh, incidence
from pellucid.bodies.membranes.bending_case import BendingCase, bending_rate
from pellucid.bodies.membranes.model import MembraneCase
from pellucid.bodies.membranes.plane_slice import slice_problems
from pellucid.bodies.placing import longest_edge, place_problems
from pellucid.findings import Finding, Path
from pellucid.geometry.checks.quality import rates_of_surface, slowest_of_surface, step_warning
from pellucid.geometry.checks.surface_checks import mesh_faults
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import bounding_box
from pellucid.geometry.surfaces.surface import Elements
from pellucid.grid.model import GridCase
from pellucid.materials import AnySolidMembraneMaterial
from pellucid.model import parameter
from pellucid.parts.annotations import Body, Placement
from pellucid.parts.body_model import BodyModel, Standing, is_alone
from pellucid.parts.elastic_system import StiffnessSize
from pellucid.parts.part import Parts
from pellucid.step.limit import (
    StepLimit,
    bending_in_cells,
    bending_in_mesh,
    motion_in_cells,
    tightest,
    told,
    waves_in_liquid,
    waves_in_mesh,
)

SLACK = 1e-9  # relative tolerance of lengths, for round-off
PASS_THROUGH = "other bodies would pass through the membrane between its nodes"

REST_OF_SURFACE = (
    "use the whole closed surface (for a file: `closed = true`); for a part between planes of symmetry, without [steady], "
    "replace `volume_stiffness` by an [[enclosed]] `liquid` with `lids = true`"
)


class MembraneElementsCase(MembraneCase):
    """A membrane of finite elements. Contact with solids and membranes is by surfaces, with fluids on the grid."""

    own_material_nodes: ClassVar[bool] = True

    kind: Literal["membrane-elements"] = "membrane-elements"
    material: AnySolidMembraneMaterial = parameter("", "material of the membrane")
    elements: Elements = parameter(
        "", "element type; quads: quadrilaterals if the surface has them; triangles: each quadrilateral is cut in two", "quads"
    )
    area_stiffness: float = parameter(
        "N/m", "penalty k_A on changes of the total area, with the energy k_A (A - A₀)²/2A₀", 0.0, ge=0
    )
    volume_stiffness: float = parameter(
        "Pa", "penalty k_V on changes of the enclosed volume, with the energy k_V (V - V₀)²/2V₀", 0.0, ge=0
    )
    bending: BendingCase | None = parameter("", "bending stiffness; default: none", None)
    hourglass: HourglassCase = parameter("", "hourglass control of its quadrilaterals", HourglassCase())

    _is_shared: bool = PrivateAttr(False)  # True if other bodies share its velocity field
    _liquid: tuple[float, float] | None = PrivateAttr(None)
    """Largest density [kg/m³] and least viscosity [Pa s] of the liquids in its velocity field if their pressure is implicit."""

    @property
    def probed(self) -> tuple[str, ...]:
        motion = ("position", "velocity", "mass", "kinetic_energy")
        bent = ("curvature", "bending_energy") if self.bending is not None else ()
        fields = ("density", "pressure", "stress", "tension", "thickness", "stored_energy", "strain_energy")
        return (*motion, *fields, *self.losses(), *bent)

    @property
    def is_kept(self) -> bool:
        """True if the area or the enclosed volume of the membrane has a penalty on its change."""
        return self.area_stiffness + self.volume_stiffness > 0.0

    @property
    def deforms_in_contact(self) -> bool:
        return True

    @property
    def crumples(self) -> bool:
        return self.material.wrinkling and self.bending is None

    def owns_nodes(self, alone: bool) -> bool:
        return alone

    def why_no_stiffness(self) -> str | None:
        if self.material.wrinkling:
            return f"body {self.name} wrinkles: its forces have kinks, at which the factored stiffness fails"
        if len(self.mesh().quads):
            return (
                f"body {self.name} has quadrilaterals, whose hourglass forces depend on the way; the factored stiffness needs "
                'elements = "triangles"'
            )
        return None

    def stiffness_size(self) -> StiffnessSize:
        from scipy.sparse import csr_array

        from pellucid.linear.elimination import factor_size

        mesh = self.mesh()
        touch = incidence(mesh.triangles, len(mesh.vertices))
        links = csr_array(touch.T @ touch)
        size = factor_size(links if self.bending is None else csr_array(links @ links), mesh.vertices, 3)
        return StiffnessSize(3 * len(mesh.vertices), size.numbers, size.operations)

    def with_others(self, bodies: Sequence[BodyModel]) -> Self:
        aware = self.model_copy()
        together = [body for body in bodies if body.field == self.field]
        aware._is_shared = len(together) > 1
        solved = [
            (body.material.density, stress.least)
            for body in together
            if (stress := body.implicit_stress) is not None and stress.stiffness > 0.0
        ]
        densities, viscosities = zip(*solved, strict=True) if solved else ((), ())
        aware._liquid = (max(densities), min(viscosities)) if solved else None
        return aware

    def in_liquid(self, cell: float) -> Callable[[float], StepLimit] | None:
        """Return the step limit by in-plane waves as a function of their speed [m/s], if the membrane moves with liquids whose
        pressure is implicit; else None. cell: edge length of the grid cells [m]."""
        if self._liquid is None:
            return None
        areal_density, (_, viscosity) = self.material.density * self.thickness, self._liquid
        return lambda wave: waves_in_liquid(cell, wave, areal_density, viscosity)

    def viscosity_share(self, wave: float) -> float:
        """Return 1 if viscosity dominates the motion of the membrane in its liquids, 0 if inertia does or if their pressure is
        not implicit, or a number between, see `share_of_viscosity`; wave: speed of in-plane waves [m/s]."""
        if self._liquid is None or self._liquid[1] == 0.0:
            return 0.0
        mesh = self.mesh()
        radius = sqrt(float(ElementMesh(mesh).areas(mesh.vertices).sum()) / (4.0 * pi))
        return share_of_viscosity(self.material.density * self.thickness * wave**2, radius, *self._liquid)

    def needs_grid(self, parts: Parts) -> bool:
        """True if there are other bodies in the case (`parts`): contact with them uses the grid."""
        return len(parts.names(BodyModel)) > 1

    def build(self, placement: Placement) -> Body:
        from pellucid.bodies.membrane_elements.on_grid import ElementsOnGrid
        from pellucid.bodies.membrane_elements.on_own_nodes import MembraneElements

        if placement.velocity_field is not None and placement.velocity_field.moves_points:
            return ElementsOnGrid(self, *placement.on_grid(), placement.velocity_transfer)
        return MembraneElements(self, placement)

    def start_warnings(self) -> Iterator[str]:
        """Yield a warning if only a few elements, which are much smaller than the others, determine the time step."""
        mesh = self.mesh()
        if found := slowest_of_surface(mesh):
            yield step_warning(self.name, found, mesh.centres())

    def step_limit(self, cell: float | None, is_driven: bool) -> StepLimit | None:
        """Return the largest stable time step, limited by waves across an element, nodes that cross a grid cell, penalty
        springs, and bending. cell: edge length of the grid cells [m], or None; is_driven: a motion prescribes the whole body.
        """
        wave, diffusivity = self.signals_at_start()
        mesh = self.mesh()
        fastest = float(rates_of_surface(mesh).max())
        together = [waves_in_mesh(wave * fastest, wave, "membrane", fastest * fastest * diffusivity)]
        if cell and (in_liquid := self.in_liquid(cell)) is not None:
            together = [in_liquid(wave)]
        if self.is_kept:
            elements = ElementMesh(mesh)
            kept = Constraints.of(self.area_stiffness, self.volume_stiffness, elements, mesh.vertices)
            slopes = slopes_of(elements, mesh.vertices)
            together.append(kept.swings(*slopes, self._node_masses(elements, mesh)).limit())
        apart = [motion_in_cells(cell, self.fastest_at_start(mesh.vertices))] if cell else []
        if self.bending is not None and self._is_shared and cell:  # the grid moves the membrane
            apart.append(bending_in_cells(cell, self.bending.rigidity / (self.material.density * self.thickness)))
        elif self.bending is not None:
            mass = self._node_masses(ElementMesh(mesh), mesh)
            ratio = self.bending.plate_ratio(self.material)
            rate = bending_rate(mesh.triangles, mesh.vertices, mass, self.bending.rigidity, ratio)
            together.append(bending_in_mesh(rate))
        return tightest([told(hypot(*(1.0 / limit.step for limit in together)), together), *apart])

    def _node_masses(self, elements: ElementMesh, mesh: Mesh) -> np.ndarray:
        """Return the nodal masses at the start [kg], shape (n,). elements, mesh: the initial mesh in the form of the kernels
        and of the case.
        """
        return elements.at_nodes(self.material.density * self.thickness * elements.areas(mesh.vertices))

    def mesh(self) -> Mesh:
        """Return the mesh of the elements at the start."""
        return self.surface.mesh(self.elements)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return bounding_box(self.mesh().vertices)

    def standing(self, grid: GridCase) -> Standing:
        return Standing(*self.mesh().triangulated())

    def n_points(self, grid: GridCase | None) -> float:
        return len(self.mesh().vertices)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings (errors of the case) for faults of the mesh and settings that do not fit the grid.

        path: path of the body in the data of the case; parts: all parts of the case.
        """
        yield from super().problems(path, parts)
        if self.material.damage:
            text = "elements have no law of damage: a failed element would leave a hole"
            yield Finding((*path, "material"), text, "remove `damage`, or use kind membrane-points")
        place = (*path, self.place)
        wrong = [Finding(place, text, remedy) for text, remedy in mesh_faults(self.mesh(), self.surface.closed, True)]
        yield from wrong
        if self.bending is not None and not wrong:
            functions = None if parts.grid is None or is_alone(self, parts) else parts.grid.functions
            known = self.mesh(), self.material, not all(parts.active_axes), functions
            yield from self.bending.problems((*path, "bending"), *known)
        if self.is_kept and not wrong:
            yield from self._constraint_problems(path, parts)
        if parts.grid is None:
            return
        if not wrong:
            yield from slice_problems(place, self.mesh().triangulated(), parts.grid)
        if not wrong and len(parts.names(BodyModel)) > 1:  # alone it touches nothing, and its nodes need no grid
            yield from self._size_problems(place, parts.grid)
        yield from place_problems(place, self.bounds(), parts.grid, self.is_surface)

    def _constraint_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings (errors of the case) for penalties on area or volume of a membrane with quadrilaterals or on a grid
        one cell thick, and a volume penalty for an open surface. path: path of the body in the data of the case; parts: all
        parts of the case.
        """
        key = (*path, "volume_stiffness" if self.volume_stiffness else "area_stiffness")
        if len(self.mesh().quads):
            yield Finding(
                key,
                "penalties on area and volume apply to triangles, but the membrane has quadrilaterals",
                'use `elements = "triangles"`',
            )
        elif not all(parts.active_axes):
            yield Finding(
                key,
                "penalties on area and volume apply to surfaces in space, but the grid is one cell thick along an axis",
                "remove it",
            )
        elif self.volume_stiffness > 0.0 and not self.surface.closed:
            yield Finding(
                key,
                "`volume_stiffness` requires a closed surface, but this surface is open and encloses no volume",
                REST_OF_SURFACE,
            )

    def _size_problems(self, place: Path, grid: GridCase) -> Iterator[Finding]:
        """Yield a finding (an error of the case) for elements so large that some grid cells between their nodes would contain
        no node of the membrane. place: path of the surface in the data of the case.
        """
        mesh, thin, reach = self.mesh(), grid.thin(), sqrt(0.5) * grid.cell
        places = np.where(thin, 0.0, mesh.vertices)  # along a thin axis nothing varies, so that distances do not count
        longest, remote = longest_edge(places[mesh.quads]), 0.0
        if any(thin):
            longest = max(longest, longest_edge(places[mesh.triangles]))
        else:
            remote = float(_remoteness(places[mesh.triangles]).max(initial=0.0))
        if longest > grid.cell * (1.0 + SLACK):
            text = (
                f"the membrane has an element with an edge of {longest:.3g} m, longer "
                f"than a cell of {grid.cell:g} m: {PASS_THROUGH}"
            )
            yield Finding(place, text, _finer(longest / grid.cell))
        elif remote > reach * (1.0 + SLACK):
            text = (
                f"the membrane has a triangle that extends {remote:.3g} m from its "
                f"corners; with cells of {grid.cell:g} m this is more than"
            )
            yield Finding(place, f"{text} {reach:.3g} m: {PASS_THROUGH}", _finer(remote / reach))


def _finer(times: float) -> str:
    return f"refine its elements {ceil(times)} times along each edge, or use a larger grid.cell"


def _remoteness(places: np.ndarray) -> np.ndarray:
    """Return for each triangle the largest distance of its points from the nearest corner [m], shape (m,). places: positions
    of the corners [m], shape (m, 3, 3).

    The most remote point is the circumcentre if no angle is obtuse, else a point of the longest edge. For a square cut in two
    it is the centre of the square.
    """
    edges = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2)
    a, b, c = np.sort(edges, axis=1).T
    cos_a, cos_b = (b * b + c * c - a * a) / (2.0 * b * c), (a * a + c * c - b * b) / (2.0 * a * c)
    cos_c = np.maximum((a * a + b * b - c * c) / (2.0 * a * b), 0.0)
    acute = c / (2.0 * np.sqrt(1.0 - cos_c * cos_c))
    obtuse = np.maximum(b / (2.0 * cos_a), a / (2.0 * cos_b))
    return np.asarray(np.where(a * a + b * b >= c * c, acute, obtuse))
