"""Surfaces from files: STL, OBJ, PLY, OFF, Gmsh, VTK and what else meshlane reads."""

import warnings
from functools import lru_cache

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.checks.surface_holes import MOST_EDGES
from pellucid.geometry.checks.surface_repair import repaired
from pellucid.geometry.files.contents import Contents, flat_blocks
from pellucid.geometry.files.first_order import first_order
from pellucid.geometry.files.mesh_files import FileState, MeshFile, states_of_files
from pellucid.geometry.files.read import SURFACES, read_file
from pellucid.geometry.meshes.joining import joined, layers_parted, rounding_of
from pellucid.geometry.meshes.surface_mesh import NO_QUADS, NO_TRIANGLES, Mesh, Meshed
from pellucid.model import InputFile, check, parameter

FLAT = ("quad", "triangle")
BESIDE = ("vertex", "line")  # what a file may hold beside the elements of a surface


class SurfaceFile(MeshFile, Meshed):
    """A surface file. Vertices at the same place become one, as STL repeats them."""

    path: InputFile = parameter("", "STL, OBJ, PLY, OFF, Gmsh or VTK file; a relative path starts from the case file's folder")
    close_holes: int = parameter("", "with `repair`: holes of up to so many edges are closed", 0, ge=0, le=MOST_EDGES)
    closed: bool = parameter("", "whether the surface encloses a volume: without holes; doubled elements are layers", False)
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
        (vertices, quads, triangles), _ = _read(states_of_files(self), self.repair, self.close_holes, self.closed)
        mesh = Mesh(self.placed(vertices), quads.copy(), triangles.copy())
        return mesh.reversed() if self.reverse else mesh

    def sets(self) -> dict[str, np.ndarray]:
        """Numbers of the vertices of the sets of nodes, and of the groups of elements, that the file names."""
        return _read(states_of_files(self), self.repair, self.close_holes, self.closed)[1]


@lru_cache(maxsize=8)
def _read(states: tuple[FileState, ...], repair: bool, close_holes: int, closed: bool) -> tuple[Mesh, dict[str, np.ndarray]]:
    """The file's elements and sets, read once for each of its states, in its unit."""
    path = states[0][0]
    contents = first_order(read_file(path, "a surface", SURFACES))
    number: np.ndarray | None
    mesh, number, done = surface_of(path, contents, closed)
    notes = [*contents.notes, *done]
    if closed and (parted := layers_parted(mesh)) is not None:
        apart = len(parted.vertices) - len(mesh.vertices)
        mesh, number = parted, None
        notes.append(f"two layers at one place are kept apart and joined at their rim; {apart} vertices were doubled for that")
    if repair:
        before = mesh
        mesh, done = mended(path, mesh, close_holes)
        number = number if mesh.vertices is before.vertices else None
        notes += done
    for note in notes:
        warnings.warn(f"{path}: {note}", stacklevel=2)
    return mesh, _sets_of(contents, mesh.vertices, number)


def _sets_of(contents: Contents, vertices: np.ndarray, number: np.ndarray | None) -> dict[str, np.ndarray]:
    """Its sets by the numbers of the vertices: those of its points, or without these the vertices at the same places; what is
    at none of them is no part of the surface."""
    named = contents.nodes_of_sets()
    if not named:
        return {}
    if number is not None:
        return {name: np.unique(number[nodes]) for name, nodes in named.items() if len(nodes)}
    places = np.unique(np.concatenate([vertices, contents.points]) + 0.0, axis=0, return_inverse=True)[1].reshape(-1)
    of_vertices, of_points = places[: len(vertices)], places[len(vertices) :]
    sets = {name: np.flatnonzero(np.isin(of_vertices, of_points[nodes])) for name, nodes in named.items()}
    return {name: nodes for name, nodes in sets.items() if len(nodes)}


def surface_of(path: str, contents: Contents, closed: bool = False) -> tuple[Mesh, np.ndarray, list[str]]:
    """The surface elements of a file with one vertex at each place, the vertex of each of its points, and remarks.

    Layers that the file keeps apart stay apart, see `joined`. Raises Refusal for other elements, or where none is.
    """
    points, blocks = contents.points, contents.blocks
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
        if skipped := contents.skipped_elements():
            text = f"{path} holds no triangle and no quadrilateral: {skipped}"
            raise Refusal(text, "save these elements as triangles or quadrilaterals, such as those of type S3 and S4")
        if not any(len(block.nodes) for block in blocks):
            text = f"{path} holds no triangle and no quadrilateral: it has {len(points)} points and no element"
            raise Refusal(text, "save the elements of the mesh too, or name the file that includes this one")
        raise Refusal(f"{path} holds no triangle and no quadrilateral", "save the surface elements of the mesh too")
    limit = rounding_of(points, [quads, triangles], contents.is_single)
    place, apart = joined(points, quads, triangles, limit, closed)
    kept = place == np.arange(len(place))
    number = (np.cumsum(kept) - 1)[place]
    notes = [f"{apart} vertices share their place with another one and are kept apart, as layers on each other"] * (apart > 0)
    return Mesh(points[kept], number[quads], number[triangles]), number, notes


def mended(path: str, mesh: Mesh, close_holes: int) -> tuple[Mesh, list[str]]:
    """The repaired surface of a file, and what was done. Raises Refusal where nothing is left of it."""
    mesh, done = repaired(mesh, close_holes)
    if not len(mesh.quads) + len(mesh.triangles):
        raise Refusal(f"the repair leaves nothing of {path}: none of its elements has an area", "save the surface again")
    return mesh, done
