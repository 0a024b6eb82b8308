"""Readers of the surface formats OBJ, OFF and STL: vertices and faces; colours, normals and texture are ignored."""

import re
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pellucid.geometry.files.contents import Block, Contents, Damaged, as_utf8, flat_blocks, numbers, text_of, whole

FREE_FORM = {"curv", "surf", "cstype"}


def read_obj(data: bytes) -> Contents:
    """Return the mesh in the bytes of an OBJ file. Raises Damaged if they do not follow the format."""
    points: list[list[float]] = []
    faces: list[list[int]] = []
    for line_number, line in _joined_lines(text_of(data)):
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        if words[0] == "v":
            points.append(numbers(words[1:4], line_number, 3))  # colours or a weight may follow
        elif words[0] in ("f", "fo"):
            if len(words) < 4:
                raise Damaged(f"the face in line {line_number} has {len(words) - 1} corners, but at least 3 are needed")
            faces.append([_vertex(word, line_number, len(points)) for word in words[1:]])
        elif words[0] in FREE_FORM:
            raise Damaged(f"line {line_number} has a free-form curve or surface: write it as triangles or quadrilaterals")
    places = np.array(points, float).reshape(-1, 3)
    return Contents("OBJ, text", places, flat_blocks(places, faces))


def _vertex(word: str, line: int, so_far: int) -> int:
    """Return the vertex number of a corner of a face, from 0; the formats of `word` are `7`, `7/1`, `7//3` and `7/1/3`, and
    -1 is the latest vertex. line: line number for messages; so_far: number of vertices defined so far."""
    number = whole(word.split("/", 1)[0], line)
    if number == 0 or -number > so_far:
        raise Damaged(f"the face in line {line} has an invalid vertex number; vertices count from 1, and -1 is the latest one")
    return number - 1 if number > 0 else so_far + number


def _joined_lines(text: str) -> list[tuple[int, str]]:
    """Return the number and text of each line; a line that ends with a backslash is joined with the next one."""
    found: list[tuple[int, str]] = []
    begun = ""
    for number, line in enumerate(text.splitlines(), 1):
        if line.endswith("\\"):
            begun += line[:-1] + " "
        else:
            found.append((number, begun + line))
            begun = ""
    return [*found, *([(len(found) + 1, begun)] if begun else [])]


FORMAT_WORD = re.compile(r"(?:(ST)?(C)?(N)?(4)?(n)?OFF|off)(?![A-Za-z])")
"""First word of the file, which may be missing: prefixes for texture, colours and normals of vertices, fourth coordinates,
and another number of dimensions."""
SMALL = {1: "vertex", 2: "line"}
"""Kinds of faces with fewer corners than a triangle."""


class _Line(NamedTuple):
    """A line of an OFF file that is neither blank nor a comment."""

    number: int  # line number in the file, counted from 1
    words: list[str]  # words of the line, without a comment


def read_off(data: bytes) -> Contents:
    """Return the mesh in the bytes of an OFF file. Raises Damaged if they do not follow the format."""
    split = ((number, line.split("#", 1)[0].split()) for number, line in enumerate(text_of(data).splitlines(), 1))
    lines = [_Line(number, words) for number, words in split if words]
    is_homogeneous = _read_header(lines)
    n_vertices, n_faces = _read_counts(lines)
    missing = n_vertices + n_faces - len(lines)
    if missing > 0:
        text = f"it has {len(lines)} lines after its counts, but {n_vertices} vertices and {n_faces} faces are expected"
        raise Damaged(text, "write the file again with one vertex or face in each line")
    if missing < 0:
        line = lines[n_vertices + n_faces].number
        raise Damaged(f"line {line} is after the last of the {n_vertices} vertices and {n_faces} faces that the header states")
    columns = 4 if is_homogeneous else 3
    rows = [numbers(line.words[:columns], line.number, columns) for line in lines[:n_vertices]]
    points = _divided(np.array(rows, float).reshape(-1, columns))
    faces = [_corners(line) for line in lines[n_vertices:]]
    blocks = flat_blocks(points, [face for face in faces if len(face) > 2])
    for count, kind in SMALL.items():
        if some := [face for face in faces if len(face) == count]:
            blocks = (*blocks, Block(kind, np.array(some, np.int64)))
    return Contents("OFF, text", points, blocks)


def _read_header(lines: list[_Line]) -> bool:
    """Remove the word that names the format from the start of the lines, if there is one; return True if points have a
    fourth coordinate."""
    found = FORMAT_WORD.match(lines[0].words[0]) if lines else None
    if found is None:
        return False
    line = lines[0]
    rest = line.words[0][found.end() :]  # some writers leave no space before the counts
    words = [*([rest] if rest else []), *line.words[1:]]
    lines[:1] = [_Line(line.number, words)] if words else []
    if found[5]:
        raise Damaged("its number of dimensions is not 3 (nOFF)", "save it as OFF, with three coordinates for each vertex")
    if words and words[0].upper() == "BINARY":
        raise Damaged("it is a binary OFF file", "save it as text")
    return bool(found[4])


def _read_counts(lines: list[_Line]) -> tuple[int, int]:
    """Remove the counts, in one or more lines, from the start of the lines; return the numbers of vertices and faces. The
    number of edges may be missing."""
    words: list[str] = []
    while lines and len(words) < 2:  # each count may be in a separate line
        number, more = lines.pop(0)
        words += more
    if len(words) < 2:
        raise Damaged("it ends before its counts of vertices and faces")
    if len(words) == 2 and lines and len(lines[0].words) == 1:
        lines.pop(0)
    n_vertices, n_faces = whole(words[0], number), whole(words[1], number)
    if min(n_vertices, n_faces) < 0 or len(words) > 3:
        raise Damaged(f"line {number} must have the counts of vertices, faces and edges, three non-negative whole numbers")
    return n_vertices, n_faces


def _divided(points: np.ndarray) -> np.ndarray:
    """Return the first three coordinates of points, shape (n, 3), divided by the fourth (homogeneous) coordinate if there is
    one."""
    if points.shape[1] == 3:
        return points
    if (points[:, 3] == 0.0).any():
        raise Damaged(
            f"vertex {int(np.argmin(points[:, 3] != 0.0))} (counted from 0) has a fourth coordinate of 0, which is not allowed"
        )
    return points[:, :3] / points[:, 3:]


def _corners(line: _Line) -> list[int]:
    """Return the vertex numbers of a face, counted from 0, from the words of its line; the colour that may follow in the
    file is ignored."""
    count = whole(line.words[0], line.number)
    corners = [whole(word, line.number) for word in line.words[1 : count + 1]] if count > 0 else []
    if count < 1 or len(corners) < count:
        raise Damaged(f"the face in line {line.number} has {len(corners)} corners instead of {count}")
    return corners


BEGIN_OF_STL = 1000  # number of bytes that identify a text file
FACET_OF_TEXT = re.compile(rb"^\s*facet\s+normal\b", re.IGNORECASE | re.MULTILINE)
UNCOUNTED = (0, 2**32 - 1)
HEADER_OF_STL = 84  # bytes: a text and the number of facets
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(data: bytes) -> Contents:
    """Return the mesh in the bytes of an STL file. Raises Damaged if they do not follow the format."""
    count = int.from_bytes(data[80:HEADER_OF_STL], "little") if len(data) >= HEADER_OF_STL else -1
    there, left = divmod(len(data) - HEADER_OF_STL, FACET.itemsize)
    if not (count == there and left == 0):
        text = as_utf8(data)
        if is_text(text):
            return _stl_text(text_of(text))
    if count < 0:
        raise Damaged("it is not text with `facet` and `vertex` lines, and shorter than the header of a binary file")
    notes: tuple[str, ...] = ()
    if count in UNCOUNTED and there and not left:  # written before the number was known
        notes = (f"its header states {count} facets, but {there} follow; all of these were read",)
        count = there
    if count > there:
        raise Damaged(f"its header states {count} facets, but {there} follow: it is truncated, or not an STL file")
    corners = np.frombuffer(data, FACET, count, HEADER_OF_STL)["corners"].astype(float)
    behind = len(data) - HEADER_OF_STL - count * FACET.itemsize
    if behind:
        facets = f", as long as {there - count} facets," if not left else ""
        notes = (f"{behind} bytes after the {count} facets that its header states{facets} were not read",)
    return replace(_stl_contents("STL, binary", corners, notes), is_single=True)


def is_text(data: bytes) -> bool:
    """Return True if bytes are a text STL file, which starts with `solid` or `facet`, possibly after comments."""
    for line in data[:BEGIN_OF_STL].lower().splitlines():
        words = line.split()
        if not words or words[0][:1] in (b"#", b";", b"%") or words[0].startswith(b"//"):
            continue
        if words[0] in (b"solid", b"facet"):
            return b"vertex" in data.lower() or data.isascii()
        break
    return data[:BEGIN_OF_STL].isascii() and b"\0" not in data[:BEGIN_OF_STL] and FACET_OF_TEXT.search(data) is not None


def _stl_text(text: str) -> Contents:
    """Return the mesh of a text STL file. Facets are read word by word, as lines may break anywhere; `end loop` is accepted
    as `endloop`."""
    corners: list[list[float]] = []
    start, line_number, finished, begun = 0, 0, False, False
    for line_number, line in enumerate(text.splitlines(), 1):
        words = line.lower().split()
        begun = begun or (bool(words) and words[0] in ("solid", "facet"))
        if not words or words[0] == "solid" or not begun or words[0][0] in "#;":
            continue
        if words[0] == "vertex" and len(words) == 4:
            corners.append(numbers(words[1:], line_number))
            continue
        place = 0
        while place < len(words):
            word = words[place]
            if word == "end" and place + 1 < len(words):
                place += 1
                word += words[place]
            if word == "vertex":
                corners.append(numbers(words[place + 1 : place + 4], line_number, 3))
                place += 3
            elif word == "endloop":
                if len(corners) - start != 3:
                    raise Damaged(f"the facet that ends in line {line_number} has {len(corners) - start} corners, not 3")
                start = len(corners)
            elif word == "endsolid":
                finished = True
                break
            place += 1
    if len(corners) != start:
        raise Damaged(f"it ends within a facet, in line {line_number}")
    if not corners:
        raise Damaged("it contains no facets")
    notes = () if finished else ("the final `endsolid` is missing; the file may be truncated",)
    return _stl_contents("STL, text", np.array(corners).reshape(-1, 3, 3), notes)


def _stl_contents(form: str, corners: np.ndarray, notes: tuple[str, ...]) -> Contents:
    triangles = Block("triangle", np.arange(3 * len(corners)).reshape(-1, 3))
    return Contents(form, corners.reshape(-1, 3), (triangles,), notes=notes)
