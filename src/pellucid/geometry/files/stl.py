"""Reader of STL files, text and binary. Every triangle repeats its corners."""

import re
from dataclasses import replace

import numpy as np

from pellucid.geometry.files.contents import Block, Contents, Damaged
from pellucid.geometry.files.words import as_utf8, numbers, text_of

BEGIN = 1000  # number of bytes that identify a text file
FACET_OF_TEXT = re.compile(rb"^\s*facet\s+normal\b", re.IGNORECASE | re.MULTILINE)
UNCOUNTED = (0, 2**32 - 1)
HEADER = 84  # bytes: a text and the number of facets
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(data: bytes) -> Contents:
    """Return the mesh in the bytes of an STL file. Raises Damaged if they do not follow the format."""
    count = int.from_bytes(data[80:HEADER], "little") if len(data) >= HEADER else -1
    there, left = divmod(len(data) - HEADER, FACET.itemsize)
    if not (count == there and left == 0):
        text = as_utf8(data)
        if is_text(text):
            return _text(text_of(text))
    if count < 0:
        raise Damaged("it is not text with `facet` and `vertex` lines, and shorter than the header of a binary file")
    notes: tuple[str, ...] = ()
    if count in UNCOUNTED and there and not left:  # written before the number was known
        notes = (f"its header states {count} facets, but {there} follow; all of these were read",)
        count = there
    if count > there:
        raise Damaged(f"its header states {count} facets, but {there} follow: it is truncated, or not an STL file")
    corners = np.frombuffer(data, FACET, count, HEADER)["corners"].astype(float)
    behind = len(data) - HEADER - count * FACET.itemsize
    if behind:
        facets = f", as long as {there - count} facets," if not left else ""
        notes = (f"{behind} bytes after the {count} facets that its header states{facets} were not read",)
    return replace(_contents("STL, binary", corners, notes), is_single=True)


def is_text(data: bytes) -> bool:
    """Return True if bytes are a text STL file, which starts with `solid` or `facet`, possibly after comments."""
    for line in data[:BEGIN].lower().splitlines():
        words = line.split()
        if not words or words[0][:1] in (b"#", b";", b"%") or words[0].startswith(b"//"):
            continue
        if words[0] in (b"solid", b"facet"):
            return b"vertex" in data.lower() or data.isascii()
        break
    return data[:BEGIN].isascii() and b"\0" not in data[:BEGIN] and FACET_OF_TEXT.search(data) is not None


def _text(text: str) -> Contents:
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
    return _contents("STL, text", np.array(corners).reshape(-1, 3, 3), notes)


def _contents(form: str, corners: np.ndarray, notes: tuple[str, ...]) -> Contents:
    triangles = Block("triangle", np.arange(3 * len(corners)).reshape(-1, 3))
    return Contents(form, corners.reshape(-1, 3), (triangles,), notes=notes)
