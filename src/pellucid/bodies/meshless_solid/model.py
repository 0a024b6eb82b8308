"""Settings of a meshless solid in a case file, and their checks."""

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from pellucid.approximants.nodal.contract import AnyNodalApproximant
from pellucid.approximants.nodal.least_squares import CellLeastSquaresModel
from pellucid.bodies.damped_model import DampedModel
from pellucid.bodies.initial import INITIAL_MEANING, Initial, Stress, initial_problems, initial_stress, initial_velocity
from pellucid.bodies.placing import place_problems
from pellucid.findings import Finding, Path
from pellucid.geometry.checks.quality import slowest_of_solid, step_warning
from pellucid.geometry.meshes.cells import outer_faces, vector_areas
from pellucid.geometry.meshes.points import spatial_order
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.region import Selectable
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.solid_meshes.solid_mesh import MeshRegion, SolidMesh
from pellucid.grid.model import GridCase
from pellucid.materials import Material
from pellucid.materials.hyperelastic import HyperelasticMaterial
from pellucid.materials.law import Law
from pellucid.materials.point_state import initial_arrays
from pellucid.materials.viscoelastic import ViscoelasticMaterial
from pellucid.model import Vector, parameter
from pellucid.parts.body_model import BodyModel, Standing, is_alone
from pellucid.parts.elastic_system import FEW_NODES, LARGEST_FACTORS, StiffnessSize
from pellucid.parts.part import Parts

if TYPE_CHECKING:
    from pellucid.bodies.meshless_solid.material_forces import Viscous
    from pellucid.parts.body import Body, Placement

ENTRY_BYTES = 60  # memory per quadrature point and node: shape function, gradient, node number, data of a step
QUADRATURE_BYTES = 300  # memory per quadrature point: position, fit, deformation gradient
MOST_TRIED = 10_000  # largest number of cells for the check, whose functions are computed in a second
NEARLY_INCOMPRESSIBLE = 0.4  # Poisson's ratio from which the volume ratio is averaged


class MeshlessSolidCase(DampedModel):
    """An elastic or viscous solid on its own nodes, with shape functions over a background mesh, in total-Lagrangian form."""

    place: ClassVar[str] = "mesh"
    scales_inertia: ClassVar[bool] = True
    own_material_nodes: ClassVar[bool] = True

    kind: Literal["meshless-solid"] = "meshless-solid"
    mesh: SolidMesh = parameter("", "mesh of nodes and tetrahedra")
    material: Material = parameter("", "material: hyperelastic, or viscoelastic with a hyperelastic part")
    approximant: AnyNodalApproximant = parameter("", "shape functions", CellLeastSquaresModel())
    essential: Literal["direct", "ebciem", "sebciem"] = parameter(
        "",
        "how supports and motions prescribe the field: direct (nodal values), or by forces at nodes (sebciem) or distributed "
        "over faces (ebciem)",
        "direct",
    )
    points_per_cell: Literal[1, 4, 8, 16, 32] = parameter("", "quadrature points of a tetrahedron", 4)
    consistent: bool = parameter("", "true: correct the gradients of the shape functions for consistent quadrature", True)
    volume_averaging: bool | None = parameter(
        "",
        "true: average the volume ratio around nodes, against locking; default: true from a Poisson's ratio of 0.4",
        None,
    )
    initial_stress: Stress | None = parameter(
        "Pa",
        "initial stress, components xx, yy, zz, yz, xz, xy; it moves with the material and adds to the stress of the law",
        None,
    )
    velocity: Vector = parameter("m/s", "initial velocity", (0.0, 0.0, 0.0))
    initial: tuple[Initial, ...] = parameter("", INITIAL_MEANING, ())

    def mesh_in_order(self) -> SimplexMesh:
        """Return the mesh of the solid with its tetrahedra in spatial order."""
        mesh = self.mesh.mesh()
        return SimplexMesh(mesh.nodes, mesh.cells[self._order_of_cells()], mesh.sets)

    def _order_of_cells(self) -> np.ndarray:
        mesh = self.mesh.mesh()
        return spatial_order(mesh.nodes[mesh.cells].mean(axis=1))

    @property
    def averages_volume(self) -> bool:
        """True if the volume ratio is averaged around the corners of cells, by default for nearly incompressible solids."""
        if self.volume_averaging is not None:
            return self.volume_averaging
        return float(getattr(self._at_rest, "poisson_ratio", 0.5)) >= NEARLY_INCOMPRESSIBLE

    @property
    def _at_rest(self) -> Material:
        """Return the hyperelastic material that carries the load when all viscous stresses have relaxed."""
        return self.material.hyperelastic() if isinstance(self.material, ViscoelasticMaterial) else self.material

    @property
    def density(self) -> float:
        """Density of the material at rest [kg/m³]."""
        return self.material.density

    def law(self) -> Law:
        """Return the hyperelastic law in the form that the kernels use."""
        return self._at_rest.law()

    def viscous(self) -> "Viscous | None":
        """Return the material law with history variables and the initial state of a point; None for a hyperelastic solid."""
        from pellucid.bodies.meshless_solid.material_forces import Viscous

        if isinstance(self.material, HyperelasticMaterial):
            return None
        return Viscous(self.material.law(), self.material.initial_state())

    def build(self, placement: "Placement") -> "Body":
        from pellucid.bodies.meshless_solid.body import MeshlessSolid

        return MeshlessSolid(self, placement)

    def why_no_stiffness(self) -> str | None:
        if self.essential == "direct":
            return None
        return (
            f'essential = "{self.essential}" of body {self.name} prescribes the displacements by forces, which the factored '
            'stiffness does not include (only essential = "direct")'
        )

    def why_no_implicit_steps(self) -> str | None:
        return self.why_no_stiffness()

    def stiffness_size(self) -> StiffnessSize:
        """Return the size of the factored stiffness: that of the solid, or of its linear tetrahedra where the former has larger
        factors than `LARGEST_FACTORS`. It is estimated for shape functions of the nodes of a cell, or of all cells around a
        cell, such as the default ones; functions with a radius may need more."""
        unknowns = 4 if self.averages_volume else 3  # of a node
        return _stiffness_size(self.mesh.mesh(), self.approximant.follows_cells, unknowns, LARGEST_FACTORS)

    @property
    def approximates_stiffness(self) -> bool:
        """True if the factored stiffness is that of the linear tetrahedra of the mesh instead of that of the solid."""
        return len(self.mesh.mesh().nodes) > FEW_NODES and self.stiffness_size().is_approximate

    @property
    def deforms_in_contact(self) -> bool:
        return True

    def check_set_up(self) -> None:
        """Raise CaseError for positions without shape functions. Only for meshes of up to 10 000 cells, and for approximants
        whose functions do not exist everywhere.
        """
        from pellucid.bodies.meshless_solid.functions import check_functions

        mesh = self.mesh.mesh()
        if self.approximant.remedy and len(mesh.cells) <= MOST_TRIED:
            check_functions(self, mesh)

    def start_warnings(self) -> Iterator[str]:
        """Yield a warning if only a few elements, which are much smaller than the others, determine the time step. Only for
        approximants whose functions follow the elements; the functions of others extend beyond single elements.
        """
        mesh = self.mesh.mesh()
        if self.approximant.follows_cells and (found := slowest_of_solid(mesh)):
            yield step_warning(self.name, found, mesh.nodes[mesh.cells].mean(axis=1))

    def owns_nodes(self, alone: bool) -> bool:
        return True

    @property
    def has_triangles(self) -> bool:
        return True

    def selectable(self) -> Selectable | None:
        return _selectable(self.mesh.mesh())

    def needs_grid(self, parts: Parts) -> bool:
        """True if there are other bodies in the case (`parts`): contact with them uses the grid."""
        return len(parts.names(BodyModel)) > 1

    def occupied(self) -> Geometry:
        return MeshRegion(mesh=self.mesh)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return self.occupied().bounds()

    def standing(self, grid: GridCase) -> Standing:
        return Standing(self.mesh.mesh().nodes)

    def faces_pressed(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        mesh = self.mesh.mesh()
        faces = outer_faces(mesh.cells)
        corners = mesh.nodes[faces]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        # of halves of a square the side, not the diagonal
        return corners.mean(axis=1), vector_areas(mesh.nodes, faces), np.median(edges, axis=1)

    def n_points(self, grid: GridCase | None) -> float:
        return len(self.mesh.mesh().nodes)

    def table_bytes(self) -> float:
        """Return the largest memory [bytes] that the shape functions at quadrature points need; it is reached while they
        are built."""
        points = len(self.mesh.mesh().cells) * self.points_per_cell
        history = 0
        if isinstance(self.material, ViscoelasticMaterial):
            history = sum(array.nbytes for array in initial_arrays(self.material.initial_state(), 1).values())
        return points * (ENTRY_BYTES * self.approximant.nodes_in_a_cell + QUADRATURE_BYTES + history)

    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        return initial_velocity(self.velocity, self.name, self.initial, position)

    def initial_stress_at(self, position: np.ndarray) -> np.ndarray | None:
        """Return the initial stress [Pa], shape (n, 6), at positions [m], shape (n, 3), which must be the quadrature points of
        `mesh_in_order`; None if there is none. Initial fields are evaluated in the original order of the mesh.
        """
        order = self._order_of_cells()
        places = np.empty((len(order), self.points_per_cell, 3))
        places[order] = position.reshape(places.shape)
        stress = initial_stress(self.initial_stress, self.name, self.initial, places.reshape(position.shape))
        return None if stress is None else stress.reshape(len(order), -1, 6)[order].reshape(-1, 6)

    def wave_speeds(self) -> tuple[float, float]:
        return self.material.wave_speeds()

    @property
    def probed(self) -> tuple[str, ...]:
        return (
            "position",
            "velocity",
            "mass",
            "density",
            "pressure",
            "stress",
            "strain_energy",
            "stored_energy",
            "kinetic_energy",
            *(("dissipated_energy",) if isinstance(self.material, ViscoelasticMaterial) else ()),
        )

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings (errors of the case) for faults of the mesh, materials without a hyperelastic law, and settings that
        do not fit the grid.

        path: path of the body in the data of the case; parts: all parts of the case.
        """
        yield from super().problems(path, parts)
        yield from initial_problems(self.initial, ("velocity", "stress"), path)
        if not isinstance(self.material, HyperelasticMaterial | ViscoelasticMaterial):
            text = (
                f'kind "{self.material.kind}" has no energy as a function of the deformation gradient, which a '
                "meshless solid needs"
            )
            yield Finding((*path, "material"), text, 'use a hyperelastic material such as "neo-hookean"')
        yield from (Finding((*path, self.place), text, remedy) for text, remedy in self.mesh.faults())
        if parts.grid is not None:
            if not is_alone(self, parts):
                text = f'other bodies share the velocity field "{self.field}", but a meshless solid needs its own'
                yield Finding((*path, "field"), text, f'set a separate field, such as field = "{self.name}"')
            if self.essential != "direct":
                text = "forces that prescribe the field cannot be combined with walls and contact on a grid"
                remedy = 'use "direct", or remove the grid'
                yield Finding((*path, "essential"), text, remedy)
            if any(parts.grid.thin()):
                text = "a meshless solid is three-dimensional, but this grid is one cell thick"
                yield Finding((*path, self.place), text, "make the grid more than one cell thick along every axis")
            yield from place_problems((*path, self.place), self.bounds(), parts.grid, self.is_surface)


@lru_cache(maxsize=8)
def _selectable(mesh: SimplexMesh) -> Selectable:
    """Return the nodes and faces of a mesh from which regions select; cached, since reading a case requests them several
    times.
    """
    return Selectable.of_solid(mesh)


@lru_cache(maxsize=8)
def _stiffness_size(mesh: SimplexMesh, follows_cells: bool, d: int, largest: float) -> StiffnessSize:
    """Return the size of the factored stiffness of a solid on a mesh with d unknowns per node, of which it has at most
    `largest` entries unless it is approximate.

    follows_cells: True if the shape functions at a point are those of the corners of its cell.
    """
    from pellucid.linear.elimination import factor_size

    linear, unknowns = factor_size(mesh.neighbours, mesh.nodes, d), 3 * len(mesh.nodes)
    if follows_cells:
        return StiffnessSize(unknowns, *linear)
    if linear.numbers <= largest:
        near = mesh.neighbours @ mesh.incidence
        own = factor_size(near @ near.T, mesh.nodes, d)
        if own.numbers <= largest:
            return StiffnessSize(unknowns, *own)
    return StiffnessSize(unknowns, *linear, is_approximate=True)
