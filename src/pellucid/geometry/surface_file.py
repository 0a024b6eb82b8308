"""Surfaces from files: STL, OBJ, PLY, Gmsh, VTK and what else meshlane reads."""

from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import model_validator

from pellucid.geometry.triangulation import Triangulation
from pellucid.model import InputFile, Model, Vector, parameter

FLAT = {"triangle": [(0, 1, 2)], "quad": [(0, 1, 2), (0, 2, 3)]}  # how cells become triangles
BELOW = ("vertex", "line", "line3")  # what a file may hold beside them


class SurfaceFile(Model):
    """A surface file. Vertices at the same place become one, as STL repeats them; quadrilaterals are cut in two."""

    path: InputFile = parameter("", "STL, OBJ, PLY, Gmsh or VTK file; a relative path starts from the case file's folder")
    scale: float = parameter("", "factor from the file's unit of length to metres, such as 0.001 for millimetres", 1.0, gt=0)
    offset: Vector = parameter("m", "added to the scaled positions", (0.0, 0.0, 0.0))
    closed: bool = parameter("", "whether the surface encloses a volume; then it must have no holes", False)
    reverse: bool = parameter("", "turn all triangles round, where the file's normals point inward", False)

    @model_validator(mode="after")
    def _can_be_read(self) -> "SurfaceFile":
        self.triangulate()
        return self

    def triangulate(self) -> Triangulation:
        """Vertices in the order of their first mention. Raises ValueError where the file cannot be read."""
        file = Path(self.path)
        if not file.is_file():
            raise ValueError(f"there is no file {self.path}")
        found = file.stat()
        vertices, triangles = _read(self.path, found.st_mtime_ns, found.st_size)
        triangles = triangles[:, ::-1] if self.reverse else triangles
        return Triangulation(vertices * self.scale + np.array(self.offset), triangles.copy())


@lru_cache(maxsize=8)
def _read(path: str, _changed: int, _size: int) -> Triangulation:
    """The file's triangles, read once for each of its states."""
    if find_spec("meshlane") is None:
        raise ValueError(f"reading {path} needs meshlane: pip install 'pellucid[mesh]'")
    import meshlane

    try:
        mesh: Any = meshlane.read(path)
    except (Exception, SystemExit) as error:  # its readers raise whatever their parsing meets
        reason = str(error).strip() or type(error).__name__
        raise ValueError(f"{path} cannot be read as a surface: {reason}") from None
    strange = sorted({block.type for block in mesh.cells} - set(FLAT) - set(BELOW))
    if strange:
        raise ValueError(f"{path} holds cells of type {', '.join(strange)}; a membrane needs triangles or quadrilaterals alone")
    found = [np.asarray(block.data)[:, list(corners)] for block in mesh.cells for corners in FLAT.get(block.type, ())]
    if not found or not sum(map(len, found)):
        raise ValueError(f"{path} holds no triangle")
    points = np.zeros((len(mesh.points), 3))
    points[:, : np.shape(mesh.points)[1]] = mesh.points
    return _merged(points, np.concatenate(found).astype(np.int64))


def _merged(points: np.ndarray, triangles: np.ndarray) -> Triangulation:
    """Points at the same place made one, in the order of their first mention."""
    _, first, which = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)  # + 0.0 makes -0.0 one with 0.0
    order = np.argsort(first)
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return Triangulation(points[first[order]], place[which.reshape(-1)][triangles])
