"""Words and numbers of text files."""

from collections.abc import Sequence

import numpy as np

from pellucid.geometry.files.contents import Damaged


def text_of(data: bytes) -> str:
    """The text of a file; what is no UTF-8, as in comments, becomes question marks."""
    return data.decode("utf-8-sig", errors="replace")


def numbers(words: Sequence[str], line: int, count: int | None = None) -> list[float]:
    """The numbers of a line, also with Fortran's exponents (1.0D0). Raises Damaged, also where there are not `count`."""
    if count is not None and len(words) < count:
        raise Damaged(f"line {line} has {len(words)} of {count} numbers")
    try:
        return [float(word) for word in words]
    except ValueError:
        pass
    try:
        return [float(word.lower().replace("d", "e")) for word in words]
    except ValueError:
        raise Damaged(f"line {line} has a word where a number belongs") from None


def floats(words: Sequence[str], what: str) -> np.ndarray:
    """Many numbers at once. Raises Damaged."""
    try:
        return np.array(words, dtype=float)
    except ValueError:
        raise Damaged(f"a word stands where a number belongs, among {what}") from None


def integers(words: Sequence[str], what: str) -> np.ndarray:
    """Many whole numbers at once. Raises Damaged."""
    try:
        return np.array(words, dtype=np.int64)
    except (ValueError, OverflowError):
        raise Damaged(f"something else stands where a whole number belongs, among {what}") from None


def whole(word: str, line: int) -> int:
    """A whole number. Raises Damaged."""
    try:
        found = int(word)
    except ValueError:
        raise Damaged(f"line {line} has something else where a whole number belongs") from None
    if abs(found) >= 2**62:
        raise Damaged(f"line {line} has a number that is too large for a count or a place in a list")
    return found
