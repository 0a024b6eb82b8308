"""Reader of OFF, the object file format of Geomview: vertices and faces in text; colours, normals and texture are ignored."""

import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pellucid.geometry.files.contents import Block, Contents, Damaged, flat_blocks
from pellucid.geometry.files.words import numbers, text_of, whole

HEADER = re.compile(r"(?:(ST)?(C)?(N)?(4)?(n)?OFF|off)(?![A-Za-z])")
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
    lines = _lines(text_of(data))
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
    flat = flat_blocks(points, [face for face in faces if len(face) > 2])
    return Contents("OFF, text", points, (*flat, *_small_blocks(faces)))


def _lines(text: str) -> list[_Line]:
    """Return the lines that are neither blank nor a comment, each as a list of words without its comment."""
    split = ((number, line.split("#", 1)[0].split()) for number, line in enumerate(text.splitlines(), 1))
    return [_Line(number, words) for number, words in split if words]


def _read_header(lines: list[_Line]) -> bool:
    """Remove the word that names the format from the start of the lines, if there is one; return True if points have a
    fourth coordinate."""
    found = HEADER.match(lines[0].words[0]) if lines else None
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


def _small_blocks(faces: list[list[int]]) -> Iterator[Block]:
    for count, kind in SMALL.items():
        some = [face for face in faces if len(face) == count]
        if some:
            yield Block(kind, np.array(some, np.int64))
