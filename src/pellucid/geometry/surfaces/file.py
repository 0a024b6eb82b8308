"""Surfaces from mesh files: STL, OBJ, PLY, OFF, Gmsh, VTK and other formats that meshlane reads."""

import warnings
from functools import lru_cache

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.checks.surface_checks import MOST_EDGES
from pellucid.geometry.checks.surface_repair import repaired
from pellucid.geometry.files.contents import Contents, first_order, flat_blocks
from pellucid.geometry.files.read import SURFACES, FileState, MeshFile, read_file, states_of_files
from pellucid.geometry.meshes.surface_mesh import NO_QUADS, NO_TRIANGLES, Mesh, Meshed, joined, layers_parted, rounding_of
from pellucid.model import InputFile, check, parameter

FLAT = ("quad", "triangle")
BESIDE = ("vertex", "line")  # elements that are ignored in the file of a surface


class SurfaceFile(MeshFile, Meshed):
    """A surface mesh file. Coincident vertices, as in STL files, are merged."""

    path: InputFile = parameter(
        "", "STL, OBJ, PLY, OFF, Gmsh or VTK file; a relative path is relative to the folder of the case"
    )
    close_holes: int = parameter("", "largest number of edges of a hole that `repair` closes", 0, ge=0, le=MOST_EDGES)
    closed: bool = parameter(
        "", "true if the surface encloses a volume: it must have no holes, and duplicate elements become separate layers", False
    )
    reverse: bool = parameter("", "reverse all elements, for a file whose normals point inward", False)

    @check
    def _can_be_read(self) -> None:
        if self.close_holes and not self.repair:
            raise Refusal("`close_holes` is given without `repair`", "set `repair = true`, or remove `close_holes`")
        self.mesh()

    def expected_points(self) -> float:
        """Return 0, as the number of points is known only after the file has been read."""
        return 0.0

    def mesh(self) -> Mesh:
        """Return the mesh, with vertices ordered by their first use. Raises ValueError if the file cannot be read."""
        (vertices, quads, triangles), _ = _read(states_of_files(self), self.repair, self.close_holes, self.closed)
        mesh = Mesh(self.placed(vertices), quads.copy(), triangles.copy())
        return mesh.reversed() if self.reverse else mesh

    def sets(self) -> dict[str, np.ndarray]:
        """Return the vertex numbers of each node set and element group in the file, by name."""
        return _read(states_of_files(self), self.repair, self.close_holes, self.closed)[1]


@lru_cache(maxsize=8)
def _read(states: tuple[FileState, ...], repair: bool, close_holes: int, closed: bool) -> tuple[Mesh, dict[str, np.ndarray]]:
    """Return the elements and sets of the file, in its unit, cached for each version of the file. states: path, modification
    time and size of the file and of those it includes; repair, close_holes, closed: keys of `SurfaceFile`."""
    path = states[0][0]
    contents = first_order(read_file(path, "a surface", SURFACES))
    number: np.ndarray | None
    mesh, number, done = surface_of(path, contents, closed)
    notes = [*contents.notes, *done]
    if closed and (parted := layers_parted(mesh)) is not None:
        apart = len(parted.vertices) - len(mesh.vertices)
        mesh, number = parted, None
        notes.append(f"two coincident layers were separated and stay joined at their rim; {apart} vertices were duplicated")
    if repair:
        before = mesh
        mesh, done = mended(path, mesh, close_holes)
        number = number if mesh.vertices is before.vertices else None
        notes += done
    for note in notes:
        warnings.warn(f"{path}: {note}", stacklevel=2)
    return mesh, _sets_of(contents, mesh.vertices, number)


def _sets_of(contents: Contents, vertices: np.ndarray, number: np.ndarray | None) -> dict[str, np.ndarray]:
    """Return the vertex numbers of the named sets of a file.

    vertices: of the surface [unit of the file], shape (n, 3); number: vertex of each point of the file; if it is None,
    vertices are found by position, and positions that are not on the surface are dropped.
    """
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
    """Return the surface elements of a file with merged vertices, the vertex of each point of the file, and notes on the
    changes. path: for messages; contents: as read; closed: the surface encloses a volume.

    Layers that are separate in the file stay separate, see `joined`. Raises Refusal if the file contains other elements,
    or no surface element.
    """
    points, blocks = contents.points, contents.blocks
    flat = [block for block in blocks if block.kind in FLAT]
    for block in blocks:
        if block.kind == "polygon":
            flat += flat_blocks(points, np.asarray(block.nodes).tolist(), "polygon")
    strange = sorted({block.kind for block in blocks if len(block.nodes)} - {*FLAT, *BESIDE, "polygon"})
    if strange:
        text = f"{path} contains cells of type {', '.join(strange)}; a surface may only have triangles and quadrilaterals"
        raise Refusal(text, "remove these cells from the file, or save only the surface of the solid")
    none = {"quad": NO_QUADS, "triangle": NO_TRIANGLES}
    quads, triangles = (
        np.concatenate([none[kind], *(block.nodes for block in flat if block.kind == kind)]).astype(np.int64) for kind in FLAT
    )
    if not len(quads) + len(triangles):
        if skipped := contents.skipped_elements():
            text = f"{path} contains no triangles or quadrilaterals: {skipped}"
            raise Refusal(text, "save these elements as triangles or quadrilaterals, such as S3 and S4")
        if not any(len(block.nodes) for block in blocks):
            text = f"{path} contains no triangles or quadrilaterals: it has {len(points)} points and no elements"
            raise Refusal(text, "save the elements of the mesh too, or use the file that includes this one")
        raise Refusal(f"{path} contains no triangles or quadrilaterals", "save the surface elements of the mesh too")
    limit = rounding_of(points, [quads, triangles], contents.is_single)
    place, apart = joined(points, quads, triangles, limit, closed)
    kept = place == np.arange(len(place))
    number = (np.cumsum(kept) - 1)[place]
    notes = [f"{apart} vertices coincide with another one but were not merged, as they belong to separate layers"] * (apart > 0)
    return Mesh(points[kept], number[quads], number[triangles]), number, notes


def mended(path: str, mesh: Mesh, close_holes: int) -> tuple[Mesh, list[str]]:
    """Return the repaired surface of a file, and notes on the changes; close_holes: largest number of edges of a hole that
    is closed. Raises Refusal if no element is left."""
    mesh, done = repaired(mesh, close_holes)
    if not len(mesh.quads) + len(mesh.triangles):
        text = f"the repair removes all elements of {path}, as none of them has an area"
        raise Refusal(text, "correct the surface and save it again")
    return mesh, done
