"""Selection of the mesh of a solid in a case by one key. To add a mesh, define its class in a module of this folder and add a
field with its key to `SolidMesh`."""

from collections.abc import Iterator
from functools import lru_cache
from typing import ClassVar

import numpy as np

from pellucid.geometry.checks import Fault
from pellucid.geometry.checks.solid_checks import solid_faults
from pellucid.geometry.choice import Choice
from pellucid.geometry.meshes.cells import outer_faces
from pellucid.geometry.meshes.enclosure import inside
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.meshes.triangulation import bounding_box
from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
from pellucid.geometry.shapes.rotation import Rotations, rotate_parameter, turn_about
from pellucid.geometry.solid_meshes.box import BoxMesh, CylinderMesh
from pellucid.geometry.solid_meshes.contract import Tetrahedral
from pellucid.geometry.solid_meshes.file import SolidFile
from pellucid.geometry.solid_meshes.fill import FillMesh, InsideMesh
from pellucid.geometry.solid_meshes.heart import HeartMesh
from pellucid.model import parameter


class SolidMesh(Choice):
    """A table with exactly one key, which selects the mesh of a solid."""

    what: ClassVar[str] = "the mesh of a solid"
    beside: ClassVar[tuple[str, ...]] = ("rotate",)

    box: BoxMesh | None = None
    cylinder: CylinderMesh | None = None
    fill: FillMesh | None = None
    inside: InsideMesh | None = None
    heart: HeartMesh | None = None
    file: SolidFile | None = None
    rotate: Rotations = rotate_parameter("the mesh")

    def mesh(self) -> SimplexMesh:
        """Return the nodes and tetrahedra. The result is cached and shared by all callers."""
        chosen: Tetrahedral = self.chosen()
        return _turned(chosen.mesh(), self.rotate)

    def faults(self) -> Iterator[Fault]:
        """Yield the faults of the mesh, each as a text that names its file, and a remedy."""
        chosen: Tetrahedral = self.chosen()
        before = f"{chosen.origin}: " if chosen.origin else ""
        return ((before + text, remedy) for text, remedy in _faults(self.mesh(), chosen.is_pattern))


@lru_cache(maxsize=8)
def _turned(mesh: SimplexMesh, rotate: Rotations) -> SimplexMesh:
    if rotate is None:
        return mesh
    middle = 0.5 * (mesh.nodes.min(axis=0) + mesh.nodes.max(axis=0))
    return SimplexMesh(turn_about(rotate, middle).forth(mesh.nodes), mesh.cells, mesh.sets)


@lru_cache(maxsize=8)
def _faults(mesh: SimplexMesh, is_pattern: bool) -> tuple[Fault, ...]:
    """Return the faults of a mesh, as `solid_faults` yields them, cached because reading a case uses them several times;
    is_pattern: True for a generated regular mesh (a box)."""
    return tuple(solid_faults(mesh, is_pattern))


class MeshRegion(Geometry):
    """The region filled by the tetrahedra of a mesh, for grids without thin axes."""

    mesh: SolidMesh = parameter("", "tetrahedral mesh")

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return bounding_box(self.mesh.mesh().nodes)

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        mesh = self.mesh.mesh()
        return inside(points, mesh.nodes, outer_faces(mesh.cells))

    def measure(self, active: ActiveAxes) -> float:
        return float(self.mesh.mesh().volumes.sum())
