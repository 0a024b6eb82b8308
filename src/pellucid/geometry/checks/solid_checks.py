"""What is wrong with a mesh of tetrahedra: inverted, flat or repeated ones, lone nodes, crowded faces, empty sets, parts that
lie side by side and do not hold together."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from pellucid.geometry.checks.words import REPAIR, Fault, counted
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh, faces_of_cells, in_parts
from pellucid.geometry.meshes.triangulation import pieces

FLATTEST = 1e-9  # volume over the cube of the longest edge; of a regular tetrahedron 0.118
NEAREST = 1e-6  # distance of two nodes over the cube root of the mean volume: below, they are one place that is there twice
MOST_NAMED = 5  # pieces whose sizes a warning reports


def solid_faults(mesh: SimplexMesh, is_pattern: bool = False) -> Iterator[Fault]:
    """Everything wrong with a mesh of tetrahedra, as text and remedy; of a pattern that fills a solid, wrong coordinates."""
    nowhere = np.flatnonzero(~np.isfinite(mesh.nodes).all(axis=1))
    if len(nowhere):
        number = int(nowhere[0])
        text = f"node {number} (counted from 0) is at {tuple(mesh.nodes[number].tolist())}, which is no place"
        yield text, "give it finite coordinates"
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
    # what repeated tetrahedra crowd is mended with them
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
            f"{counted(len(empty), verb, verb)} no node: {', '.join(empty)}",
            f"list their nodes, or take them out of the file: {REPAIR}",
        )


def _lone(mesh: SimplexMesh) -> Iterator[Fault]:
    lone = np.flatnonzero(np.bincount(mesh.cells.ravel(), minlength=len(mesh.nodes)) == 0)
    if len(lone):
        text = f"{counted(len(lone), 'node belongs', 'nodes belong')} to no tetrahedron, the first is number {lone[0]}"
        text += ", counted from 0"
        yield f"{text}{_place(mesh.nodes[lone[0]])}; such a node has no mass", f"remove them: {REPAIR}"


def _coincident(mesh: SimplexMesh) -> Iterator[Fault]:
    """Two nodes at one place, between which no element passes on any force."""
    from scipy.spatial import cKDTree  # heavy: only where a mesh is worked on

    used = np.flatnonzero(np.bincount(mesh.cells.ravel(), minlength=len(mesh.nodes)))
    limit = NEAREST * float(np.cbrt(np.mean(abs(mesh.volumes))))
    pairs = used[cKDTree(mesh.nodes[used], balanced_tree=False).query_pairs(limit, output_type="ndarray")]
    if len(pairs):
        one, other = min(map(tuple, np.sort(pairs, axis=1).tolist()))
        apart = np.linalg.norm(mesh.nodes[one] - mesh.nodes[other])
        text = f"{counted(len(pairs), 'pair of nodes is', 'pairs of nodes are')} at one place, for example numbers {one} and "
        text += (
            f"{other}, counted from 0{_place(mesh.nodes[one])}, {apart:.3g} m apart, which must be more than {limit:.3g} m; "
        )
        text += "the tetrahedra on both sides do not hold together there"
        remedy = (
            "merge such nodes (in Gmsh: Coherence before meshing, or Coherence Mesh), or make each part a body of its own; "
        )
        remedy += REPAIR
        yield text, remedy


def apart(mesh: SimplexMesh) -> str | None:
    """A warning of a mesh of several pieces, which share no node and so pass no force on to each other; None of one piece."""
    corners = mesh.cells
    label = pieces(np.concatenate([corners[:, [0, k]] for k in range(1, corners.shape[1])]), len(mesh.nodes))
    sizes = -np.sort(-np.unique(label[corners[:, 0]], return_counts=True)[1])
    if len(sizes) < 2:
        return None
    told = sizes.astype(str).tolist()
    named = " and ".join(told) if len(told) == 2 else ", ".join([*told[:MOST_NAMED], *["..."] * (len(told) > MOST_NAMED)])
    text = f"the mesh is {len(sizes)} pieces that share no node, of {named} tetrahedra; no force passes between them"
    return f"{text}: if they are one solid, mesh them with the surface between them in common"


def _repeated(mesh: SimplexMesh) -> Iterator[Fault]:
    named = np.sort(mesh.cells, axis=1)
    order = np.lexsort(named.T[::-1])
    again = np.flatnonzero(np.all(named[order][1:] == named[order][:-1], axis=1))
    if len(again):
        one, other = sorted(order[[again[0], again[0] + 1]])
        text = f"{counted(len(again), 'tetrahedron is', 'tetrahedra are')} there twice, for example numbers {one} and {other}"
        yield text + _place(mesh.nodes[mesh.cells[one]].mean(axis=0)), f"keep each tetrahedron once: {REPAIR}"


def flat_cells(mesh: SimplexMesh) -> np.ndarray:
    """Which tetrahedra have no volume, shape (c,)."""
    longest = np.zeros(len(mesh.cells))  # squares of their longest edges
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
            f"remove them, or move their nodes apart: {REPAIR} for those at the surface",
        ),
        (
            ~flat & (mesh.volumes < 0.0),
            "tetrahedron is inverted",
            "tetrahedra are inverted",
            "exchange two corners of each: the fourth lies where the first three are seen counterclockwise from",
        ),
    ):
        number = np.flatnonzero(found)
        if len(number):
            text = f"{counted(len(number), single, many)}, the first is number {number[0]}, counted from 0"
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
    text = f"{counted(len(crowded), 'face has', 'faces have')} more than two tetrahedra, for example that of nodes"
    text += f" {nodes[0]}, {nodes[1]} and {nodes[2]}{_place(mesh.nodes[nodes].mean(axis=0))}"
    yield text, "the tetrahedra there overlap: mesh that part again"


def _overlapping(mesh: SimplexMesh) -> Iterator[Fault]:
    """Tetrahedra with volume that lie on the same side of a face that they share."""
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
        text = f"{counted(len(same), 'pair of tetrahedra lies', 'pairs of tetrahedra lie')} on one side of a face of both, for"
        text += f" example numbers {one} and {other}, counted from 0{_place(mesh.nodes[mesh.cells[one]].mean(axis=0))}"
        yield text, "they overlap, as where a mesh was moved too far: mesh that part again"
