"""Reader of Wavefront OBJ files: vertices and faces; texture, normals, colours, groups and materials are ignored."""

import numpy as np

from pellucid.geometry.files.contents import Contents, Damaged, flat_blocks
from pellucid.geometry.files.words import numbers, text_of, whole

FREE_FORM = {"curv", "surf", "cstype"}


def read_obj(data: bytes) -> Contents:
    """Return the mesh in the bytes of an OBJ file. Raises Damaged if they do not follow the format."""
    points: list[list[float]] = []
    faces: list[list[int]] = []
    for line_number, line in _lines(text_of(data)):
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        if words[0] == "v":
            points.append(numbers(words[1:4], line_number, 3))  # colours or a weight may follow
        elif words[0] in ("f", "fo"):
            if len(words) < 4:
                raise Damaged(f"the face in line {line_number} has {len(words) - 1} corners, but at least 3 are needed")
            faces.append([_place(word, line_number, len(points)) for word in words[1:]])
        elif words[0] in FREE_FORM:
            raise Damaged(f"line {line_number} has a free-form curve or surface: write it as triangles or quadrilaterals")
    places = np.array(points, float).reshape(-1, 3)
    return Contents("OBJ, text", places, flat_blocks(places, faces))


def _place(word: str, line: int, so_far: int) -> int:
    """Return the vertex number of a corner of a face, from 0; the formats of `word` are `7`, `7/1`, `7//3` and `7/1/3`, and
    -1 is the latest vertex. line: line number for messages; so_far: number of vertices defined so far."""
    number = whole(word.split("/", 1)[0], line)
    if number == 0 or -number > so_far:
        raise Damaged(f"the face in line {line} has an invalid vertex number; vertices count from 1, and -1 is the latest one")
    return number - 1 if number > 0 else so_far + number


def _lines(text: str) -> list[tuple[int, str]]:
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
