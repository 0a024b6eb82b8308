"""Reader of legacy VTK files with polygons or unstructured grids, text and binary, versions up to 5.1, and the conversion of
cells and arrays of unstructured grids, from legacy and XML files, to blocks and sets.

Source: Schroeder, Martin & Lorensen, The VTK User's Guide, file formats; vtkCellType.h.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import pairwise
from urllib.parse import unquote

import numpy as np

from pellucid.geometry.files.contents import (
    CORNERS,
    GROUPS,
    Block,
    Contents,
    Damaged,
    flat_blocks,
    floats,
    integers,
    marked_places,
    nodes_of_kind,
    text_of,
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


TYPES = {"float": "f4", "double": "f8", "vtktypeint64": "i8", "vtkidtype": "i8"}
for _name, _size in (("char", 1), ("short", 2), ("int", 4), ("long", 8)):
    TYPES |= {_name: f"i{_size}", f"unsigned_{_name}": f"u{_size}"}
POLYGONS, STRIPS, CELLS = "POLYGONS", "TRIANGLE_STRIPS", "CELLS"
LISTS = (POLYGONS, STRIPS, "LINES", "VERTICES", CELLS)
DATASETS = ((b"DATASET", b"POLYDATA"), (b"DATASET", b"UNSTRUCTURED_GRID"))
DATA = ("POINT_DATA", "CELL_DATA")
WIDTHS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1}
"""Number of values in a row of an array, by the keyword of the array; the name and type of the array follow the keyword."""
UNREAD = "some of its arrays were not read, so sets defined by these arrays are missing"


def is_grid(data: bytes) -> bool:
    """Return True if a file starts like a legacy VTK file with polygons or an unstructured grid."""
    head = data.upper().split()
    return head[:4] == [b"#", b"VTK", b"DATAFILE", b"VERSION"] and any(pair in DATASETS for pair in pairwise(head))


def read_grid(data: bytes) -> Contents:
    """Return the mesh in the bytes of a legacy VTK file. Raises Damaged if they do not follow the format."""
    return _Reader(data).contents()


class _Reader:
    """Reader of a legacy VTK file: points, lists of the corners of cells, and arrays of points and cells."""

    def __init__(self, data: bytes) -> None:
        self._source = source = _Source(data)
        self._is_new = source.line()[-1:] >= ["5"]
        source.line()  # its title
        self._binary = [word.upper() for word in source.line()] == ["BINARY"]
        self._arrays: dict[str, dict[str, np.ndarray]] = {name: {} for name in DATA}

    def contents(self) -> Contents:
        source, binary = self._source, self._binary
        points, types, cells = None, None, list[list[int]]()
        is_single, is_polydata = False, False
        faces: list[list[int]] = []
        while not source.ended and ((words := source.line()) == [] or words[0].upper() not in DATA):
            key = words[0].upper() if words else ""
            if key == "METADATA":
                self._skip_metadata()
            elif key == "DATASET":
                is_polydata = words[1:2] == ["POLYDATA"] or words[-1].upper() == "POLYDATA"
            elif key == "FIELD" and len(words) == 3:
                self._field(words, {})
            elif key == "POINTS" and len(words) == 3:
                points = source.values(_count(words[1]) * 3, words[2], binary).astype(float).reshape(-1, 3)
                is_single = binary and words[2].lower() == "float"
            elif key == "CELL_TYPES" and len(words) == 2:
                types = source.values(_count(words[1]), "int", binary)
            elif key in LISTS and len(words) == 3:
                lists = (_new_lists if self._is_new else _old_lists)(source, _count(words[1]), _count(words[2]), binary)
                if key == CELLS:
                    cells = lists
                elif key == POLYGONS:
                    faces += lists
                elif key == STRIPS:
                    faces += [triangle for strip in lists for triangle in triangles_of_strip(strip)]
        if points is None:
            raise Damaged("it has no points")
        form = f"VTK {'polydata' if is_polydata else 'grid'}, {'binary' if binary else 'text'}"
        if is_polydata:
            return Contents(form, points, flat_blocks(points, faces, "polygon"), is_single=is_single)
        notes = () if source.ended else self._read_arrays(words)
        ends = np.cumsum([len(cell) for cell in cells], dtype=np.int64)
        connectivity = np.array([corner for cell in cells for corner in cell], np.int64)
        types = np.zeros(0, np.int64) if types is None else types
        of_points, of_cells = (self._arrays[name] for name in DATA)
        found = grid_contents(form, points, connectivity, ends, types, (of_points, of_cells), is_single)
        return replace(found, notes=notes)

    def _skip_metadata(self) -> None:
        while not self._source.ended and self._source.line():
            pass

    def _read_arrays(self, words: list[str]) -> tuple[str, ...]:
        """Read arrays of points and cells until an array cannot be read; return a tuple with a note about this array, empty
        if all arrays were read. words: words of the first line."""
        arrays, n = self._arrays[DATA[0]], 0
        try:
            while True:
                key = words[0].upper() if words else ""
                if key in DATA:
                    arrays, n = self._arrays[key], _count(words[1])
                elif key == "METADATA":
                    self._skip_metadata()
                elif key == "FIELD":
                    self._field(words, arrays)
                elif key in WIDTHS:
                    self._array(arrays, words[1], n, WIDTHS[key], words[2])
                elif key == "TEXTURE_COORDINATES":
                    self._array(arrays, words[1], n, _count(words[2]), words[3])
                elif key == "SCALARS":
                    self._source.line()  # the name of a colour table
                    self._array(arrays, words[1], n, _count(words[3]) if len(words) > 3 else 1, words[2])
                elif key in ("COLOR_SCALARS", "LOOKUP_TABLE"):
                    size = _count(words[2]) * (n if key == "COLOR_SCALARS" else 4)
                    self._source.values(size, "unsigned_char" if self._binary else "float", self._binary)
                elif key:
                    return (UNREAD,)
                if self._source.ended:
                    return ()
                words = self._source.line()
        except (Damaged, IndexError):
            return (UNREAD,)

    def _field(self, words: list[str], arrays: dict[str, np.ndarray]) -> None:
        for _ in range(_count(words[2])):
            while not (head := self._source.line()) or head[0] == "METADATA":
                if head:
                    self._skip_metadata()
                if self._source.ended:
                    raise Damaged("a field is truncated")
            self._array(arrays, head[0], _count(head[2]), _count(head[1]), head[3])

    def _array(self, arrays: dict[str, np.ndarray], name: str, n: int, width: int, kind: str) -> None:
        values = self._source.values(n * width, kind, self._binary)
        if width == 1:
            arrays[unquote(name)] = values


def _old_lists(source: "_Source", count: int, size: int, binary: bool) -> list[list[int]]:
    """Read `count` lists of point numbers, each stored as its length followed by its numbers, with `size` values in total
    (format before 5.0); binary: the file is binary."""
    values = source.values(size, "int", binary).tolist()
    lists, at = [], 0
    for _ in range(count):
        n = values[at] if at < size else -1
        if not 0 <= n <= size - at - 1:
            raise Damaged("a list of corners is truncated")
        lists.append(values[at + 1 : at + 1 + n])
        at += 1 + n
    return lists


def _new_lists(source: "_Source", count: int, size: int, binary: bool) -> list[list[int]]:
    """Read the lists of point numbers of format 5, stored as the start of each list and the end of the last one (`count`
    values), followed by the numbers of all lists (`size` values); binary: the file is binary."""
    parts = []
    for name, n in (("OFFSETS", count), ("CONNECTIVITY", size)):
        while not (words := source.line()) and not source.ended:
            pass  # a full line is followed by an empty one
        if len(words) != 2 or words[0].upper() != name:
            raise Damaged(f"{name} is missing or misplaced")
        parts.append(source.values(n, words[1], binary))
    ends, corners = parts
    if len(ends) and not (ends[0] == 0 and (np.diff(ends) >= 0).all() and ends[-1] == size):
        raise Damaged("the offsets of its lists are not ascending from 0 to the number of corners")
    return [part.tolist() for part in np.split(corners, ends[1:-1])] if len(ends) > 1 else []


def _count(word: str) -> int:
    if not word.isdecimal() or len(word) > 18:
        raise Damaged("a count is missing or invalid")
    return int(word)


class _Source:
    """Sequential reader of the lines and values of a legacy VTK file."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    @property
    def ended(self) -> bool:
        """True if no data are left."""
        return self._at >= len(self._data)

    def line(self) -> list[str]:
        """Return the words of the next line; empty at the end of the file."""
        end = self._data.find(b"\n", self._at)
        end = len(self._data) if end < 0 else end
        line, self._at = self._data[self._at : end], end + 1
        return text_of(line).split()

    def values(self, count: int, kind: str, binary: bool) -> np.ndarray:
        """Return the next `count` values; kind: VTK data type, such as "float"; binary: the values are binary and
        big-endian, not text."""
        if kind.lower() not in TYPES:
            raise Damaged("its points or lists have an unknown VTK data type")
        found = np.dtype(">" + TYPES[kind.lower()])
        if binary:
            if count * found.itemsize > len(self._data) - self._at:
                raise Damaged(f"it is truncated within {count} values")
            values = np.frombuffer(self._data, found, count, self._at)
            self._at += count * found.itemsize
            if self._data[self._at : self._at + 1] == b"\n":
                self._at += 1
            return values.astype(found.newbyteorder("="))
        words: list[str] = []
        while len(words) < count and self._at < len(self._data):
            words += self.line()
        if len(words) != count:
            raise Damaged(f"one of its lists does not have the {count} values that are stated")
        return floats(words, "its points") if found.kind == "f" else integers(words, "its lists")
