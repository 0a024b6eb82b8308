"""Reduction of higher-order elements to their corners, and division of solid elements into tetrahedra."""

from dataclasses import replace

import numpy as np

from pellucid.geometry.files.contents import CORNERS, Block, Contents

_FACES = {
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    "wedge": ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "hexahedron": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}
"""Corners of the faces, counterclockwise seen from outside, of elements in the order of VTK."""
_MANY = {
    "tetra": "tetrahedra",
    "hexahedron": "hexahedra",
    "wedge": "wedges",
    "pyramid": "pyramids",
    "quad": "quadrilaterals",
    "triangle": "triangles",
    "line": "lines",
    "vertex": "points",
}


def counted(n: int, kind: str) -> str:
    """Return a number of elements of a kind as text, in the singular or plural: "3 hexahedra"."""
    return f"{n} {({'quad': 'quadrilateral', 'tetra': 'tetrahedron'}.get(kind, kind)) if n == 1 else _MANY[kind]}"


def first_order(contents: Contents) -> Contents:
    """Return the contents with only the corner nodes of elements; nodes on edges and in the interior are removed."""
    n, is_corner, is_between = len(contents.points), np.zeros(len(contents.points), bool), np.zeros(len(contents.points), bool)
    blocks, notes = [], []
    for block in contents.blocks:
        base = block.base
        corners = block if base is None else Block(base, block.nodes[:, : CORNERS[base]])
        if corners.nodes.dtype.kind in "iu":
            is_corner[corners.nodes] = True
        if base is not None and base != block.kind:
            is_between[block.nodes[:, CORNERS[base] :]] = True
            verb = "was" if len(block.nodes) == 1 else "were"
            notes.append(f"{counted(len(block.nodes), base)} of higher order ({block.kind}) {verb} reduced to the corners")
        blocks.append(corners)
    if not notes:
        return contents
    kept = is_corner | ~is_between
    if n > np.count_nonzero(kept):
        notes[-1] += f"; {n - np.count_nonzero(kept)} nodes between corners were removed"
    return with_points(replace(contents, blocks=tuple(blocks), notes=(*contents.notes, *notes)), kept)


def with_points(contents: Contents, kept: np.ndarray) -> Contents:
    """Return the contents with only the points in the mask `kept`, shape (n,), which must include all nodes of elements."""
    number = np.cumsum(kept) - 1
    blocks = tuple(
        block._replace(nodes=number[block.nodes]) if block.nodes.dtype.kind in "iu" else block for block in contents.blocks
    )
    sets = {name: number[nodes[kept[nodes]]] for name, nodes in contents.node_sets.items()}
    return replace(contents, points=contents.points[kept], blocks=blocks, node_sets=sets)


def tetrahedra(blocks: tuple[Block, ...]) -> tuple[np.ndarray, list[str]]:
    """Return tetrahedra, shape (c, 4), and notes on divided elements: the tetrahedra among the solid elements in `blocks`,
    followed by the parts of other elements.

    Each quadrilateral is divided from its corner with the smallest number, so that the elements on both sides of a face
    divide it in the same way. Each element is divided into tetrahedra that connect its corner with the smallest number to
    the triangles of the other faces. Source: Dompierre, Labbé, Vallet & Camarero 1999, 8th International Meshing
    Roundtable, 195, for hexahedra without their division into five.
    """
    found, notes = [np.zeros((0, 4), np.int64), *(block.nodes for block in blocks if block.kind == "tetra")], []
    for block in blocks:
        corners = block.nodes
        if block.kind in _FACES and len(corners):
            cut = [_cut(corners, face) for face in _FACES[block.kind]]
            pieces = np.concatenate([piece for pair in cut for piece in pair])
            apart = (np.diff(np.sort(pieces, axis=1), axis=1) > 0).all(axis=1)  # also removes those of merged corners
            found.append(pieces[apart])
            verb = "was" if len(corners) == 1 else "were"
            notes.append(f"{counted(len(corners), block.kind)} {verb} divided into {counted(int(apart.sum()), 'tetra')}")
    return np.concatenate(found).astype(np.int64), notes


def _cut(corners: np.ndarray, face: tuple[int, ...]) -> list[np.ndarray]:
    """Return tetrahedra that connect the triangles of one face of m elements to the corner with the smallest number of each
    element, shape (m, 4) each. corners: nodes of the elements, shape (m, corners); face: indices of the corners of the
    face.

    For faces that contain this corner, the tetrahedra are degenerate: they have it twice.
    """
    top = corners.min(axis=1)[:, None]
    nodes = corners[:, face]
    if len(face) == 4:
        start = nodes.argmin(axis=1)[:, None]
        nodes = np.take_along_axis(nodes, (start + np.arange(4)) % 4, axis=1)
        return [np.concatenate([nodes[:, [0, 2, 1]], top], axis=1), np.concatenate([nodes[:, [0, 3, 2]], top], axis=1)]
    return [np.concatenate([nodes[:, [0, 2, 1]], top], axis=1)]
