"""Repairs of tetrahedral meshes that do not move nodes."""

import numpy as np

from pellucid.geometry.checks.solid_checks import flat_cells
from pellucid.geometry.checks.words import counted, in_file
from pellucid.geometry.meshes.cells import outer_faces_of_cells
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.meshes.triangulation import first_of_each


def upright(mesh: SimplexMesh, n_told: int) -> tuple[SimplexMesh, list[str]]:
    """Return the mesh with corners of tetrahedra reordered so that all volumes are positive, and notes for the user on the
    inverted tetrahedra.

    n_told: the notes count only the first `n_told` cells, which are tetrahedra in the file; later cells are parts of other
    elements.
    """
    turned = np.flatnonzero(mesh.volumes < 0.0)
    if not len(turned):
        return mesh, []
    cells = mesh.cells.copy()
    cells[turned] = cells[turned][:, [1, 0, 2, 3]]
    told = turned[turned < n_told]
    upright_mesh = SimplexMesh(mesh.nodes, cells, mesh.sets)
    if not len(told):
        return upright_mesh, []
    where = in_file(mesh.nodes[mesh.cells[told[0]]].mean(axis=0))
    how_many = "all" if len(told) == n_told else str(len(told))
    return upright_mesh, [f"{how_many} of {n_told} tetrahedra were inverted: their corners were reordered, the first {where}"]


def repaired(mesh: SimplexMesh) -> tuple[SimplexMesh, list[str]]:
    """Return the mesh without the parts listed below, and notes for the user on the changes, with positions in the unit of the
    nodes.

    Removed are tetrahedra with a repeated corner, flat tetrahedra at the surface, duplicates, unused nodes, and empty sets.
    """
    notes: list[str] = []

    def kept(cells: np.ndarray, keep: np.ndarray, one: str, many: str) -> np.ndarray:
        gone = np.flatnonzero(~keep)
        if len(gone):
            where = in_file(mesh.nodes[cells[gone[0]]].mean(axis=0))
            notes.append(f"{counted(len(gone), f'{one} was', f'{many} were')} removed, the first {where}")
        return cells[keep]

    cells = mesh.cells
    twice = (np.diff(np.sort(cells, axis=1), axis=1) == 0).any(axis=1)
    cells = kept(cells, ~twice, "tetrahedron with a repeated corner", "tetrahedra with a repeated corner")
    cells = kept(cells, first_of_each(cells), "duplicate tetrahedron", "duplicate tetrahedra")
    outer = np.zeros(len(cells), bool)
    outer[outer_faces_of_cells(cells)[1]] = True  # inside the solid, a flat tetrahedron may connect the cells on its two sides
    flat = outer & flat_cells(SimplexMesh(mesh.nodes, cells))
    cells = kept(cells, ~flat, "tetrahedron without volume", "tetrahedra without volume")
    used = np.zeros(len(mesh.nodes), bool)
    used[cells] = True
    if lone := int(np.count_nonzero(~used)):
        where = in_file(mesh.nodes[np.flatnonzero(~used)[0]])
        notes.append(f"{counted(lone, 'unused node was', 'unused nodes were')} removed, the first {where}")
    number = np.cumsum(used) - 1
    sets = {name: number[nodes[used[nodes]]] for name, nodes in mesh.sets.items()}
    empty = [f"`{name}`" for name, nodes in sets.items() if not len(nodes)]
    if empty:
        notes.append(f"{counted(len(empty), 'set without nodes was', 'sets without nodes were')} removed: {', '.join(empty)}")
    sets = {name: nodes for name, nodes in sets.items() if len(nodes)}
    return SimplexMesh(mesh.nodes[used], number[cells], sets), notes
