"""Words and numbers of text files."""

import codecs
import re
from collections.abc import Sequence

import numpy as np

from pellucid.geometry.files.contents import Damaged

MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
"""Encodings by the byte order marks with which texts begin."""
_LIKE_A_NUMBER = re.compile(r"[0-9.,+\-dDeE]{0,30}[0-9][0-9.,+\-dDeE]{0,30}")


def as_utf8(data: bytes) -> bytes:
    """Return UTF-16 text as UTF-8, other bytes as they are; a byte order mark is left out."""
    mark = next((mark for mark in MARKS if data.startswith(mark)), b"")
    encoding = MARKS.get(mark, "utf-8")
    if not mark and len(data) > 3:  # UTF-16 without its mark: every second byte of letters is 0
        encoding = "utf-16-be" if not any(data[:64:2]) else "utf-16-le" if not any(data[1:64:2]) else ""
        encoding = encoding if any(data[:64]) else ""
    if encoding in ("utf-8", ""):
        return data[len(mark) :]
    try:
        return data[len(mark) :].decode(encoding).removeprefix("\ufeff").encode()
    except UnicodeDecodeError:
        return data


def text_of(data: bytes) -> str:
    """The text of a file: UTF-8, UTF-16 with its mark, or else what Windows writes in western Europe."""
    data = as_utf8(data)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


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
        word, remedy = _not_a_number(words)
        raise Damaged(f"line {line} has {word} where a number belongs", remedy) from None


def floats(words: Sequence[str], what: str) -> np.ndarray:
    """Many numbers at once. Raises Damaged."""
    try:
        return np.array(words, dtype=float)
    except ValueError:
        word, remedy = _not_a_number(words)
        raise Damaged(f"{word} stands where a number belongs, among {what}", remedy) from None


def _not_a_number(words: Sequence[str]) -> tuple[str, str]:
    """Return the first word that is no number, for a message, and a remedy where it has a decimal comma.

    Only a word of digits and signs is quoted: a wrong path must not show what is in a file that is no mesh.
    """
    for word in words:
        if not _is_number(word):
            if not _LIKE_A_NUMBER.fullmatch(word):
                break
            if _is_number(word.replace(",", ".", 1)):
                return f"`{word}`, with a decimal comma,", "write the numbers of the file with decimal points"
            return f"`{word}`", ""
    return "a word", ""


def _is_number(word: str) -> bool:
    try:
        float(word.lower().replace("d", "e"))
    except ValueError:
        return False
    return True


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
