"""Reader of PLY, text and binary: vertices, and faces with any number of corners; other elements and properties are ignored."""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.files.contents import (
    Block,
    Contents,
    Damaged,
    flat_blocks,
    floats,
    integers,
    text_of,
    triangles_of_fan,
    triangles_of_strip,
)

TYPES = {"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"}
for _letter, _prefix in (("i", ""), ("u", "u")):
    TYPES |= {f"{_prefix}{name}": f"{_letter}{size}" for name, size in (("char", 1), ("short", 2), ("int", 4))}
    TYPES |= {f"{_prefix}int{8 * size}": f"{_letter}{size}" for size in (1, 2, 4, 8)}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CORNERS = ("vertex_indices", "vertex_index")
STRIPS, FANS = ("tristrips", "tristrip", "strips", "strip"), ("trifans", "trifan")


Column = np.ndarray | list[np.ndarray]
"""Values of a property of an element, shape (rows, values); a list with the values of each row if rows have different
lengths."""


class _Property(NamedTuple):
    """A property of the rows of an element in a PLY file, as the header declares it: a number, or a list of numbers."""

    name: str
    type: str
    """NumPy type of the value, or of the items of a list."""
    length: str = ""
    """Type of the length of a list; empty for a single value."""


class _Element(NamedTuple):
    """An element (table) in a PLY file, such as `vertex` or `face`, as the header declares it: name, number of rows,
    properties of each row."""

    name: str  # such as "vertex"
    rows: int  # number of rows of the table
    properties: list[_Property]  # the columns of the table


def read_ply(data: bytes) -> Contents:
    """Return the mesh in the bytes of a PLY file. Raises Damaged if they do not follow the format."""
    header = data[: data.find(b"end_header")]
    if b"format ascii" in header and b"\n" not in header:  # lines end with only a carriage return
        data = data.replace(b"\r", b"\n")
    order, elements, start = _header(data)
    source: _Words | _Bytes = _Bytes(data, start, order) if order else _Words(text_of(data[start:]).split())
    columns = {element.name: _columns(source, element) for element in elements}
    vertices, faces = columns.get("vertex", {}), columns.get("face", {})
    if not {"x", "y", "z"} <= vertices.keys():
        raise Damaged("its vertices have no x, y and z")
    points = np.stack([np.asarray(vertices[axis], float).reshape(-1) for axis in "xyz"], axis=1)
    corners = _lists(faces)
    if isinstance(corners, np.ndarray) and corners.ndim == 2 and corners.shape[1] in (3, 4) and len(corners):
        blocks: tuple[Block, ...] = (Block("triangle" if corners.shape[1] == 3 else "quad", corners.astype(np.int64)),)
    else:
        blocks = flat_blocks(points, [[int(corner) for corner in np.atleast_1d(face)] for face in corners])
    more: list[list[int]] = []
    for name, table in columns.items():
        if name in (*STRIPS, *FANS):
            for row in _lists(table):
                values = [int(corner) for corner in np.atleast_1d(row)]
                more += triangles_of_fan(values) if name in FANS else triangles_of_strip(values)
    if more:
        blocks += (Block("triangle", np.array(more, np.int64)),)
    known = {"vertex", "face", "edge", *STRIPS, *FANS}
    notes = tuple(
        f"{len(_lists(table))} rows of `{name[:40]}`, which have lists of vertices, were not read"
        for name, table in columns.items()
        if name not in known and len(_lists(table))
    )
    of_vertex = next(element for element in elements if element.name == "vertex").properties
    is_single = bool(order) and any(one.name == "x" and one.type == "f4" for one in of_vertex)
    return Contents(f"PLY, {'binary' if order else 'text'}", points, blocks, notes=notes, is_single=is_single)


def _lists(table: dict[str, Column]) -> Column:
    return next((table[name] for name in CORNERS if name in table), [])


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """Return the byte order of a PLY file (empty for text), its elements (tables such as `vertex` and `face`), and the
    position in the file where their data starts."""
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise Damaged("it has no header from `ply` to `end_header`")
    start = data.find(b"\n", end) + 1 or len(data)
    order: str | None = None
    elements: list[_Element] = []
    for words in map(str.split, text_of(data[:end]).splitlines()):
        match words:
            case ["format", name, *_] if name in ORDERS:
                order = ORDERS[name]
            case ["element", name, count] if count.isdecimal():
                elements.append(_Element(name, int(count), []))
            case ["property", "list", count, kind, name] if elements and count in TYPES and kind in TYPES:
                elements[-1].properties.append(_Property(name, TYPES[kind], TYPES[count]))
            case ["property", kind, name] if elements and kind in TYPES:
                elements[-1].properties.append(_Property(name, TYPES[kind]))
            case ["ply"] | ["comment", *_] | ["obj_info", *_] | []:
                pass
            case [word, *_]:
                what = word if word in ("format", "element", "property") else "line"
                raise Damaged(f"its header has a {what} that is not part of the PLY format")
    if order is None:
        raise Damaged("its header does not define the format (text or binary)")
    return order, elements, start


class _Words:
    """Sequential reader of the values of a text file."""

    def __init__(self, words: list[str]) -> None:
        self._words, self.at = words, 0

    @property
    def left(self) -> int:
        """Upper bound of the number of values that have not been read."""
        return len(self._words) - self.at

    def take(self, kind: str, count: int) -> np.ndarray:
        """Return the next `count` values; kind: data type, such as "f4" or "i4"."""
        if not 0 <= count <= self.left:
            raise Damaged("it ends before its last element, or has a list of negative length")
        words = self._words[self.at : self.at + count]
        self.at += count
        return floats(words, "its values") if kind[0] == "f" else integers(words, "its whole numbers")

    def table(self, layout: list[tuple[str, int]], rows: int) -> tuple[list[np.ndarray], int] | None:
        """Return the columns of a table, shape (rows, values) each, and the position after its data; None if the rows differ
        in the number or type of their values. layout: data type and number of values of each column."""
        widths = [width for _, width in layout]
        if rows * sum(widths) > self.left:
            return None
        end = self.at + rows * sum(widths)
        words = np.array(self._words[self.at : end], object).reshape(rows, sum(widths))
        parts = np.split(words, np.cumsum(widths)[:-1], axis=1)
        try:
            kinds = [float if kind[0] == "f" else np.int64 for kind, _ in layout]
            return [part.astype(kind) for part, kind in zip(parts, kinds, strict=True)], end
        except (ValueError, OverflowError):
            return None  # rows of different lengths, or damaged: reading row by row decides


class _Bytes:
    """Sequential reader of the values of a binary file."""

    def __init__(self, data: bytes, start: int, order: str) -> None:
        self._data, self.at, self._order = data, start, order

    @property
    def left(self) -> int:
        """Upper bound of the number of values that have not been read."""
        return len(self._data) - self.at

    def take(self, kind: str, count: int) -> np.ndarray:
        found = np.dtype(self._order + kind)
        if not 0 <= count * found.itemsize <= self.left:
            raise Damaged("it ends before its last element, or has a list of negative length")
        values = np.frombuffer(self._data, found, count, self.at)
        self.at += count * found.itemsize
        return values

    def table(self, layout: list[tuple[str, int]], rows: int) -> tuple[list[np.ndarray], int] | None:
        row = np.dtype([(f"f{place}", self._order + kind, (width,)) for place, (kind, width) in enumerate(layout)])
        if rows * row.itemsize > self.left:
            return None
        table = np.frombuffer(self._data, row, rows, self.at)
        return [table[f"f{place}"] for place in range(len(layout))], self.at + rows * row.itemsize


def _columns(source: _Words | _Bytes, element: _Element) -> dict[str, Column]:
    """Return the values of the properties of an element (a table of the file), by name of the property.

    The values are read in one operation if all lists have the length of the list in the first row.
    """
    if element.rows > source.left:
        raise Damaged(f"its header states {element.rows} of `{element.name}`, which exceeds the size of the file")
    if not element.rows:
        return {one.name: [] for one in element.properties}
    first = [_next(source, one) for one in element.properties]
    layout = [
        part
        for one, values in zip(element.properties, first, strict=True)
        for part in ([(one.length, 1)] if one.length else []) + [(one.type, len(values))]
    ]
    rest = element.rows - 1
    if (table := source.table(layout, rest)) is not None:
        (columns, end), found, at, even = table, dict[str, Column](), 0, True
        for one, values in zip(element.properties, first, strict=True):
            even &= not one.length or bool((columns[at] == len(values)).all())
            at += bool(one.length)
            found[one.name] = np.concatenate([values[None], columns[at]])
            at += 1
        if even:
            source.at = end
            return found
    lists: dict[str, list[np.ndarray]] = {one.name: [values] for one, values in zip(element.properties, first, strict=True)}
    for _ in range(rest):
        for one in element.properties:
            lists[one.name].append(_next(source, one))
    return dict(lists)


def _next(source: _Words | _Bytes, one: _Property) -> np.ndarray:
    return source.take(one.type, int(source.take(one.length, 1)[0]) if one.length else 1)
