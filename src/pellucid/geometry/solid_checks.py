"""What is wrong with a mesh of tetrahedra: inverted, flat or repeated ones, lone nodes, crowded faces, empty sets."""

from collections.abc import Iterator

import numpy as np

from pellucid.geometry.simplex_mesh import SimplexMesh, faces_of_cells

FLATTEST = 1e-9  # volume over the cube of the longest edge; of a regular tetrahedron 0.118

Fault = tuple[str, str]


def solid_faults(mesh: SimplexMesh) -> Iterator[Fault]:
    """Everything wrong with a mesh of tetrahedra, as text and remedy."""
    nowhere = np.flatnonzero(~np.isfinite(mesh.nodes).all(axis=1))
    if len(nowhere):
        number = int(nowhere[0])
        text = f"node {number} (counted from 0) is at {tuple(mesh.nodes[number].tolist())}, which is no place"
        yield text, "give it finite coordinates"
        return
    yield from _empty_sets(mesh)
    yield from _lone(mesh)
    repeated = list(_repeated(mesh))
    yield from repeated
    yield from _misshapen(mesh)
    # what repeated tetrahedra crowd is mended with them
    yield from _crowded(mesh, np.unique(np.sort(mesh.cells, axis=1), axis=0) if repeated else mesh.cells)


def _place(position: np.ndarray) -> str:
    return " at ({:.6g}, {:.6g}, {:.6g}) m".format(*position)


def _count(n: int, verb: str, verbs: str) -> str:
    return f"1 {verb}" if n == 1 else f"{n} {verbs}"


def _empty_sets(mesh: SimplexMesh) -> Iterator[Fault]:
    empty = [f"`{name}`" for name, nodes in mesh.sets.items() if not len(nodes)]
    if empty:
        verb = "set has" if len(empty) == 1 else "sets have"
        yield f"{_count(len(empty), verb, verb)} no node: {', '.join(empty)}", "list their nodes, or take them out of the file"


def _lone(mesh: SimplexMesh) -> Iterator[Fault]:
    lone = np.flatnonzero(np.bincount(mesh.cells.ravel(), minlength=len(mesh.nodes)) == 0)
    if len(lone):
        text = f"{_count(len(lone), 'node belongs', 'nodes belong')} to no tetrahedron, the first is number {lone[0]}"
        text += ", counted from 0"
        yield f"{text}{_place(mesh.nodes[lone[0]])}; such a node has no mass", "remove them"


def _repeated(mesh: SimplexMesh) -> Iterator[Fault]:
    named = np.sort(mesh.cells, axis=1)
    order = np.lexsort(named.T[::-1])
    again = np.flatnonzero(np.all(named[order][1:] == named[order][:-1], axis=1))
    if len(again):
        one, other = sorted(order[[again[0], again[0] + 1]])
        text = f"{_count(len(again), 'tetrahedron is', 'tetrahedra are')} there twice, for example numbers {one} and {other}"
        yield text + _place(mesh.nodes[mesh.cells[one]].mean(axis=0)), "keep each tetrahedron once"


def _misshapen(mesh: SimplexMesh) -> Iterator[Fault]:
    corners = mesh.nodes[mesh.cells]
    longest = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3).max(axis=(1, 2))
    flat = np.abs(mesh.volumes) <= FLATTEST * longest**3
    for found, one, many, remedy in (
        (flat, "tetrahedron has no volume", "tetrahedra have no volume", "remove them, or move their nodes apart"),
        (
            ~flat & (mesh.volumes < 0.0),
            "tetrahedron is inverted",
            "tetrahedra are inverted",
            "exchange two corners of each: the fourth lies where the first three are seen counterclockwise from",
        ),
    ):
        number = np.flatnonzero(found)
        if len(number):
            text = f"{_count(len(number), one, many)}, the first is number {number[0]}, counted from 0"
            yield text + _place(corners[number[0]].mean(axis=0)), remedy


def _crowded(mesh: SimplexMesh, cells: np.ndarray) -> Iterator[Fault]:
    n, faces = len(mesh.nodes), faces_of_cells(cells)
    _, first, count = np.unique((faces[:, 0] * n + faces[:, 1]) * n + faces[:, 2], return_index=True, return_counts=True)
    crowded = np.flatnonzero(count > 2)
    if len(crowded):
        nodes = faces[first[crowded[0]]]
        text = f"{_count(len(crowded), 'face has', 'faces have')} more than two tetrahedra, for example that of nodes"
        text += f" {nodes[0]}, {nodes[1]} and {nodes[2]}{_place(mesh.nodes[nodes].mean(axis=0))}"
        yield text, "the tetrahedra there overlap: mesh that part again"
