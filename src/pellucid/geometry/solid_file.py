"""Solids from files of tetrahedra: Gmsh, VTK, Abaqus, Nastran and what else meshlane reads, with their named sets of nodes."""

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import model_validator

from pellucid.findings import Refusal
from pellucid.geometry.abaqus_surfaces import abaqus_surfaces
from pellucid.geometry.mesh_files import read_mesh
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.geometry.tetrahedral import Tetrahedral
from pellucid.model import InputFile, Vector, parameter

READABLE = "Gmsh (.msh), VTK (.vtk, .vtu), Abaqus (.inp), Nastran (.bdf, .nas)"
BELOW = ("vertex", "line", "line3", "triangle", "triangle6", "quad")  # what a file may hold beside tetrahedra
SECOND_ORDER = "tetra10"
GMSH = "gmsh:physical"
GROUPS = {GMSH, "nastran:ref", "medit:ref"}
"""Arrays that give each cell the number of its group: in Gmsh's files, Nastran's properties, Medit's references; 0 is none."""
OF_THE_READER = "gmsh:"
"""How names begin that are no sets, though they look like some."""


class SolidFile(Tetrahedral):
    """A file of tetrahedra. Its sets of nodes, and the nodes of its sets and groups of faces and cells, have names."""

    path: InputFile = parameter("", "Gmsh, VTK, Abaqus or Nastran file; a relative path starts from the case file's folder")
    scale: float = parameter("", "factor from the file's unit of length to metres, such as 0.001 for millimetres", 1.0, gt=0)
    offset: Vector = parameter("m", "added to the scaled positions", (0.0, 0.0, 0.0))

    @model_validator(mode="after")
    def _can_be_read(self) -> "SolidFile":
        self.mesh()
        return self

    @property
    def origin(self) -> str:
        """Its path."""
        return self.path

    def make(self) -> SimplexMesh:
        """The nodes and tetrahedra of the file. Raises ValueError where it cannot be read or holds anything else."""
        mesh = read_mesh(self.path, "a mesh", READABLE)
        if any(block.type == SECOND_ORDER for block in mesh.cells):
            text = (
                f"{self.path} holds second-order tetrahedra ({SECOND_ORDER}), with nodes on their edges; a solid needs those of"
            )
            raise Refusal(f"{text} four corners", "save the mesh with elements of first order")
        strange = sorted({block.type for block in mesh.cells} - {"tetra"} - set(BELOW))
        if strange:
            text = f"{self.path} holds cells of type {', '.join(strange)}; a solid needs tetrahedra of four corners alone"
            raise Refusal(text, "mesh its volume with tetrahedra, or leave these cells out of the file")
        cells = [np.asarray(block.data, np.int64) for block in mesh.cells if block.type == "tetra"]
        if not sum(map(len, cells)):
            remedy = "save its volume elements too; a closed surface alone is filled by `mesh = { inside = { surface = ... } }`"
            raise Refusal(f"{self.path} holds no tetrahedron", remedy)
        points = np.asarray(mesh.points, float)
        if points.shape[1] != 3:
            raise Refusal(
                f"{self.path} holds points in a plane; tetrahedra need three coordinates", "save x, y and z of its nodes"
            )
        sets = _sets(mesh)
        if Path(self.path).suffix.lower() == ".inp":
            sets |= abaqus_surfaces(self.path, _tetrahedra_of_sets(mesh), mesh.point_sets or {})
        return SimplexMesh(points * self.scale + np.array(self.offset), np.concatenate(cells), sets)


def _sets(mesh: Any) -> dict[str, np.ndarray]:
    """Sets of nodes by name: those of the file, the nodes of its sets and groups of cells, and what arrays mark."""
    sets = {name: np.unique(np.asarray(nodes, np.int64)) for name, nodes in (mesh.point_sets or {}).items()}
    for name, parts in (_groups(mesh) | _sets_of_cells(mesh)).items():
        nodes = [np.asarray(block.data)[part].ravel() for block, part in zip(mesh.cells, parts, strict=True)]
        sets.setdefault(name, np.unique(np.concatenate(nodes)).astype(np.int64))
    for name, values in (mesh.point_data or {}).items():
        if (marked := _marked(values)) is not None:
            sets.setdefault(name, marked)
    return sets


def _sets_of_cells(mesh: Any) -> dict[str, list[np.ndarray]]:
    """By name, the numbers of cells of each block."""
    found = {
        name: [np.asarray([] if part is None else part, np.int64) for part in parts]
        for name, parts in (mesh.cell_sets or {}).items()
        if not name.startswith(OF_THE_READER)
    }
    for name, blocks in (mesh.cell_data or {}).items():
        if name not in GROUPS and (marked := _marked(np.concatenate(blocks))) is not None:
            ends = np.cumsum([len(block) for block in blocks])
            parts = np.split(marked, np.searchsorted(marked, ends[:-1]))
            found.setdefault(name, [part - start for part, start in zip(parts, [0, *ends[:-1]], strict=True)])
    return found


def _tetrahedra_of_sets(mesh: Any) -> dict[str, np.ndarray]:
    """By name, corners of the tetrahedra of sets of cells, shape (k, 4)."""
    none = np.zeros((0, 4), np.int64)
    return {
        name: np.concatenate(
            [none, *(block.data[part] for block, part in zip(mesh.cells, parts, strict=True) if block.type == "tetra")]
        )
        for name, parts in _sets_of_cells(mesh).items()
    }


def _groups(mesh: Any) -> dict[str, list[np.ndarray]]:
    """Numbered groups of cells by their names, or by their numbers where they have none."""
    data = mesh.cell_data or {}
    named = (mesh.field_data or {}) if GMSH in data else {}
    names = {(int(number), int(dimension)): name for name, (number, dimension) in named.items()}
    none = [np.zeros(0, np.int64) for _ in mesh.cells]
    found = {name: list(none) for name in names.values()}
    for key in GROUPS & data.keys():
        for place, (block, numbers) in enumerate(zip(mesh.cells, data[key], strict=True)):
            for number in np.unique(np.asarray(numbers, np.int64)):
                if number:
                    name = names.get((int(number), block.dim), str(number))
                    found.setdefault(name, list(none))[place] = np.flatnonzero(np.asarray(numbers) == number)
    return found


def _marked(values: np.ndarray) -> np.ndarray | None:
    """Where an array of whole numbers has the larger of its two values 0 and 1, or -1 and 0; None for any other array."""
    values = np.asarray(values)
    if values.ndim != 1 or values.dtype.kind not in "biu":
        return None
    least, most = (int(values.min()), int(values.max())) if len(values) else (0, 0)
    return np.flatnonzero(values == most) if (least, most) in ((0, 1), (-1, 0)) else None
