"""Reader of Gmsh's mesh formats 2, 4.0 and 4.1, text and binary: nodes, elements and physical groups.

Other sections, such as data and periodic links, are skipped. Source: Gmsh reference manual, file formats: MSH 4.1, and legacy
formats 4.0 and 2.
"""

import re
from collections.abc import Callable, Iterator

import numpy as np

from pellucid.geometry.files.contents import Block, Contents, Damaged
from pellucid.geometry.files.gmsh_elements import DIMENSIONS, KINDS, Elements, corners_of, once, without_lone_vertices
from pellucid.geometry.files.words import floats, integers, text_of

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
