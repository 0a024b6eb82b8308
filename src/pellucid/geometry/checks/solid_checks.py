"""Checks of tetrahedral meshes (inverted, flat, repeated or overlapping tetrahedra, unused or coincident nodes, faces with more
than two tetrahedra, empty sets, unconnected pieces), and repairs that do not move nodes."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from pellucid.geometry.checks import REPAIR, Fault, counted, in_file
from pellucid.geometry.meshes.cells import outer_faces_of_cells
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh, faces_of_cells, in_parts
from pellucid.geometry.meshes.triangulation import first_of_each, pieces

FLATTEST = 1e-9  # volume over the cube of the longest edge; 0.118 for a regular tetrahedron
NEAREST = 1e-6  # distance of two nodes over the cube root of the mean volume: nodes at a smaller distance are coincident
MOST_NAMED = 5  # largest number of pieces whose sizes a warning lists


def solid_faults(mesh: SimplexMesh, is_pattern: bool = False) -> Iterator[Fault]:
    """Yield the faults of a tetrahedral mesh, each as a text that describes it and a remedy.

    is_pattern: True for a generated regular mesh (a box); only its coordinates and the shapes of its cells are checked.
    """
    nowhere = np.flatnonzero(~np.isfinite(mesh.nodes).all(axis=1))
    if len(nowhere):
        number = int(nowhere[0])
        text = f"node {number} (counted from 0) has the position {tuple(mesh.nodes[number].tolist())}, which is not finite"
        yield text, "correct its coordinates"
        return
    if is_pattern:
        yield from _misshapen(mesh)
        return
    yield from _empty_sets(mesh)
    yield from _lone(mesh)
    yield from _coincident(mesh)
    repeated = list(_repeated(mesh))
    yield from repeated
    yield from _misshapen(mesh)
    # faces that are crowded only by repeated tetrahedra are not reported again
    crowded = list(_crowded(mesh, np.unique(np.sort(mesh.cells, axis=1), axis=0) if repeated else mesh.cells))
    yield from crowded
    if not (repeated or crowded):
        yield from _overlapping(mesh)


def _place(position: np.ndarray) -> str:
    return ", at ({:.6g}, {:.6g}, {:.6g}) m".format(*position)


def _empty_sets(mesh: SimplexMesh) -> Iterator[Fault]:
    empty = [f"`{name}`" for name, nodes in mesh.sets.items() if not len(nodes)]
    if empty:
        verb = "set has" if len(empty) == 1 else "sets have"
        yield (
            f"{counted(len(empty), verb, verb)} no nodes: {', '.join(empty)}",
            f"list their nodes, or remove the sets from the file: {REPAIR}",
        )


def _lone(mesh: SimplexMesh) -> Iterator[Fault]:
    lone = np.flatnonzero(np.bincount(mesh.cells.ravel(), minlength=len(mesh.nodes)) == 0)
    if len(lone):
        text = f"{counted(len(lone), 'node belongs', 'nodes belong')} to no tetrahedron; the first is number {lone[0]}"
        text += " (counted from 0)"
        yield f"{text}{_place(mesh.nodes[lone[0]])}; such a node has no mass", f"remove them: {REPAIR}"


def _coincident(mesh: SimplexMesh) -> Iterator[Fault]:
    """Yield a fault if nodes have the same position, so that the elements at them are not connected and no force acts
    between them."""
    from scipy.spatial import cKDTree  # slow import, not needed to read a case

    used = np.flatnonzero(np.bincount(mesh.cells.ravel(), minlength=len(mesh.nodes)))
    limit = NEAREST * float(np.cbrt(np.mean(abs(mesh.volumes))))
    pairs = used[cKDTree(mesh.nodes[used], balanced_tree=False).query_pairs(limit, output_type="ndarray")]
    if len(pairs):
        one, other = min(map(tuple, np.sort(pairs, axis=1).tolist()))
        apart = np.linalg.norm(mesh.nodes[one] - mesh.nodes[other])
        text = f"{counted(len(pairs), 'pair of nodes has', 'pairs of nodes have')} the same position, for example numbers {one}"
        text += f" and {other} (counted from 0){_place(mesh.nodes[one])}; their distance is {apart:.3g} m and must be more than"
        text += f" {limit:.3g} m; the tetrahedra on both sides are not connected at these nodes"
        remedy = "merge these nodes (in Gmsh: Coherence before meshing, or Coherence Mesh), or make each part a separate body; "
        remedy += REPAIR
        yield text, remedy


def apart(mesh: SimplexMesh) -> str | None:
    """Return a text about the pieces of a mesh if it consists of several pieces that share no node; None if it is in one
    piece."""
    corners = mesh.cells
    label = pieces(np.concatenate([corners[:, [0, k]] for k in range(1, corners.shape[1])]), len(mesh.nodes))
    sizes = -np.sort(-np.unique(label[corners[:, 0]], return_counts=True)[1])
    if len(sizes) < 2:
        return None
    told = sizes.astype(str).tolist()
    named = " and ".join(told) if len(told) == 2 else ", ".join([*told[:MOST_NAMED], *["..."] * (len(told) > MOST_NAMED)])
    text = f"the mesh consists of {len(sizes)} pieces that share no node, of {named} tetrahedra; no force acts between them"
    return f"{text}; if they form one solid, mesh them with shared nodes on their common surface"


def _repeated(mesh: SimplexMesh) -> Iterator[Fault]:
    named = np.sort(mesh.cells, axis=1)
    order = np.lexsort(named.T[::-1])
    again = np.flatnonzero(np.all(named[order][1:] == named[order][:-1], axis=1))
    if len(again):
        one, other = sorted(order[[again[0], again[0] + 1]])
        text = f"{counted(len(again), 'tetrahedron occurs', 'tetrahedra occur')} twice, for example numbers {one} and {other}"
        yield text + _place(mesh.nodes[mesh.cells[one]].mean(axis=0)), f"remove the duplicates: {REPAIR}"


def flat_cells(mesh: SimplexMesh) -> np.ndarray:
    """Return a mask of the tetrahedra without volume, shape (c,)."""
    longest = np.zeros(len(mesh.cells))  # squares of the longest edges
    for some in in_parts(len(mesh.cells)):
        corners = np.moveaxis(mesh.nodes[mesh.cells[some]], 1, 0)
        for one, other in combinations(corners, 2):
            np.maximum(longest[some], np.square(one - other).sum(axis=1), out=longest[some])
    return np.asarray(np.abs(mesh.volumes) <= FLATTEST * longest**1.5)


def _misshapen(mesh: SimplexMesh) -> Iterator[Fault]:
    flat = flat_cells(mesh)
    for found, single, many, remedy in (
        (
            flat,
            "tetrahedron has no volume",
            "tetrahedra have no volume",
            f"remove them, or move their nodes apart (at the surface: {REPAIR})",
        ),
        (
            ~flat & (mesh.volumes < 0.0),
            "tetrahedron is inverted",
            "tetrahedra are inverted",
            "exchange two corners of each: seen from the fourth corner, the first three must be counterclockwise",
        ),
    ):
        number = np.flatnonzero(found)
        if len(number):
            text = f"{counted(len(number), single, many)}; the first is number {number[0]} (counted from 0)"
            yield text + _place(mesh.nodes[mesh.cells[number[0]]].mean(axis=0)), remedy


def _crowded(mesh: SimplexMesh, cells: np.ndarray) -> Iterator[Fault]:
    n, faces = len(mesh.nodes), faces_of_cells(cells)
    key = (faces[:, 0] * n + faces[:, 1]) * n + faces[:, 2]
    in_order = np.sort(key)
    if not (in_order[2:] == in_order[:-2]).any():
        return
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    crowded = np.flatnonzero(count > 2)
    nodes = faces[first[crowded[0]]]
    text = f"{counted(len(crowded), 'face belongs', 'faces belong')} to more than two tetrahedra, for example the face of nodes"
    text += f" {nodes[0]}, {nodes[1]} and {nodes[2]}{_place(mesh.nodes[nodes].mean(axis=0))}, where tetrahedra overlap"
    yield text, "mesh this part again"


def _overlapping(mesh: SimplexMesh) -> Iterator[Fault]:
    """Yield a fault for tetrahedra that lie on the same side of a shared face; flat tetrahedra are ignored."""
    faces = mesh.cells[:, [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]].reshape(-1, 3)  # counterclockwise seen from outside
    start = faces.argmin(axis=1)[:, None]
    turned = np.take_along_axis(faces, (start + np.arange(3)) % 3, axis=1)
    n = len(mesh.nodes)
    key = (turned[:, 0] * n + turned[:, 1]) * n + turned[:, 2]
    order = np.argsort(key)
    same = np.flatnonzero(np.diff(key[order]) == 0)
    full = (mesh.volumes > 0.0) & ~flat_cells(mesh)
    same = same[full[order[same] // 4] & full[order[same + 1] // 4]]
    if len(same):
        one, other = sorted((order[same[0]] // 4, order[same[0] + 1] // 4))
        overlaps = counted(len(same), "pair of tetrahedra overlaps", "pairs of tetrahedra overlap")
        text = f"{overlaps}: both lie on the same side"
        text += f" of a shared face, for example numbers {one} and {other} (counted from 0)"
        text += _place(mesh.nodes[mesh.cells[one]].mean(axis=0))
        yield text, "mesh this part again, or move the mesh less"


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
