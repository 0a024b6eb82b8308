"""Reader of Gmsh's mesh format 1 (`$NOD`, `$ELM`): text, with numbers of physical groups."""

import numpy as np

from pellucid.geometry.files.contents import Block, Contents, Damaged
from pellucid.geometry.files.gmsh_elements import FIRST_KINDS, Elements, corners_of, once, without_lone_vertices
from pellucid.geometry.files.words import floats, integers, text_of


def is_gmsh1(data: bytes) -> bool:
    """Return True if a file starts like a Gmsh file of version 1."""
    return data.lstrip()[:4] == b"$NOD"


def read_gmsh1(data: bytes) -> Contents:
    """Return the mesh in the bytes of a Gmsh file of version 1. Raises Damaged if they do not follow the format."""
    text = text_of(data)
    lines = [line.split() for line in _section(text, "NOD").splitlines()]
    rows = [words for words in lines if words]
    count = int(integers(rows[0][:1] if rows else [], "the count of nodes")[:1].sum())
    if len(rows) != 1 + count or any(len(words) < 4 for words in rows[1:]):
        raise Damaged(f"its node count is {count}, but {max(len(rows) - 1, 0)} lines with a number and coordinates follow")
    table = np.array([words[:4] for words in rows[1:]], object).reshape(count, 4)  # parameters on curves may follow
    points = floats(table[:, 1:].ravel().tolist(), "the nodes").reshape(count, 3)
    place = {int(name): k for k, name in enumerate(integers(table[:, 0].tolist(), "the numbers of nodes"))}
    if len(place) != count:
        raise Damaged(f"{count - len(place)} node numbers occur twice")
    return _elements(points, place, integers(_section(text, "ELM").split(), "the elements").tolist())


def _section(text: str, name: str) -> str:
    start, end = text.find(f"${name}"), text.find(f"$END{name}")
    if start < 0 or end < start:
        raise Damaged(f"it has no section from ${name} to $END{name}")
    return text[start + len(name) + 1 : end]


def _elements(points: np.ndarray, place: dict[int, int], words: list[int]) -> Contents:
    """Return the mesh with the elements in `words`: a count, then for each element its number, kind, physical and elementary
    group, number of nodes, and node labels. points: shape (n, 3); place: number of the node with each label."""
    found: dict[str, list[list[int]]] = {}
    at, count = 1, 0
    while at < len(words):
        if len(words) < at + 5 or not 0 < words[at + 4] <= len(words) - at - 5:
            raise Damaged(f"element {count} (counted from 0) is incomplete")
        kind, group, entity, n = words[at + 1 : at + 5]
        if kind not in FIRST_KINDS:
            raise Damaged(f"element {count} (counted from 0) has kind {kind}, but this format has 1 to {len(FIRST_KINDS)}")
        if n != corners_of(kind):
            raise Damaged(f"element {count} (counted from 0) has {n} nodes, but a {FIRST_KINDS[kind]} has {corners_of(kind)}")
        try:
            nodes = [place[node] for node in words[at + 5 : at + 5 + n]]
        except KeyError:
            raise Damaged(f"element {count} (counted from 0) has a corner that is not a node of the file") from None
        found.setdefault(FIRST_KINDS[kind], []).append([entity, abs(group), *nodes])
        at, count = at + 5 + n, count + 1
    if not words or words[0] != count:
        raise Damaged(f"its element count is {words[0] if words else 'missing'}, but it has {count} elements")
    blocks, sets = [], dict[str, list[np.ndarray]]()
    for number, (kind_name, rows) in enumerate(found.items()):
        table = np.array(rows, np.int64)
        elements, kept = once(Elements(table[:, 2:], table[:, 0], table[:, 1]))
        blocks.append(Block(kind_name, elements.corners))
        for group in np.unique(table[table[:, 1] > 0, 1]).tolist():
            parts = sets.setdefault(str(group), [np.zeros(0, np.int64) for _ in found])
            parts[number] = np.unique(kept[table[:, 1] == group])
    return without_lone_vertices(Contents("Gmsh 1, text", points, tuple(blocks), cell_sets=sets))
