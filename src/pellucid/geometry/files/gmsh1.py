"""Gmsh's first format of meshes (`$NOD`, `$ELM`): text, with numbers of physical groups."""

import numpy as np

from pellucid.geometry.files.contents import CORNERS, Block, Contents, Damaged
from pellucid.geometry.files.words import floats, integers, text_of

_KINDS = (
    "line triangle quad tetra hexahedron wedge pyramid line3 triangle6 quad9 "
    "tetra10 hexahedron27 wedge18 pyramid14 vertex quad8 hexahedron20 wedge15 pyramid13"
)
KINDS = dict(enumerate(_KINDS.split(), 1))
"""Kinds of elements by their numbers (Gmsh reference manual, MSH file format version 1); corners come first."""


def is_gmsh1(data: bytes) -> bool:
    """Whether a file begins as this format does."""
    return data.lstrip()[:4] == b"$NOD"


def read_gmsh1(data: bytes) -> Contents:
    """What is in such a file. Raises Damaged."""
    text = text_of(data)
    nodes = _section(text, "NOD").split()
    count = int(integers(nodes[:1], "the count of nodes")[0])
    if count < 0 or len(nodes) != 1 + 4 * count:
        raise Damaged(f"it counts {count} nodes, and has {(len(nodes) - 1) // 4} lines of a number and three coordinates")
    table = np.array(nodes[1:], object).reshape(count, 4)
    points = floats(table[:, 1:].ravel().tolist(), "the nodes").reshape(count, 3)
    place = {int(name): k for k, name in enumerate(integers(table[:, 0].tolist(), "the numbers of nodes"))}
    if len(place) != count:
        raise Damaged(f"{count - len(place)} numbers of nodes are there twice")
    return _elements(points, place, integers(_section(text, "ELM").split(), "the elements").tolist())


def _section(text: str, name: str) -> str:
    start, end = text.find(f"${name}"), text.find(f"$END{name}")
    if start < 0 or end < start:
        raise Damaged(f"it has no section from ${name} to $END{name}")
    return text[start + len(name) + 1 : end]


def _elements(points: np.ndarray, place: dict[int, int], words: list[int]) -> Contents:
    """Blocks of elements from count, then for each its number, kind, physical and elementary group, count of nodes, nodes."""
    found: dict[str, list[list[int]]] = {}
    groups: dict[str, dict[str, list[int]]] = {}
    at, count = 1, 0
    while at < len(words):
        if len(words) < at + 5 or not 0 < words[at + 4] <= len(words) - at - 5:
            raise Damaged(f"element {count}, counted from 0, breaks off")
        kind, group, n = KINDS.get(words[at + 1]), words[at + 2], words[at + 4]
        if kind is None:
            raise Damaged(f"element {count}, counted from 0, is of kind {words[at + 1]}, and this format has 1 to 19")
        base = Block(kind, np.zeros((0, n))).base or kind
        digits = kind.removeprefix(base)
        if n != (int(digits) if digits else CORNERS[base]):
            raise Damaged(f"element {count}, counted from 0, has {n} nodes, which a {kind} has not")
        try:
            found.setdefault(kind, []).append([place[node] for node in words[at + 5 : at + 5 + n]])
        except KeyError:
            raise Damaged(f"element {count}, counted from 0, has a corner that is none of the file's nodes") from None
        if group:
            groups.setdefault(str(group), {}).setdefault(kind, []).append(len(found[kind]) - 1)
        at, count = at + 5 + n, count + 1
    if not words or words[0] != count:
        raise Damaged(f"it counts {words[0] if words else 'no'} elements, and has {count}")
    blocks = tuple(Block(kind, np.array(nodes, np.int64)) for kind, nodes in found.items())
    sets = {name: [np.array(parts.get(kind, []), np.int64) for kind in found] for name, parts in groups.items()}
    return Contents("Gmsh 1, text", points, blocks, cell_sets=sets)
