"""STL, text and binary. Every triangle repeats its corners."""

import numpy as np

from pellucid.geometry.files.contents import Block, Contents, Damaged
from pellucid.geometry.files.words import numbers, text_of

BEGIN, BYTE_ORDER_MARK = 100, b"\xef\xbb\xbf"
HEADER = 84  # bytes: a text and the number of facets
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(data: bytes) -> Contents:
    """What is in an STL file. Raises Damaged."""
    count = int.from_bytes(data[80:HEADER], "little") if len(data) >= HEADER else -1
    begins_as_text = data[:BEGIN].lower().removeprefix(BYTE_ORDER_MARK).lstrip().startswith(b"solid")
    if begins_as_text and len(data) != HEADER + count * FACET.itemsize and (b"vertex" in data.lower() or data.isascii()):
        return _text(text_of(data))
    if count < 0:
        raise Damaged("it is neither text that begins with `solid` nor as long as the header of a binary file")
    there = (len(data) - HEADER) // FACET.itemsize
    if count > there:
        raise Damaged(f"its header counts {count} facets, and {there} are there: it is cut off, or no STL file")
    corners = np.frombuffer(data, FACET, count, HEADER)["corners"].astype(float)
    left = len(data) - HEADER - count * FACET.itemsize
    return _contents("STL, binary", corners, (f"{left} bytes after its last facet were not read",) if left else ())


def _text(text: str) -> Contents:
    """Facets by their words: lines may break anywhere, and `end loop` is as good as `endloop`."""
    corners: list[list[float]] = []
    start, line_number, finished = 0, 0, False
    for line_number, line in enumerate(text.splitlines(), 1):
        words = line.lower().split()
        if not words or words[0] == "solid":
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
        raise Damaged(f"it breaks off within a facet, in line {line_number}")
    if not corners:
        raise Damaged("it holds no facet")
    notes = () if finished else ("it has no `endsolid`: it may be cut off",)
    return _contents("STL, text", np.array(corners).reshape(-1, 3, 3), notes)


def _contents(form: str, corners: np.ndarray, notes: tuple[str, ...]) -> Contents:
    triangles = Block("triangle", np.arange(3 * len(corners)).reshape(-1, 3))
    return Contents(form, corners.reshape(-1, 3), (triangles,), notes=notes)
