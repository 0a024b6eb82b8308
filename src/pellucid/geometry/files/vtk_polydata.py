"""Legacy VTK files of polygons (`DATASET POLYDATA`), text and binary, versions up to 5.1; their data are left out."""

from itertools import pairwise

import numpy as np

from pellucid.geometry.files.contents import Contents, Damaged, flat_blocks
from pellucid.geometry.files.strips import triangles_of_strip
from pellucid.geometry.files.words import floats, integers, text_of

TYPES = {"float": "f4", "double": "f8", "vtktypeint64": "i8", "vtkidtype": "i8"}
for _name, _size in (("char", 1), ("short", 2), ("int", 4), ("long", 8)):
    TYPES |= {_name: f"i{_size}", f"unsigned_{_name}": f"u{_size}"}
POLYGONS, STRIPS = "POLYGONS", "TRIANGLE_STRIPS"
LISTS = (POLYGONS, STRIPS, "LINES", "VERTICES")
ENDS = ("POINT_DATA", "CELL_DATA")


def is_polydata(data: bytes) -> bool:
    """Whether a file begins as one of this kind."""
    head = data.upper().split()
    return head[:4] == [b"#", b"VTK", b"DATAFILE", b"VERSION"] and (b"DATASET", b"POLYDATA") in pairwise(head)


def read_polydata(data: bytes) -> Contents:
    """What is in such a file. Raises Damaged."""
    source = _Source(data)
    is_new = source.line()[-1:] >= ["5"]
    source.line()  # its title
    binary = [word.upper() for word in source.line()] == ["BINARY"]
    points: np.ndarray | None = None
    is_single = False
    faces: list[list[int]] = []
    while (words := source.line()) is not None and (not words or words[0].upper() not in ENDS):
        key = words[0].upper() if words else ""
        if key == "METADATA":
            while source.line():
                pass
        elif key == "POINTS" and len(words) == 3:
            points = source.values(_count(words[1]) * 3, words[2], binary).astype(float).reshape(-1, 3)
            is_single = binary and words[2].lower() == "float"
        elif key in LISTS and len(words) == 3:
            lists = (_new_lists if is_new else _old_lists)(source, _count(words[1]), _count(words[2]), binary)
            if key == POLYGONS:
                faces += lists
            elif key == STRIPS:
                faces += [triangle for strip in lists for triangle in triangles_of_strip(strip)]
    if points is None:
        raise Damaged("it has no points")
    form = f"VTK polydata, {'binary' if binary else 'text'}"
    return Contents(form, points, flat_blocks(points, faces, "polygon"), is_single=is_single)


def _old_lists(source: "_Source", count: int, size: int, binary: bool) -> list[list[int]]:
    """Each list as its length and its numbers, `size` of all in all."""
    values = source.values(size, "int", binary).tolist()
    lists, at = [], 0
    for _ in range(count):
        n = values[at] if at < size else -1
        if not 0 <= n <= size - at - 1:
            raise Damaged("a list of corners breaks off")
        lists.append(values[at + 1 : at + 1 + n])
        at += 1 + n
    return lists


def _new_lists(source: "_Source", count: int, size: int, binary: bool) -> list[list[int]]:
    """Where each list begins, one more than there are lists, then all numbers."""
    parts = []
    for name, n in (("OFFSETS", count), ("CONNECTIVITY", size)):
        words = source.line()
        if not words or len(words) != 2 or words[0].upper() != name:
            raise Damaged(f"{name} does not stand where it belongs")
        parts.append(source.values(n, words[1], binary))
    ends, corners = parts
    if len(ends) and not (ends[0] == 0 and (np.diff(ends) >= 0).all() and ends[-1] == size):
        raise Damaged("the places where its lists begin do not ascend from 0 to their end")
    return [part.tolist() for part in np.split(corners, ends[1:-1])] if len(ends) > 1 else []


def _count(word: str) -> int:
    if not word.isdecimal() or len(word) > 18:
        raise Damaged("something else stands where a count belongs")
    return int(word)


class _Source:
    """Lines and values of a file, one after the other."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def line(self) -> list[str]:
        """The words of the next line; at the end of the file those of the data behind the mesh."""
        if self._at >= len(self._data):
            return [ENDS[0]]
        end = self._data.find(b"\n", self._at)
        end = len(self._data) if end < 0 else end
        line, self._at = self._data[self._at : end], end + 1
        return text_of(line).split()

    def values(self, count: int, kind: str, binary: bool) -> np.ndarray:
        """The next `count` values; binary ones have their highest byte first."""
        if kind.lower() not in TYPES:
            raise Damaged("its points or lists have a type of numbers that VTK has not")
        found = np.dtype(">" + TYPES[kind.lower()])
        if binary:
            if count * found.itemsize > len(self._data) - self._at:
                raise Damaged(f"it ends within {count} values")
            values = np.frombuffer(self._data, found, count, self._at)
            self._at += count * found.itemsize
            if self._data[self._at : self._at + 1] == b"\n":
                self._at += 1
            return values.astype(found.newbyteorder("="))
        words: list[str] = []
        while len(words) < count and self._at < len(self._data):
            words += self.line()
        if len(words) != count:
            raise Damaged(f"it has not the {count} values that it counts, or more in their last line")
        return floats(words, "its points") if found.kind == "f" else integers(words, "its lists")
