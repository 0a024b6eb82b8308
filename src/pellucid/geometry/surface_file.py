"""Surfaces from files: STL, OBJ, PLY, Gmsh, VTK and what else meshlane reads."""

from functools import lru_cache

import numpy as np
from pydantic import model_validator

from pellucid.geometry.mesh import Mesh, Meshed
from pellucid.geometry.mesh_files import FileState, read_mesh, states_of_files
from pellucid.model import InputFile, Vector, parameter

READABLE = "STL (.stl), OBJ (.obj), PLY (.ply), Gmsh (.msh), VTK (.vtk, .vtu)"
FLAT = {"quad": 4, "triangle": 3}  # cells of a surface, and how many corners they have
BELOW = ("vertex", "line", "line3")  # what a file may hold beside them


class SurfaceFile(Meshed):
    """A surface file. Vertices at the same place become one, as STL repeats them."""

    path: InputFile = parameter("", "STL, OBJ, PLY, Gmsh or VTK file; a relative path starts from the case file's folder")
    scale: float = parameter("", "factor from the file's unit of length to metres, such as 0.001 for millimetres", 1.0, gt=0)
    offset: Vector = parameter("m", "added to the scaled positions", (0.0, 0.0, 0.0))
    closed: bool = parameter("", "whether the surface encloses a volume; then it must have no holes", False)
    reverse: bool = parameter("", "turn all elements round, where the file's normals point inward", False)

    @model_validator(mode="after")
    def _can_be_read(self) -> "SurfaceFile":
        self.mesh()
        return self

    def expected_points(self) -> float:
        """None: what a file holds is known when it has been read."""
        return 0.0

    def mesh(self) -> Mesh:
        """Vertices in the order of their first mention. Raises ValueError where the file cannot be read."""
        vertices, quads, triangles = _read(*states_of_files(self))
        mesh = Mesh(vertices * self.scale + np.array(self.offset), quads.copy(), triangles.copy())
        return mesh.reversed() if self.reverse else mesh


@lru_cache(maxsize=8)
def _read(state: FileState) -> Mesh:
    """The file's elements, read once for each of its states."""
    path = state[0]
    mesh = read_mesh(path, "a surface", READABLE)
    strange = sorted({block.type for block in mesh.cells} - set(FLAT) - set(BELOW))
    if strange:
        raise ValueError(f"{path} holds cells of type {', '.join(strange)}; a membrane needs triangles or quadrilaterals alone")
    found = {
        kind: np.concatenate(
            [np.zeros((0, corners), np.int64), *(np.asarray(block.data) for block in mesh.cells if block.type == kind)]
        )
        for kind, corners in FLAT.items()
    }
    if not any(map(len, found.values())):
        raise ValueError(f"{path} holds no triangle and no quadrilateral")
    points = np.zeros((len(mesh.points), 3))
    points[:, : np.shape(mesh.points)[1]] = mesh.points
    return _merged(points, found["quad"].astype(np.int64), found["triangle"].astype(np.int64))


def _merged(points: np.ndarray, quads: np.ndarray, triangles: np.ndarray) -> Mesh:
    """Points at the same place made one, in the order of their first mention."""
    _, first, which = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)  # + 0.0 makes -0.0 one with 0.0
    order = np.argsort(first)
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    number = place[which.reshape(-1)]
    return Mesh(points[first[order]], number[quads], number[triangles])
