"""Parsing of words and numbers in text files."""

import codecs
import re
from collections.abc import Sequence

import numpy as np

from pellucid.geometry.files.contents import Damaged

MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
"""Encodings of a text, by the byte order mark at its start."""
_LIKE_A_NUMBER = re.compile(r"[0-9.,+\-dDeE]{0,30}[0-9][0-9.,+\-dDeE]{0,30}")


def as_utf8(data: bytes) -> bytes:
    """Return UTF-16 text as UTF-8, and other bytes unchanged, without a byte order mark."""
    mark = next((mark for mark in MARKS if data.startswith(mark)), b"")
    encoding = MARKS.get(mark, "utf-8")
    if not mark and len(data) > 3:  # UTF-16 without byte order mark: every second byte of letters is 0
        encoding = "utf-16-be" if not any(data[:64:2]) else "utf-16-le" if not any(data[1:64:2]) else ""
        encoding = encoding if any(data[:64]) else ""
    if encoding in ("utf-8", ""):
        return data[len(mark) :]
    try:
        return data[len(mark) :].decode(encoding).removeprefix("\ufeff").encode()
    except UnicodeDecodeError:
        return data


def text_of(data: bytes) -> str:
    """Decode the text of a file: UTF-8, UTF-16 with byte order mark, or else Windows-1252."""
    data = as_utf8(data)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def numbers(words: Sequence[str], line: int, count: int | None = None) -> list[float]:
    """Return the numbers of a line, which may have Fortran exponents (1.0D0). line: line number for messages. Raises
    Damaged if a word is not a number, or if there are fewer than `count` words."""
    if count is not None and len(words) < count:
        raise Damaged(f"line {line} has {len(words)} numbers instead of {count}")
    try:
        return [float(word) for word in words]
    except ValueError:
        pass
    try:
        return [float(word.lower().replace("d", "e")) for word in words]
    except ValueError:
        word, remedy = _not_a_number(words)
        raise Damaged(f"line {line} has {word} instead of a number", remedy) from None


def floats(words: Sequence[str], what: str) -> np.ndarray:
    """Return many words as an array of numbers. Raises Damaged if a word is not a number; what: plural noun for the words
    in the message."""
    try:
        return np.array(words, dtype=float)
    except ValueError:
        word, remedy = _not_a_number(words)
        raise Damaged(f"{what} contain {word} instead of a number", remedy) from None


def _not_a_number(words: Sequence[str]) -> tuple[str, str]:
    """Return the first of the words that is not a number, for a message, and a remedy if this word has a decimal comma.

    Only a word of digits and signs is quoted, so that a wrong path does not reveal the contents of a file that is not a
    mesh.
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
    """Return many words as an array of whole numbers. Raises Damaged if a word is not a whole number; what: plural noun for
    the words in the message."""
    try:
        return np.array(words, dtype=np.int64)
    except (ValueError, OverflowError):
        raise Damaged(f"{what} contain a word that is not a whole number") from None


def whole(word: str, line: int) -> int:
    """Return a word as a whole number. Raises Damaged if the word is not a whole number; line: line number for the message."""
    try:
        found = int(word)
    except ValueError:
        raise Damaged(f"line {line} has a word instead of a whole number") from None
    if abs(found) >= 2**62:
        raise Damaged(f"line {line} has a number that is too large for a count or an index")
    return found
