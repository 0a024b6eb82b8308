"""Solids from files of tetrahedra: Gmsh, VTK, Abaqus, Nastran and what else meshlane reads, with their named sets of nodes."""

from typing import Any

import numpy as np
from pydantic import model_validator

from pellucid.geometry.mesh_files import read_mesh
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.geometry.tetrahedral import Tetrahedral
from pellucid.model import InputFile, Vector, parameter

BELOW = ("vertex", "line", "line3", "triangle", "triangle6", "quad")  # what a file may hold beside tetrahedra


class SolidFile(Tetrahedral):
    """A file of tetrahedra. Sets of nodes, and the nodes of sets of faces, can be named by conditions."""

    path: InputFile = parameter("", "Gmsh, VTK, Abaqus or Nastran file; a relative path starts from the case file's folder")
    scale: float = parameter("", "factor from the file's unit of length to metres, such as 0.001 for millimetres", 1.0, gt=0)
    offset: Vector = parameter("m", "added to the scaled positions", (0.0, 0.0, 0.0))

    @model_validator(mode="after")
    def _can_be_read(self) -> "SolidFile":
        self.mesh()
        return self

    def make(self) -> SimplexMesh:
        """The nodes and tetrahedra of the file. Raises ValueError where it cannot be read."""
        mesh = read_mesh(self.path, "a mesh")
        strange = sorted({block.type for block in mesh.cells} - {"tetra"} - set(BELOW))
        if strange:
            raise ValueError(
                f"{self.path} holds cells of type {', '.join(strange)}; a solid needs tetrahedra of four corners alone"
            )
        cells = [np.asarray(block.data, np.int64) for block in mesh.cells if block.type == "tetra"]
        if not sum(map(len, cells)):
            raise ValueError(f"{self.path} holds no tetrahedron")
        points = np.asarray(mesh.points, float)
        if points.shape[1] != 3:
            raise ValueError(f"{self.path} holds points in a plane; tetrahedra need three coordinates")
        return SimplexMesh(points * self.scale + np.array(self.offset), np.concatenate(cells), _sets(mesh))


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
