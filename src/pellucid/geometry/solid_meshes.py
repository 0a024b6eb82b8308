"""Meshes of solids; a new one is one class in a file of its own and one line here."""

from collections.abc import Iterator
from functools import lru_cache
from typing import ClassVar

from pellucid.geometry.box_mesh import BoxMesh
from pellucid.geometry.choice import Choice
from pellucid.geometry.cylinder_mesh import CylinderMesh
from pellucid.geometry.fill_mesh import FillMesh
from pellucid.geometry.heart_mesh import HeartMesh
from pellucid.geometry.inside_mesh import InsideMesh
from pellucid.geometry.rotation import Rotations, rotate_parameter, turn_about
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.geometry.solid_checks import Fault, solid_faults
from pellucid.geometry.solid_file import SolidFile
from pellucid.geometry.tetrahedral import Tetrahedral


class SolidMesh(Choice):
    """A table with one key that names the mesh of a solid."""

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
        """Its nodes and tetrahedra, made once; whoever asks shares them."""
        chosen: Tetrahedral = self.chosen()
        return _turned(chosen.mesh(), self.rotate)

    def faults(self) -> Iterator[Fault]:
        """Everything wrong with them, as text, which names the file that they are from, and remedy."""
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
    """Found once for each mesh: reading a case asks for them several times."""
    return tuple(solid_faults(mesh, is_pattern))
