"""Solids from files of tetrahedra: Gmsh, VTK, Abaqus, Nastran and what else meshlane reads, with their named sets of nodes."""

from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import model_validator

from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.model import InputFile, Model, Vector, parameter

BELOW = ("vertex", "line", "line3", "triangle", "triangle6", "quad")  # what a file may hold beside tetrahedra


class SolidFile(Model):
    """A file of tetrahedra. Sets of nodes, and the nodes of sets of faces, can be named by conditions."""

    path: InputFile = parameter("", "Gmsh, VTK, Abaqus or Nastran file; a relative path starts from the case file's folder")
    scale: float = parameter("", "factor from the file's unit of length to metres, such as 0.001 for millimetres", 1.0, gt=0)
    offset: Vector = parameter("m", "added to the scaled positions", (0.0, 0.0, 0.0))

    @model_validator(mode="after")
    def _can_be_read(self) -> "SolidFile":
        self.mesh()
        return self

    def mesh(self) -> SimplexMesh:
        """Its nodes and tetrahedra. Raises ValueError where the file cannot be read."""
        file = Path(self.path)
        if not file.is_file():
            raise ValueError(f"there is no file {self.path}")
        found = file.stat()
        mesh = _read(self.path, found.st_mtime_ns, found.st_size)
        return SimplexMesh(mesh.nodes * self.scale + np.array(self.offset), mesh.cells.copy(), mesh.sets)


@lru_cache(maxsize=8)
def _read(path: str, _changed: int, _size: int) -> SimplexMesh:
    """The file's tetrahedra, read once for each of its states."""
    if find_spec("meshlane") is None:
        raise ValueError(f"reading {path} needs meshlane: pip install 'pellucid[mesh]'")
    import meshlane

    try:
        mesh: Any = meshlane.read(path)
    except (Exception, SystemExit) as error:  # its readers raise whatever their parsing meets
        reason = str(error).strip() or type(error).__name__
        raise ValueError(f"{path} cannot be read as a mesh: {reason}") from None
    strange = sorted({block.type for block in mesh.cells} - {"tetra"} - set(BELOW))
    if strange:
        raise ValueError(f"{path} holds cells of type {', '.join(strange)}; a solid needs tetrahedra of four corners alone")
    cells = [np.asarray(block.data, np.int64) for block in mesh.cells if block.type == "tetra"]
    if not sum(map(len, cells)):
        raise ValueError(f"{path} holds no tetrahedron")
    points = np.asarray(mesh.points, float)
    if points.shape[1] != 3:
        raise ValueError(f"{path} holds points in a plane; tetrahedra need three coordinates")
    return SimplexMesh(points, np.concatenate(cells), _sets(mesh))


def _sets(mesh: Any) -> dict[str, np.ndarray]:
    """Sets of nodes by name: those of the file, and the nodes of its sets of cells and of Gmsh's physical groups."""
    sets = {name: np.unique(np.asarray(nodes, np.int64)) for name, nodes in (mesh.point_sets or {}).items()}
    chosen = {name: list(parts) for name, parts in (mesh.cell_sets or {}).items()}
    tags = (mesh.cell_data or {}).get("gmsh:physical", [])
    for name, (tag, _dimension) in (mesh.field_data or {}).items():
        chosen.setdefault(name, [np.flatnonzero(np.asarray(block) == tag) for block in tags])
    for name, parts in chosen.items():
        nodes = [
            np.asarray(block.data)[np.asarray(part, np.int64)].ravel()
            for block, part in zip(mesh.cells, parts, strict=False)
            if part is not None and len(part)
        ]
        if nodes and name not in sets:
            sets[name] = np.unique(np.concatenate(nodes)).astype(np.int64)
    return sets
