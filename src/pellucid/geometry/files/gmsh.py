"""Reader of Gmsh's mesh formats 1, 2, 4.0 and 4.1, text and binary: nodes, elements and physical groups.

Other sections, such as data and periodic links, are skipped. Source: Gmsh reference manual, file formats: MSH 4.1, and legacy
formats 4.0, 2 and 1.
"""

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from pellucid.geometry.files.contents import Block, Contents, Damaged, floats, integers, nodes_of_kind, text_of, with_points

_VERSIONS = ("2", "2.0", "2.1", "2.2", "4", "4.0", "4.1")
_NAME = re.compile(r'(\d+)\s+(-?\d+)\s+"(.*)"')
_SECTION = re.compile(rb"^[ \t]*\$([A-Za-z]\w*)[ \t\r]*\n", re.MULTILINE)
Layout = tuple[tuple[str, int], ...]
"""Layout of a row of data: pairs of a kind of number ("int", "size" or "float") and how many of them follow."""


def is_gmsh(data: bytes) -> bool:
    """Return True if a file starts like a Gmsh file of version 2 or later."""
    return b"$MeshFormat" in data[:1000]


def read_gmsh(data: bytes) -> Contents:
    """Return the mesh in the bytes of a Gmsh file of version 2, 4.0 or 4.1. Raises Damaged if they do not follow the format."""
    return _Reader(data).contents()


class _Reader:
    """Reader of the nodes, elements and physical groups of a Gmsh file, section by section."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._tags: list[np.ndarray] = [np.zeros(0, np.int64)]
        self._points: list[np.ndarray] = [np.zeros((0, 3))]
        self._elements: dict[int, list[Elements]] = {}
        self._groups: dict[tuple[int, int], list[int]] = {}  # of entities, by dimension and number
        self._names: dict[tuple[int, int], str] = {}
        self._version, self._binary, self._order, self._size = "", False, "<", 8

    def contents(self) -> Contents:
        at, notes = 0, []
        readers: dict[str, Callable[[_Words | _Bytes], None]] = {
            "Entities": self._entities,
            "PartitionedEntities": lambda source: self._entities(source, partitioned=True),
            "Nodes": self._nodes,
            "ParametricNodes": lambda source: self._nodes(source, parametric=True),
            "Elements": self._read_elements,
        }
        while (found := _SECTION.search(self._data, at)) is not None:
            name, at = found[1].decode(), found.end()
            if name.startswith("End"):
                continue
            start, end = at, self._end(name, at)
            if name in readers and self._version and self._binary:
                source: _Words | _Bytes = _Bytes(self._data, start, self._order, self._size, name)
                readers[name](source)
                end = self._end(name, source.at)
            elif name in readers and self._version and end >= 0:
                readers[name](_Words(self._data[start:end], name))
            if end < 0:
                if name in readers or name == "MeshFormat" or not self._elements:
                    raise Damaged(f"its section ${name} has no end: the line $End{name} is missing")
                notes.append(f"its section ${name} was not read, as the line $End{name} is missing")
                break
            if name == "MeshFormat":
                self._format(self._data[start:end])
            elif name == "PhysicalNames":
                self._physical_names(text_of(self._data[start:end]))
            at = end
        missing = [
            name for name, found in zip(("Nodes", "Elements"), (self._tags[1:], self._elements), strict=True) if not found
        ]
        if not self._version or missing:
            raise Damaged(f"its section ${missing[0] if self._version else 'MeshFormat'} is missing or empty")
        return self._assembled(notes)

    def _end(self, name: str, at: int) -> int:
        return self._data.find(b"$End" + name.encode(), at)

    def _format(self, section: bytes) -> None:
        words = section.split(maxsplit=3)
        version = words[0].decode("latin-1") if words else ""
        if version not in _VERSIONS:
            raise Damaged(
                f"its Gmsh format version {version[:8] or '(missing)'} is not supported (supported: 1, 2, 4.0 and 4.1): "
                "write it with `Mesh.MshFileVersion = 4.1`"
            )
        if len(words) < 3 or words[1] not in (b"0", b"1") or words[2] not in (b"4", b"8"):
            raise Damaged("its section $MeshFormat must have a version, 0 (text) or 1 (binary), and a data size of 4 or 8")
        self._version = "2" if version[0] == "2" else "4.1" if version == "4.1" else "4.0"
        self._binary, self._size = words[1] == b"1", int(words[2])
        if self._binary:
            one = section[section.find(b"\n") + 1 :][:4]
            if one not in (b"\x01\x00\x00\x00", b"\x00\x00\x00\x01"):
                raise Damaged("its section $MeshFormat does not have the number 1, which defines the byte order")
            self._order = "<" if one[0] else ">"

    def _physical_names(self, text: str) -> None:
        for number, line in enumerate(text.splitlines()[1:], 1):
            if not line.strip():
                continue
            if (found := _NAME.search(line)) is None:
                raise Damaged(f"line {number} of $PhysicalNames must have a dimension, a number and a quoted name")
            self._names[int(found[1]), abs(int(found[2]))] = found[3]

    def _entities(self, source: "_Words | _Bytes", partitioned: bool = False) -> None:
        """Read points, curves, surfaces and volumes of the geometry, with the numbers of their physical groups, from the
        numbers of a section (`source`); partitioned: the section is $PartitionedEntities."""
        if partitioned:
            source.take("size", 1)
            source.take("int", 2 * source.count())
        for dimension, count in enumerate([source.count() for _ in range(4)]):
            for _ in range(count):
                tag = int(source.take("int", 1)[0])
                if partitioned:
                    source.take("int", 2)
                    source.take("int", source.count())
                source.take("float", 3 if dimension == 0 and self._version == "4.1" else 6)
                self._groups[dimension, tag] = [abs(number) for number in source.take("int", source.count()).tolist()]
                if dimension:
                    source.take("int", source.count())  # bounding entities
        source.ended()

    def _nodes(self, source: "_Words | _Bytes", parametric: bool = False) -> None:
        if self._version == "2":
            n = source.counted()
            if not parametric:
                self._add_nodes(*source.rows(n, (("int", 1), ("float", 3))))
            else:
                for _ in range(n):
                    tags, places, entity = source.rows(1, (("int", 1), ("float", 3), ("int", 2)))
                    source.take("float", int(entity[0, 0]) if entity[0, 0] in (1, 2) else 0)
                    self._add_nodes(tags, places)
        else:
            blocks = source.count()
            source.take("size", 3 if self._version == "4.1" else 1)
            for _ in range(blocks):
                first, second, with_parameters = source.take("int", 3).tolist()
                n, dimension = source.count(), first if self._version == "4.1" else second
                extra = dimension if with_parameters and 0 <= dimension <= 3 else 0
                if self._version == "4.1":
                    tags = source.take("size", n)
                    (places,) = source.rows(n, (("float", 3 + extra),))
                else:
                    tags, places = source.rows(n, (("int", 1), ("float", 3 + extra)))
                self._add_nodes(tags, places)
        source.ended()

    def _add_nodes(self, tags: np.ndarray, places: np.ndarray) -> None:
        self._tags.append(tags.reshape(-1).astype(np.int64))
        self._points.append(places[:, :3])

    def _read_elements(self, source: "_Words | _Bytes") -> None:
        if self._version == "2":
            n = source.counted()
            for kind, n_tags, rows in source.elements(n):
                group, entity = (rows[:, k] if n_tags > k else np.zeros(len(rows), np.int64) for k in (0, 1))
                self._elements.setdefault(kind, []).append(Elements(rows[:, n_tags:], entity, np.abs(group)))
        else:
            blocks = source.count()
            source.take("size", 3 if self._version == "4.1" else 1)
            for _ in range(blocks):
                first, second, kind = source.take("int", 3).tolist()
                entity = second if self._version == "4.1" else first
                width = 1 + corners_of(kind)
                (rows,) = source.rows(source.count(), (("size" if self._version == "4.1" else "int", width),))
                same = np.full(len(rows), entity)
                self._elements.setdefault(kind, []).append(Elements(rows[:, 1:], same, np.zeros_like(same)))
        source.ended()

    def _assembled(self, notes: list[str]) -> Contents:
        tags, points = np.concatenate(self._tags), np.concatenate(self._points)
        order = np.argsort(tags, kind="stable")
        ascending = tags[order]
        if (twice := np.flatnonzero(np.diff(ascending) == 0)).size:
            raise Damaged(f"{twice.size} node numbers occur twice; the first is {ascending[twice[0]]}")
        none = [np.zeros(0, np.int64) for _ in self._elements]
        sets: dict[str, list[np.ndarray]] = {}
        blocks = []
        for place, (kind, parts) in enumerate(self._elements.items()):
            corners, entity, group = map(np.concatenate, zip(*parts, strict=True))
            at = np.searchsorted(ascending, corners).clip(max=len(tags) - 1) if len(tags) else corners
            if corners.size and (not len(tags) or (ascending[at] != corners).any()):
                wrong = corners[ascending[at] != corners][0] if len(tags) else corners.flat[0]
                raise Damaged(f"an element ({KINDS[kind]}) has node {wrong}, which is not one of the {len(tags)} nodes")
            elements, number = once(Elements(order[at], entity, group))
            blocks.append(Block(KINDS[kind], elements.corners))
            for name, members in self._members(kind, number, entity, group).items():
                sets.setdefault(name, list(none))[place] = members
        empty = [f"`{name[:60]}`" for name in dict.fromkeys(self._names.values()) if name not in sets]
        if empty:
            way = (
                "; format 2 with `Mesh.SaveAll` stores no groups: write format 4.1" if self._version == "2" and not sets else ""
            )
            notes.append(f"the physical groups {', '.join(empty[:8])} have no elements, so these sets do not exist{way}")
        form = f"Gmsh {self._version}, {'binary' if self._binary else 'text'}"
        return without_lone_vertices(Contents(form, points, tuple(blocks), cell_sets=sets, notes=tuple(notes)))

    def _members(self, kind: int, number: np.ndarray, entity: np.ndarray, group: np.ndarray) -> dict[str, np.ndarray]:
        """Return for each physical group its name and the indices of its elements of one kind. number, entity, group: index,
        geometric entity and (format 2) physical group of each element, shape (m,)."""
        dimension = DIMENSIONS.get(Block(KINDS[kind], number).base or "", 3)
        found: dict[str, list[np.ndarray]] = {}
        owner, which = np.unique(np.column_stack([entity, group]), axis=0, return_inverse=True)
        for k, (one, own_group) in enumerate(owner.tolist()):
            groups = [own_group] * bool(own_group) if self._version == "2" else self._groups.get((dimension, one), [])
            for name in {self._names.get((dimension, number), str(number)) for number in groups}:
                found.setdefault(name, []).append(number[which.reshape(-1) == k])
        return {name: np.unique(np.concatenate(parts)) for name, parts in found.items()}


class _Words:
    """Sequential reader of the numbers in a section of a text file; reading starts at the first number and each method
    continues after the numbers read before."""

    def __init__(self, section: bytes, name: str) -> None:
        self._words, self._name, self.at = text_of(section).split(), name, 0

    def take(self, kind: str, count: int) -> np.ndarray:
        """Return the next `count` numbers of the section; kind: "int", "size" (unsigned) or "float"."""
        return self.rows(1, ((kind, count),))[0][0]

    def count(self) -> int:
        """Read and return one number, which counts the items that follow."""
        return _sound_count(int(self.take("size", 1)[0]), self._name, len(self._words))

    counted = count
    """Read the count of items at the start of a section."""

    def rows(self, n: int, layout: Layout) -> list[np.ndarray]:
        """Read `n` rows of numbers; layout: kind (see `take`) and number of values of each group of columns. Return an array
        for each group, shape (n, values)."""
        widths = [width for _, width in layout]
        end = self.at + n * sum(widths)
        if n < 0 or min(widths) < 0 or end > len(self._words):
            raise Damaged(f"its section ${self._name} is truncated")
        words = np.array(self._words[self.at : end], object).reshape(n, sum(widths))
        self.at = end
        read = {"float": floats}
        return [
            read.get(kind, integers)(part.ravel().tolist(), f"the numbers of ${self._name}").reshape(n, -1 if n else width)
            if part.size
            else np.zeros((n, width), float if kind == "float" else np.int64)
            for (kind, width), part in zip(layout, np.split(words, np.cumsum(widths)[:-1], axis=1), strict=True)
        ]

    def elements(self, n: int) -> Iterator[tuple[int, int, np.ndarray]]:
        """Read `n` elements of format 2. Yield consecutive elements of one kind with equally many tags (labels of groups and
        entities) together: the kind, the number of tags, and an array with the tags and nodes of each element."""
        values = self.take("int", len(self._words) - self.at)
        words, starts, at = values.tolist(), [], 0
        for _ in range(n):
            if at + 3 > len(words) or words[at + 2] < 0:
                raise Damaged(f"its section ${self._name} is truncated")
            starts.append(at)
            at += 3 + words[at + 2] + corners_of(words[at + 1])
        if at > len(words):
            raise Damaged(f"its section ${self._name} is truncated")
        self.at -= len(words) - at
        where = np.array(starts, np.int64)
        heads = values[where[:, None] + np.arange(1, 3)] if n else np.zeros((0, 2), np.int64)
        ends = [*np.flatnonzero((np.diff(heads, axis=0) != 0).any(axis=1)) + 1, n]
        for start, end in zip([0, *ends], ends, strict=False):
            if end > start:
                kind, n_tags = heads[start].tolist()
                yield kind, n_tags, values[where[start:end, None] + np.arange(3, 3 + n_tags + corners_of(kind))]

    def ended(self) -> None:
        """Raise Damaged if unread numbers are left."""
        if self.at < len(self._words):
            raise Damaged(f"its section ${self._name} has more entries than its stated count")


class _Bytes:
    """Sequential reader of the numbers in a section of a binary file."""

    def __init__(self, data: bytes, start: int, order: str, size: int, name: str) -> None:
        self._data, self.at, self._name = data, start, name
        self._types = {"int": f"{order}i4", "size": f"{order}u{size}", "float": f"{order}f8"}

    def take(self, kind: str, count: int) -> np.ndarray:
        """Return the next `count` numbers of the section; kind: "int", "size" (unsigned) or "float"."""
        return self.rows(1, ((kind, count),))[0][0]

    def count(self) -> int:
        """Read and return one number, which counts the items that follow."""
        return _sound_count(int(self.take("size", 1)[0]), self._name, len(self._data))

    def counted(self) -> int:
        """Read and return the count at the start of a section of format 2, which is a line of text."""
        end = self._data.find(b"\n", self.at, self.at + 100)
        word = self._data[self.at : end].strip().decode("latin-1")
        if end < 0 or not word.isdecimal():
            raise Damaged(f"its section ${self._name} does not start with a count")
        self.at = end + 1
        return _sound_count(int(word), self._name, len(self._data))

    def rows(self, n: int, layout: Layout) -> list[np.ndarray]:
        if n < 0 or not all(0 <= width <= len(self._data) - self.at for _, width in layout):
            raise Damaged(f"its section ${self._name} is truncated")
        row = np.dtype([(f"f{k}", self._types[kind], (width,)) for k, (kind, width) in enumerate(layout)])
        if n * row.itemsize > len(self._data) - self.at:
            raise Damaged(f"its section ${self._name} is truncated")
        table = np.frombuffer(self._data, row, n, self.at) if n * row.itemsize else np.zeros(n, row)
        self.at += n * row.itemsize
        return [
            table[f"f{k}"].reshape(n, width).astype(float if kind == "float" else np.int64)
            for k, (kind, width) in enumerate(layout)
        ]

    def elements(self, n: int) -> Iterator[tuple[int, int, np.ndarray]]:
        while n > 0:
            kind, many, n_tags = self.take("int", 3).tolist()
            if many < 1 or n_tags < 0:
                raise Damaged(f"its section ${self._name} has a count below 1")
            (rows,) = self.rows(many, (("int", 1 + n_tags + corners_of(kind)),))
            n -= many
            yield kind, n_tags, rows[:, 1:]

    def ended(self) -> None:
        """Raise Damaged if unread data are left before the end of the section."""
        behind = self._data[self.at : self.at + 20].lstrip()
        if behind and not behind.startswith(b"$End"):
            raise Damaged(f"its section ${self._name} has more entries than its stated count")


def _sound_count(count: int, name: str, room: int) -> int:
    if not 0 <= count <= room:
        raise Damaged(f"its section ${name} has a count of {count}, which exceeds the size of the file")
    return count


def is_gmsh1(data: bytes) -> bool:
    """Return True if a file starts like a Gmsh file of version 1."""
    return data.lstrip()[:4] == b"$NOD"


def read_gmsh1(data: bytes) -> Contents:
    """Return the mesh in the bytes of a Gmsh file of version 1. Raises Damaged if they do not follow the format."""
    text = text_of(data)
    lines = [line.split() for line in _section_of_format_1(text, "NOD").splitlines()]
    rows = [words for words in lines if words]
    count = int(integers(rows[0][:1] if rows else [], "the count of nodes")[:1].sum())
    if len(rows) != 1 + count or any(len(words) < 4 for words in rows[1:]):
        raise Damaged(f"its node count is {count}, but {max(len(rows) - 1, 0)} lines with a number and coordinates follow")
    table = np.array([words[:4] for words in rows[1:]], object).reshape(count, 4)  # parameters on curves may follow
    points = floats(table[:, 1:].ravel().tolist(), "the nodes").reshape(count, 3)
    place = {int(name): k for k, name in enumerate(integers(table[:, 0].tolist(), "the numbers of nodes"))}
    if len(place) != count:
        raise Damaged(f"{count - len(place)} node numbers occur twice")
    return _elements_of_format_1(points, place, integers(_section_of_format_1(text, "ELM").split(), "the elements").tolist())


def _section_of_format_1(text: str, name: str) -> str:
    start, end = text.find(f"${name}"), text.find(f"$END{name}")
    if start < 0 or end < start:
        raise Damaged(f"it has no section from ${name} to $END{name}")
    return text[start + len(name) + 1 : end]


def _elements_of_format_1(points: np.ndarray, place: dict[int, int], words: list[int]) -> Contents:
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
    return nodes_of_kind(KINDS[kind])


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
