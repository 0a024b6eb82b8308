"""Solids from files: Gmsh, VTK, Abaqus, Nastran and what else meshlane reads, with their named sets of nodes."""

import warnings
from dataclasses import replace

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.checks.solid_repair import repaired, upright
from pellucid.geometry.files.contents import Contents
from pellucid.geometry.files.first_order import first_order, tetrahedra, with_points
from pellucid.geometry.files.mesh_files import MeshFile
from pellucid.geometry.files.read import SOLIDS, read_file
from pellucid.geometry.meshes.coincident import same_place
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.solid_meshes.contract import Tetrahedral
from pellucid.model import InputFile, check, parameter

SOLID = ("tetra", "hexahedron", "wedge", "pyramid")
BESIDE = ("vertex", "line", "triangle", "quad", "polygon")  # what a file may hold beside the elements of a solid


class SolidFile(MeshFile, Tetrahedral):
    """A file of solid elements. Its sets of nodes, and the nodes of its sets and groups of faces and cells, have names."""

    path: InputFile = parameter("", "Gmsh, VTK, Abaqus or Nastran file; a relative path starts from the case file's folder")

    @check
    def _can_be_read(self) -> None:
        self.mesh()

    @property
    def origin(self) -> str:
        """Its path."""
        return self.path

    def expected_points(self) -> float:
        """No nodes are expected: the number is known when the file has been read."""
        return 0.0

    def make(self) -> SimplexMesh:
        """The nodes and tetrahedra of the file. Raises ValueError where it cannot be read or holds anything else."""
        contents = first_order(read_file(self.path, "a mesh", SOLIDS))
        mesh, notes = solid_of(self.path, contents, self.repair)
        for note in (*contents.notes, *notes):
            warnings.warn(f"{self.path}: {note}", stacklevel=2)
        return SimplexMesh(self.placed(mesh.nodes), mesh.cells, mesh.sets)


def solid_of(path: str, contents: Contents, repair: bool) -> tuple[SimplexMesh, list[str]]:
    """The tetrahedra of a file, in its unit and with their corners in order, and what to tell of how they came about.

    Raises Refusal for other elements, or where no solid one is.
    """
    strange = sorted({block.kind for block in contents.blocks if len(block.nodes)} - {*SOLID, *BESIDE})
    if strange:
        text = f"{path} holds cells of type {', '.join(strange)}; a solid needs tetrahedra, hexahedra, wedges or pyramids"
        raise Refusal(text, "mesh its volume with these, or leave these cells out of the file")
    if not any(len(block.nodes) for block in contents.blocks if block.kind in SOLID):
        if skipped := contents.skipped_elements():
            text = f"{path} holds no tetrahedron and no other solid element: {skipped}"
            raise Refusal(text, "save these elements as solid ones, such as those of type C3D4 and C3D8")
        remedy = "save its volume elements too; a closed surface alone is filled by `mesh = { inside = { surface = ... } }`"
        raise Refusal(f"{path} holds no tetrahedron and no other solid element", remedy)
    if not np.ptp(contents.points, axis=0).all():
        axis = "xyz"[int(np.ptp(contents.points, axis=0).argmin())]
        raise Refusal(f"{path} holds points that all have the same {axis}: no element of them has a volume", "save x, y and z")
    notes: list[str] = []
    if repair:  # before elements are cut: those on both sides of a face must have its nodes in common
        contents, notes = _merged(contents)
    cells, cut = tetrahedra(contents.blocks)
    n_own = sum(len(block.nodes) for block in contents.blocks if block.kind == "tetra")
    if not len(cells):
        raise Refusal(f"{path} holds solid elements that all have a corner twice, and so no volume", "save the mesh again")
    mesh, turned = upright(SimplexMesh(contents.points, cells, contents.nodes_of_sets()), n_own)
    if not repair:
        return mesh, [*cut, *turned]
    mesh, mended = repaired(mesh)
    if not len(mesh.cells):
        raise Refusal(f"the repair leaves nothing of {path}: none of its tetrahedra has a volume", "save the mesh again")
    return mesh, [*notes, *cut, *turned, *mended]


def _merged(contents: Contents) -> tuple[Contents, list[str]]:
    """Nodes at one place made one, with the number of the first."""
    place = same_place(contents.points, [block.nodes for block in contents.blocks if block.kind in SOLID])
    merged = np.flatnonzero(place != np.arange(len(place)))
    if not len(merged):
        return contents, []
    blocks = tuple(
        block._replace(nodes=place[block.nodes]) if block.nodes.dtype.kind in "iu" else block for block in contents.blocks
    )
    sets = {name: np.unique(place[nodes]) for name, nodes in contents.node_sets.items()}
    where = ", ".join(f"{x:.6g}" for x in contents.points[merged[0]])
    nodes = "1 node was" if len(merged) == 1 else f"{len(merged)} nodes were"
    note = f"{nodes} merged with another one at the same place, the first at ({where}), in the unit of the file"
    return with_points(replace(contents, blocks=blocks, node_sets=sets), place == np.arange(len(place))), [note]
