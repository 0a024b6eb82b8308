"""Solids from mesh files: Gmsh, VTK, Abaqus, Nastran and other formats that meshlane reads, with their named node sets."""

import warnings
from dataclasses import replace

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.checks.solid_checks import repaired, upright
from pellucid.geometry.files.contents import Contents, first_order, tetrahedra, with_points
from pellucid.geometry.files.read import SOLIDS, MeshFile, read_file
from pellucid.geometry.meshes.points import same_place
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.solid_meshes.contract import Tetrahedral
from pellucid.model import InputFile, check, parameter

SOLID = ("tetra", "hexahedron", "wedge", "pyramid")
BESIDE = ("vertex", "line", "triangle", "quad", "polygon")  # elements that are ignored in the file of a solid


class SolidFile(MeshFile, Tetrahedral):
    """A file of solid elements. Regions can use the names of its node sets, and of its sets and groups of faces and cells."""

    path: InputFile = parameter("", "Gmsh, VTK, Abaqus or Nastran file; a relative path is relative to the folder of the case")

    @check
    def _can_be_read(self) -> None:
        self.mesh()

    @property
    def origin(self) -> str:
        return self.path

    def expected_points(self) -> float:
        """Return 0, as the number of nodes is known only after the file has been read."""
        return 0.0

    def make(self) -> SimplexMesh:
        contents = first_order(read_file(self.path, "a mesh", SOLIDS))
        mesh, notes = solid_of(self.path, contents, self.repair)
        for note in (*contents.notes, *notes):
            warnings.warn(f"{self.path}: {note}", stacklevel=2)
        return SimplexMesh(self.placed(mesh.nodes), mesh.cells, mesh.sets)


def solid_of(path: str, contents: Contents, repair: bool) -> tuple[SimplexMesh, list[str]]:
    """Return the tetrahedra of a file, in its unit and with corners ordered for positive volumes, and notes on their
    conversion. path: for messages; contents: as read; repair: repair faults.

    Raises Refusal if the file contains other elements, or no solid element.
    """
    strange = sorted({block.kind for block in contents.blocks if len(block.nodes)} - {*SOLID, *BESIDE})
    if strange:
        text = f"{path} contains cells of type {', '.join(strange)}; a solid needs tetrahedra, hexahedra, wedges or pyramids"
        raise Refusal(text, "mesh the volume with these, or remove the other cells from the file")
    if not any(len(block.nodes) for block in contents.blocks if block.kind in SOLID):
        if skipped := contents.skipped_elements():
            text = f"{path} contains no tetrahedra or other solid elements: {skipped}"
            raise Refusal(text, "save these elements as solid elements, such as C3D4 and C3D8")
        remedy = "save the volume elements too, or fill a closed surface by `mesh = { inside = { surface = ... } }`"
        raise Refusal(f"{path} contains no tetrahedra or other solid elements", remedy)
    if not np.ptp(contents.points, axis=0).all():
        axis = "xyz"[int(np.ptp(contents.points, axis=0).argmin())]
        raise Refusal(f"all points of {path} have the same {axis}, so no element has a volume", "save x, y and z of the nodes")
    notes: list[str] = []
    if repair:  # before elements are divided: the elements on both sides of a face must share its nodes
        contents, notes = _merged(contents)
    cells, cut = tetrahedra(contents.blocks)
    n_own = sum(len(block.nodes) for block in contents.blocks if block.kind == "tetra")
    if not len(cells):
        text = f"all solid elements of {path} have a repeated corner, and so no volume"
        raise Refusal(text, "correct the mesh and save it again")
    mesh, turned = upright(SimplexMesh(contents.points, cells, contents.nodes_of_sets()), n_own)
    if not repair:
        return mesh, [*cut, *turned]
    mesh, mended = repaired(mesh)
    if not len(mesh.cells):
        text = f"the repair removes all tetrahedra of {path}, as none of them has a volume"
        raise Refusal(text, "correct the mesh and save it again")
    return mesh, [*notes, *cut, *turned, *mended]


def _merged(contents: Contents) -> tuple[Contents, list[str]]:
    """Merge coincident nodes into the first of them; return the contents and notes on the changes."""
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
    note = f"{nodes} merged with a coincident one, the first at ({where}), in the unit of the file"
    return with_points(replace(contents, blocks=blocks, node_sets=sets), place == np.arange(len(place))), [note]
