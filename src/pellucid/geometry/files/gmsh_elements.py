"""Elements of all versions of Gmsh files: kinds, physical groups, points of the geometry."""

import re
from typing import NamedTuple

import numpy as np

from pellucid.geometry.files.contents import CORNERS, Block, Contents, Damaged
from pellucid.geometry.files.first_order import with_points

_FIRST = (
    "line triangle quad tetra hexahedron wedge pyramid line3 triangle6 quad9 "
    "tetra10 hexahedron27 wedge18 pyramid14 vertex quad8 hexahedron20 wedge15 pyramid13"
)
FIRST_KINDS = dict(enumerate(_FIRST.split(), 1))
"""Kinds of elements of version 1 by their numbers."""
_MORE = (
    "triangle9 triangle10 triangle12 triangle15 triangle15 triangle21 line4 line5 line6 tetra20 tetra35 tetra56 tetra22 tetra28"
)
KINDS = FIRST_KINDS | dict(enumerate(_MORE.split(), 20))
KINDS |= {36: "quad16", 37: "quad25", 38: "quad36", 90: "wedge40", 91: "wedge75", 92: "hexahedron64", 93: "hexahedron125"}
"""Kinds of elements by their numbers; the corners of an element precede its other nodes."""
DIMENSIONS = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2}  # others have 3


class Elements(NamedTuple):
    """Elements of one kind in a Gmsh file, with the geometric entities and groups to which the elements belong."""

    corners: np.ndarray  # (m, nodes) labels or numbers of the nodes
    entity: np.ndarray  # (m,) number of the geometric entity (such as a surface) to which each element belongs
    group: np.ndarray  # (m,) number of the physical group of each element, in format 2


def corners_of(kind: int) -> int:
    """Return the number of nodes of an element whose kind has this number in Gmsh files. Raises Damaged for an unknown kind."""
    if kind not in KINDS:
        raise Damaged(f"it has an element of kind {kind}, which is not one of the {len(KINDS)} supported kinds")
    digits = re.sub(r"\D", "", KINDS[kind])
    return int(digits) if digits else CORNERS[KINDS[kind]]


def once(elements: Elements) -> tuple[Elements, np.ndarray]:
    """Remove elements that format 2 repeats for each further physical group. Return the other elements, and for each
    original element the number of the remaining element that equals it, shape (m,).

    Elements that occur twice in one group are kept.
    """
    corners, entity, group = elements
    numbers = np.arange(len(corners))
    if len(np.unique(group)) < 2 or not entity.any():
        return elements, numbers
    keys = np.column_stack([entity, corners])
    first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)[1:]
    first_of_group = np.unique(np.column_stack([group, keys]), axis=0, return_index=True)[1]
    first = first[which.reshape(-1)]
    again = (first != numbers) & np.isin(numbers, first_of_group) & (entity != 0)
    left = np.cumsum(~again) - 1
    return Elements(*(some[~again] for some in elements)), left[np.where(again, first, numbers)]


def without_lone_vertices(contents: Contents) -> Contents:
    """Return the contents without points of the geometry that no line, surface or solid element uses, such as centres of
    arcs.

    Gmsh writes these points with the option `Mesh.SaveAll`.
    """
    used, is_vertex = np.zeros(len(contents.points), bool), np.zeros(len(contents.points), bool)
    for block in contents.blocks:
        (is_vertex if block.kind == "vertex" else used)[block.nodes] = True
    lone = is_vertex & ~used
    if not lone.any() or not used.any():
        return contents
    blocks, kept = [], {}
    for place, block in enumerate(contents.blocks):
        kept[place] = ~lone[block.nodes].any(axis=1)
        blocks.append(Block(block.kind, block.nodes[kept[place]]))
    sets = {
        name: [(np.cumsum(kept[place]) - 1)[part[kept[place][part]]] for place, part in enumerate(parts)]
        for name, parts in contents.cell_sets.items()
    }
    had = {name for name, parts in contents.cell_sets.items() if sum(map(len, parts))}
    gone = [f"`{name[:60]}`" for name, parts in sets.items() if name in had and not sum(map(len, parts))]
    sets = {name: parts for name, parts in sets.items() if f"`{name[:60]}`" not in gone}
    n = int(lone.sum())
    points = "1 point of the geometry was" if n == 1 else f"{n} points of the geometry were"
    note = f"{points} removed, as no line, surface or solid element uses them, such as centres of arcs"
    note += f"; the sets {', '.join(gone)} were removed too" if gone else ""
    left = Contents(contents.format, contents.points, tuple(blocks), {}, sets, (*contents.notes, note))
    return with_points(left, ~lone)
