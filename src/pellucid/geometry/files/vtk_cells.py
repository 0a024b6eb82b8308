"""Conversion of cells and arrays of VTK unstructured grids, from legacy and XML files, to blocks and sets.

Source: Schroeder, Martin & Lorensen, The VTK User's Guide, file formats; vtkCellType.h.
"""

from collections.abc import Iterable, Mapping
from itertools import pairwise

import numpy as np

from pellucid.geometry.files.contents import (
    CORNERS,
    GROUPS,
    Block,
    Contents,
    Damaged,
    flat_blocks,
    marked_places,
    nodes_of_kind,
    triangles_of_strip,
)

_KINDS = {1: "vertex", 3: "line", 5: "triangle", 8: "quad", 9: "quad", 10: "tetra", 11: "hexahedron", 12: "hexahedron"}
_KINDS |= {13: "wedge", 14: "pyramid", 21: "line3", 22: "triangle6", 23: "quad8", 24: "tetra10", 25: "hexahedron20"}
_KINDS |= {26: "wedge15", 27: "pyramid13", 28: "quad9", 29: "hexahedron27", 30: "quad6", 31: "wedge12", 32: "wedge18"}
_KINDS |= {33: "hexahedron24", 34: "triangle7", 35: "line4", 37: "pyramid19"}
_OF_ANY_ORDER = {68: "line", 69: "triangle", 70: "quad", 71: "tetra", 72: "hexahedron", 73: "wedge", 74: "pyramid"}
_OF_ANY_ORDER |= {number + 7: kind for number, kind in _OF_ANY_ORDER.items()}  # Bézier cells, after Lagrange cells
_ALONG_AXES = {8: [0, 1, 3, 2], 11: [0, 1, 3, 2, 4, 5, 7, 6]}
"""Corners of pixels and voxels in the order of quadrilaterals and hexahedra."""
_POINTS, _LINES, _STRIP, _POLYGON = 2, 4, 6, 7
_LEFT_OUT = {0}  # an empty cell


def grid_contents(
    form: str,
    points: np.ndarray,
    connectivity: np.ndarray,
    ends: np.ndarray,
    types: np.ndarray,
    arrays: tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]],
    is_single: bool,
) -> Contents:
    """Return the mesh of a VTK unstructured grid, with its cells sorted by kind. Raises Damaged.

    form: name of the format; points: shape (n, 3); connectivity: the point numbers of all cells, one cell after the other;
    ends: for each cell the position in `connectivity` behind its last point; types: VTK type of each cell; arrays: arrays of
    points and of cells by name, of which integer arrays may mark sets; is_single: the file stores single precision.
    """
    if len(ends) != len(types):
        raise Damaged(f"it has {len(types)} cell types for {len(ends)} cells")
    if len(ends) and not ((np.diff(ends, prepend=0) >= 0).all() and ends[-1] <= len(connectivity)):
        raise Damaged("the offsets of its cells are not ascending, or exceed the connectivity")
    starts = np.concatenate([[0], ends[:-1]]).astype(np.int64)
    lengths = ends - starts
    rows: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}  # cells of each kind, their nodes and their numbers in the file
    for number in dict.fromkeys(types.tolist()):
        cells = np.flatnonzero(types == number)
        if number in _LEFT_OUT:
            continue
        if number in (_POINTS, _LINES, _STRIP, _POLYGON):
            for cell in cells.tolist():
                for kind, nodes in _simple(number, points, connectivity[starts[cell] : ends[cell]].tolist()):
                    rows.setdefault(kind, []).append((nodes, np.full(len(nodes), cell)))
            continue
        for length in dict.fromkeys(lengths[cells].tolist()):
            some = cells[lengths[cells] == length]
            nodes = connectivity[starts[some, None] + np.arange(length)]
            rows.setdefault(_kind(number, length), []).append((nodes[:, _ALONG_AXES.get(number, slice(None))], some))
    blocks = tuple(Block(kind, np.concatenate([nodes for nodes, _ in parts])) for kind, parts in rows.items())
    origins = [np.concatenate([cells for _, cells in parts]) for parts in rows.values()]
    node_sets = dict(_sets(arrays[0]))
    marked = [*_groups(arrays[1]), *_sets({name: values for name, values in arrays[1].items() if name not in GROUPS})]
    cell_sets = {name: [np.flatnonzero(np.isin(cells, places)) for cells in origins] for name, places in marked}
    return Contents(form, points, blocks, node_sets, cell_sets, is_single=is_single)


def _sets(arrays: Mapping[str, np.ndarray]) -> Iterable[tuple[str, np.ndarray]]:
    return ((name, places) for name, values in arrays.items() if (places := marked_places(values)) is not None)


def _groups(arrays: Mapping[str, np.ndarray]) -> Iterable[tuple[str, np.ndarray]]:
    """Yield the number of each group of cells, as text, and the indices of its cells. The group numbers are in the arrays named
    in `GROUPS`, in which programs that convert other formats store them. arrays: arrays of the cells by name."""
    for name in sorted(GROUPS & arrays.keys()):
        values = np.asarray(arrays[name])
        for number in np.unique(values[values != 0]).tolist():
            yield f"{number:g}", np.flatnonzero(values == number)


def _kind(number: int, length: int) -> str:
    """Return the kind of a cell from its VTK type (`number`) and its number of points (`length`); for unsupported types, a
    name that no other module uses."""
    if number in _OF_ANY_ORDER:
        base = _OF_ANY_ORDER[number]
        if length < CORNERS[base]:
            raise Damaged(f"a cell of type {number} has {length} points, but needs at least {CORNERS[base]}")
        return base if length == CORNERS[base] else f"{base}{length}"
    if number not in _KINDS:
        return "polyhedron" if number in (41, 42) else f"VTK {number}"
    kind = _KINDS[number]
    if length != (needed := nodes_of_kind(kind)):
        raise Damaged(f"a cell of type {number} has {length} points, but needs {needed}")
    return kind


def _simple(number: int, points: np.ndarray, corners: list[int]) -> list[tuple[str, np.ndarray]]:
    """Return a VTK cell with any number of corners (points, line, strip or polygon) as elements: the kind and the nodes of
    each. number: VTK type of the cell; corners: its point numbers."""
    if number == _POLYGON:
        return [(block.kind, block.nodes) for block in flat_blocks(points, [corners], "a polygon")]
    if number == _STRIP:
        found, kind, width = triangles_of_strip(corners), "triangle", 3
    elif number == _LINES:
        found, kind, width = [list(pair) for pair in pairwise(corners)], "line", 2
    else:
        found, kind, width = [[corner] for corner in corners], "vertex", 1
    return [(kind, np.array(found, np.int64).reshape(-1, width))] if found else []
