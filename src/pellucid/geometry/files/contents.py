"""Contents of a mesh file, independent of its format, and their reduction to first-order elements and tetrahedra."""

import codecs
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
"""Encodings of a text, by the byte order mark at its start."""
_LIKE_A_NUMBER = re.compile(r"[0-9.,+\-dDeE]{0,30}[0-9][0-9.,+\-dDeE]{0,30}")


def as_utf8(data: bytes) -> bytes:
    """Return UTF-16 text as UTF-8, and other bytes unchanged, without a byte order mark."""
    mark = next((mark for mark in MARKS if data.startswith(mark)), b"")
    encoding = MARKS.get(mark, "utf-8")
    if not mark and len(data) > 3:  # UTF-16 without byte order mark: every second byte of letters is 0
        encoding = "utf-16-be" if not any(data[:64:2]) else "utf-16-le" if not any(data[1:64:2]) else ""
        encoding = encoding if any(data[:64]) else ""
    if encoding in ("utf-8", ""):
        return data[len(mark) :]
    try:
        return data[len(mark) :].decode(encoding).removeprefix("\ufeff").encode()
    except UnicodeDecodeError:
        return data


def text_of(data: bytes) -> str:
    """Decode the text of a file: UTF-8, UTF-16 with byte order mark, or else Windows-1252."""
    data = as_utf8(data)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def numbers(words: Sequence[str], line: int, count: int | None = None) -> list[float]:
    """Return the numbers of a line, which may have Fortran exponents (1.0D0). line: line number for messages. Raises
    Damaged if a word is not a number, or if there are fewer than `count` words."""
    if count is not None and len(words) < count:
        raise Damaged(f"line {line} has {len(words)} numbers instead of {count}")
    try:
        return [float(word) for word in words]
    except ValueError:
        pass
    try:
        return [float(word.lower().replace("d", "e")) for word in words]
    except ValueError:
        word, remedy = _not_a_number(words)
        raise Damaged(f"line {line} has {word} instead of a number", remedy) from None


def floats(words: Sequence[str], what: str) -> np.ndarray:
    """Return many words as an array of numbers. Raises Damaged if a word is not a number; what: plural noun for the words
    in the message."""
    try:
        return np.array(words, dtype=float)
    except ValueError:
        word, remedy = _not_a_number(words)
        raise Damaged(f"{what} contain {word} instead of a number", remedy) from None


def _not_a_number(words: Sequence[str]) -> tuple[str, str]:
    """Return the first of the words that is not a number, for a message, and a remedy if this word has a decimal comma.

    Only a word of digits and signs is quoted, so that a wrong path does not reveal the contents of a file that is not a
    mesh.
    """
    for word in words:
        if not _is_number(word):
            if not _LIKE_A_NUMBER.fullmatch(word):
                break
            if _is_number(word.replace(",", ".", 1)):
                return f"`{word}`, with a decimal comma,", "write the numbers of the file with decimal points"
            return f"`{word}`", ""
    return "a word", ""


def _is_number(word: str) -> bool:
    try:
        float(word.lower().replace("d", "e"))
    except ValueError:
        return False
    return True


def integers(words: Sequence[str], what: str) -> np.ndarray:
    """Return many words as an array of whole numbers. Raises Damaged if a word is not a whole number; what: plural noun for
    the words in the message."""
    try:
        return np.array(words, dtype=np.int64)
    except (ValueError, OverflowError):
        raise Damaged(f"{what} contain a word that is not a whole number") from None


def whole(word: str, line: int) -> int:
    """Return a word as a whole number. Raises Damaged if the word is not a whole number; line: line number for the message."""
    try:
        found = int(word)
    except ValueError:
        raise Damaged(f"line {line} has a word instead of a whole number") from None
    if abs(found) >= 2**62:
        raise Damaged(f"line {line} has a number that is too large for a count or an index")
    return found


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


def nodes_of_kind(kind: str) -> int:
    """Return the number of nodes of an element of a kind such as "tetra10" or "hexahedron"."""
    digits = re.sub(r"\D", "", kind)
    return int(digits) if digits else CORNERS[kind]


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


GMSH = "gmsh:physical"


GROUPS = {GMSH, "nastran:ref", "medit:ref"}
"""Arrays with the group number of each cell: in Gmsh files, Nastran properties, Medit references; 0 means no group."""


def marked_places(values: np.ndarray) -> np.ndarray | None:
    """Return the indices at which an integer array that marks a set by 0 and 1, or by -1 and 0, has the larger value; None
    for any other array."""
    values = np.asarray(values)
    if values.ndim != 1 or values.dtype.kind not in "biu":
        return None
    least, most = (int(values.min()), int(values.max())) if len(values) else (0, 0)
    return np.flatnonzero(values == most) if (least, most) in ((0, 1), (-1, 0)) else None


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
            cut = [_tetrahedra_of_face(corners, face) for face in _FACES[block.kind]]
            pieces = np.concatenate([piece for pair in cut for piece in pair])
            apart = (np.diff(np.sort(pieces, axis=1), axis=1) > 0).all(axis=1)  # also removes those of merged corners
            found.append(pieces[apart])
            verb = "was" if len(corners) == 1 else "were"
            notes.append(f"{counted(len(corners), block.kind)} {verb} divided into {counted(int(apart.sum()), 'tetra')}")
    return np.concatenate(found).astype(np.int64), notes


def _tetrahedra_of_face(corners: np.ndarray, face: tuple[int, ...]) -> list[np.ndarray]:
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


RESTART = -1
"""Number that separates two strips in one list."""


def triangles_of_strip(strip: list[int]) -> list[list[int]]:
    """Return the triangles of a strip, in which every three consecutive vertices form a triangle. Every second triangle is
    reversed, so that all have the same orientation.

    Triangles without area, which programs insert to join strips, are omitted.
    """
    triangles: list[list[int]] = []
    for part in _parts(strip):
        corners = zip(part, part[1:], part[2:], strict=False)
        turned = ([a, b, c] if k % 2 == 0 else [b, a, c] for k, (a, b, c) in enumerate(corners))
        triangles += [triangle for triangle in turned if len(set(triangle)) == 3]
    return triangles


def triangles_of_fan(fan: list[int]) -> list[list[int]]:
    """Return the triangles of a fan: each has the first vertex of the fan and two consecutive vertices. Triangles with a
    repeated vertex are omitted."""
    triangles = [[part[0], a, b] for part in _parts(fan) for a, b in pairwise(part[1:])]
    return [triangle for triangle in triangles if len(set(triangle)) == 3]


def _parts(corners: list[int]) -> list[list[int]]:
    parts: list[list[int]] = [[]]
    for corner in corners:
        if corner == RESTART:
            parts.append([])
        else:
            parts[-1].append(corner)
    return [part for part in parts if part]
