"""Contents of a mesh file, independent of its format."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

CORNERS = {"vertex": 1, "line": 2, "triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
"""Number of corners of the known element kinds, in the order of VTK; further nodes of an element follow its corners."""
MOST_TYPES = 5  # largest number of element types that a message lists
_KIND = re.compile(rf"({'|'.join(CORNERS)})\d*")
_LAGRANGE = {"CURVE": "line", "TRIANGLE": "triangle", "QUADRILATERAL": "quad", "TETRAHEDRON": "tetra"} | {
    kind.upper(): kind for kind in ("hexahedron", "wedge", "pyramid")
}


class Damaged(ValueError):
    """Error: the contents of a file do not follow its format.

    remedy: instruction to the user; empty if the only remedy is to write the file again.
    """

    def __init__(self, text: str, remedy: str = "") -> None:
        super().__init__(text)
        self.remedy = remedy


class Block(NamedTuple):
    """Elements of one kind, such as "tetra10", and their node numbers, counted from 0, shape (m, nodes of an element)."""

    kind: str
    nodes: np.ndarray

    @property
    def base(self) -> str | None:
        """Kind of the elements reduced to their corners, such as "tetra" for "tetra10"; None if there is none, as for
        polyhedra."""
        if found := _KIND.fullmatch(self.kind):
            return found[1]
        return _LAGRANGE.get(self.kind.removeprefix("VTK_LAGRANGE_"))


@dataclass(frozen=True)
class Contents:
    """Mesh read from a file: points, shape (n, 3), in the unit of the file, elements and named sets.

    cell_sets: for each set its name and, for each block, the indices of the elements of the block that belong to the set;
    notes: notes for the user on what was read; is_single: True if the file stores coordinates in single precision;
    skipped_types: names of the element types that were not read.
    """

    format: str  # name of the file format, for messages
    points: np.ndarray
    blocks: tuple[Block, ...]  # the elements of each kind
    node_sets: Mapping[str, np.ndarray] = field(default_factory=dict)  # point numbers, counted from 0, of each set by its name
    cell_sets: Mapping[str, list[np.ndarray]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    is_single: bool = False
    skipped_types: tuple[str, ...] = ()

    def skipped_elements(self) -> str:
        """Return a clause for messages about the element types that the reader skipped; empty if there are none."""
        if not self.skipped_types:
            return ""
        named = ", ".join(self.skipped_types[:MOST_TYPES]) + (", ..." if len(self.skipped_types) > MOST_TYPES else "")
        return f"its elements have unsupported types: {named}"

    def nodes_of_sets(self) -> dict[str, np.ndarray]:
        """Return the node numbers of all named sets: of the node sets, and of the nodes of element sets and groups."""
        sets = dict(self.node_sets)
        for name, parts in self.cell_sets.items():
            nodes = [np.asarray(block.nodes)[part].ravel() for block, part in zip(self.blocks, parts, strict=True)]
            sets.setdefault(name, np.unique(np.concatenate(nodes)).astype(np.int64))
        return sets


def flat_blocks(points: np.ndarray, faces: list[list[int]], where: str = "face") -> tuple[Block, ...]:
    """Return faces with any number of corners as blocks of quadrilaterals and triangles; larger faces are divided. points
    [unit of the file], shape (n, 3); faces: point numbers; where: word for a face in messages. Raises Damaged."""
    quads = [face for face in faces if len(face) == 4]
    triangles = [face for face in faces if len(face) == 3]
    for number, face in enumerate(faces):
        if len(face) < 3:
            raise Damaged(f"{where} {number} (counted from 0) has {len(face)} corners, but at least 3 are needed")
        if len(face) > 4:
            triangles += _cut(points, face, f"{where} {number} (counted from 0)")
    found = (("quad", quads, 4), ("triangle", triangles, 3))
    return tuple(Block(kind, np.array(some, np.int64).reshape(-1, corners)) for kind, some, corners in found if some)


def _cut(points: np.ndarray, face: list[int], where: str) -> list[list[int]]:
    """Return a polygon (point numbers) as a fan of triangles with the same orientation. Raises Damaged if there is no corner
    from which straight lines inside the polygon reach all others; where: word for the face in the message."""
    if not 0 <= min(face) <= max(face) < len(points):
        raise Damaged(f"{where} has a corner that is not one of the {len(points)} points of the file")
    for start in range(len(face)):
        turned = face[start:] + face[:start]
        corners = points[turned] - points[turned[0]]
        areas = np.cross(corners[1:-1], corners[2:])
        if (areas @ areas.sum(axis=0) > 0.0).all():
            return [[turned[0], *pair] for pair in pairwise(turned[1:])]
    raise Damaged(f"{where} has {len(face)} corners and is not convex: divide it into triangles")
