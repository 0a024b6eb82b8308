"""Surfaces from files: STL, OBJ, PLY, Gmsh, VTK and what else meshlane reads."""

import warnings
from functools import lru_cache

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.checks.surface_holes import MOST_EDGES
from pellucid.geometry.checks.surface_repair import repaired
from pellucid.geometry.files.contents import Block, Contents, flat_blocks
from pellucid.geometry.files.first_order import first_order
from pellucid.geometry.files.mesh_files import FileState, MeshFile, states_of_files
from pellucid.geometry.files.read import SURFACES, read_file
from pellucid.geometry.meshes.surface_mesh import NO_QUADS, NO_TRIANGLES, Mesh, Meshed
from pellucid.model import InputFile, check, parameter

FLAT = ("quad", "triangle")
BESIDE = ("vertex", "line")  # what a file may hold beside the elements of a surface


class SurfaceFile(MeshFile, Meshed):
    """A surface file. Vertices at the same place become one, as STL repeats them."""

    path: InputFile = parameter("", "STL, OBJ, PLY, Gmsh or VTK file; a relative path starts from the case file's folder")
    close_holes: int = parameter("", "with `repair`: holes of up to so many edges are closed", 0, ge=0, le=MOST_EDGES)
    closed: bool = parameter("", "whether the surface encloses a volume; then it must have no holes", False)
    reverse: bool = parameter("", "turn all elements round, where the file's normals point inward", False)

    @check
    def _can_be_read(self) -> None:
        if self.close_holes and not self.repair:
            raise Refusal("`close_holes` is a part of the repair", "add `repair = true`, or leave it out")
        self.mesh()

    def expected_points(self) -> float:
        """No points are expected: the number is known when the file has been read."""
        return 0.0

    def mesh(self) -> Mesh:
        """Vertices in the order of their first mention. Raises ValueError where the file cannot be read."""
        (vertices, quads, triangles), _ = _read(*states_of_files(self), self.repair, self.close_holes)
        mesh = Mesh(self.placed(vertices), quads.copy(), triangles.copy())
        return mesh.reversed() if self.reverse else mesh

    def sets(self) -> dict[str, np.ndarray]:
        """Numbers of the vertices of the sets of nodes, and of the groups of elements, that the file names."""
        return _read(*states_of_files(self), self.repair, self.close_holes)[1]


@lru_cache(maxsize=8)
def _read(state: FileState, repair: bool, close_holes: int) -> tuple[Mesh, dict[str, np.ndarray]]:
    """The file's elements and sets, read once for each of its states, in its unit."""
    path = state[0]
    contents = first_order(read_file(path, "a surface", SURFACES))
    mesh = surface_of(path, contents.points, contents.blocks)
    notes = list(contents.notes)
    if repair:
        mesh, done = mended(path, mesh, close_holes)
        notes += done
    for note in notes:
        warnings.warn(f"{path}: {note}", stacklevel=2)
    return mesh, _sets_of(contents, mesh.vertices)


def _sets_of(contents: Contents, vertices: np.ndarray) -> dict[str, np.ndarray]:
    """Its sets by the numbers of the vertices at the same places; what is at none of them is no part of the surface."""
    named = contents.nodes_of_sets()
    if not named:
        return {}
    n = len(vertices)
    which = np.unique(np.concatenate([vertices, contents.points]) + 0.0, axis=0, return_inverse=True)[1].reshape(-1)
    vertex = np.full(which.max() + 1, -1)
    vertex[which[:n]] = np.arange(n)
    number = vertex[which[n:]]
    sets = {name: np.unique(number[nodes]) for name, nodes in named.items()}
    return {name: nodes[nodes >= 0] for name, nodes in sets.items() if (nodes >= 0).any()}


def surface_of(path: str, points: np.ndarray, blocks: tuple[Block, ...]) -> Mesh:
    """The surface elements of a file, with one vertex at each place. Raises Refusal for other elements, or where none is."""
    flat = [block for block in blocks if block.kind in FLAT]
    for block in blocks:
        if block.kind == "polygon":
            flat += flat_blocks(points, np.asarray(block.nodes).tolist(), "polygon")
    strange = sorted({block.kind for block in blocks if len(block.nodes)} - {*FLAT, *BESIDE, "polygon"})
    if strange:
        text = f"{path} holds cells of type {', '.join(strange)}; a membrane needs triangles or quadrilaterals alone"
        raise Refusal(text, "leave these cells out of the file, or save the surface of the solid alone")
    none = {"quad": NO_QUADS, "triangle": NO_TRIANGLES}
    quads, triangles = (
        np.concatenate([none[kind], *(block.nodes for block in flat if block.kind == kind)]).astype(np.int64) for kind in FLAT
    )
    if not len(quads) + len(triangles):
        raise Refusal(f"{path} holds no triangle and no quadrilateral", "save the surface elements of the mesh too")
    return _merged(points, quads, triangles)


def mended(path: str, mesh: Mesh, close_holes: int) -> tuple[Mesh, list[str]]:
    """The repaired surface of a file, and what was done. Raises Refusal where nothing is left of it."""
    mesh, done = repaired(mesh, close_holes)
    if not len(mesh.quads) + len(mesh.triangles):
        raise Refusal(f"the repair leaves nothing of {path}: none of its elements has an area", "save the surface again")
    return mesh, done


def _merged(points: np.ndarray, quads: np.ndarray, triangles: np.ndarray) -> Mesh:
    """Points at the same place made one, in the order of their first mention."""
    _, first, which = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)  # + 0.0 makes -0.0 one with 0.0
    order = np.argsort(first)
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    number = place[which.reshape(-1)]
    return Mesh(points[first[order]], number[quads], number[triangles])
