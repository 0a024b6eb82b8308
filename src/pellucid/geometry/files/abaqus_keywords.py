"""Keyword lines and data lines of an Abaqus input file, also of the files that it includes."""

import re
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from pellucid.geometry.files.contents import Damaged
from pellucid.geometry.files.words import text_of
from pellucid.system.input_files import file_bytes

DEEPEST = 10  # files that include one another
_PARAMETER = re.compile(r'(?:[^,"]|"[^"]*")+')
_INPUT = re.compile(rb"^[ \t]*\*[ \t]*(?:INCLUDE|NODE|ELEMENT|NSET|ELSET)\b[^\n]*?\bINPUT[ \t]*=([^,\r\n]+)", re.I | re.M)


@dataclass(frozen=True)
class Keyword:
    """A keyword in capitals, its parameters and its data lines without comments.

    where: file and line of the keyword, for messages.
    """

    name: str
    parameters: dict[str, str]
    where: str
    lines: list[str] = field(default_factory=list)

    def words(self) -> list[list[str]]:
        """Words of each data line."""
        return [[word.strip() for word in line.split(",")] for line in self.lines]


def keywords(path: str) -> list[Keyword]:
    """Read the keywords of a file in order, with those of included files in their places. Raises Damaged."""
    found: list[Keyword] = []
    _read(Path(path), Path(path), 0, found)
    return found


def included_files(path: str) -> list[str]:
    """Return the paths of the files that an Abaqus file includes, also through other files, as far as they are there."""
    found: list[str] = []
    waiting = [path]
    while waiting:
        last = waiting.pop()
        state = Path(last).stat()
        for name in _named_files(last, state.st_mtime_ns, state.st_size):
            inner = _place(name, Path(last), Path(path))
            if inner is not None and str(inner) not in found:
                found.append(str(inner))
                waiting.append(str(inner))
    return found


@lru_cache(maxsize=64)
def _named_files(path: str, changed: int, size: int) -> list[str]:
    """Names that a file includes; read once for each state of the file."""
    return [match[1].decode("latin-1") for match in _INPUT.finditer(file_bytes(path))]


def _read(path: Path, first: Path, depth: int, found: list[Keyword]) -> None:
    """Append the keywords of a file; data lines at its beginning belong to the last keyword so far."""
    here = "" if path == first else f" of {path.name}"
    begun, start = "", 0  # a keyword line that goes on in the next one, and its number
    for number, raw in enumerate([*text_of(file_bytes(str(path))).splitlines(), "*"], 1):
        line = raw.strip()
        if line.startswith("**") or not line:
            continue
        if begun.endswith(",") and line[0].isalpha():
            begun += line
            continue
        if begun:
            keyword, begun = _keyword(begun, f"line {start}{here}"), ""
            if keyword.name != "INCLUDE":
                found.append(keyword)
            if "INPUT" in keyword.parameters and keyword.name in ("INCLUDE", "NODE", "ELEMENT", "NSET", "ELSET"):
                _read(_included(keyword, path, first, depth), first, depth + 1, found)
        if line.startswith("*"):
            begun, start = line, number
        elif found:
            found[-1].lines.append(line)


def _included(keyword: Keyword, path: Path, first: Path, depth: int) -> Path:
    source = keyword.parameters["INPUT"]
    if depth == DEEPEST:
        raise Damaged(f"{keyword.where} includes {source[:80]}: files may include others to a depth of {DEEPEST}")
    inner = _place(source, path, first)
    if inner is None:
        raise Damaged(f"{keyword.where} includes {source[:80]}: there is no such file in the folder of {first.name}")
    return inner


def _keyword(line: str, where: str) -> Keyword:
    name, *rest = [part.strip() for part in _PARAMETER.findall(line[1:])] or [""]
    parameters = {}
    for part in rest:
        key, _, value = part.partition("=")
        parameters[" ".join(key.upper().split())] = value.strip().strip('"')
    return Keyword(" ".join(name.upper().split()), parameters, where)


def _place(name: str, path: Path, first: Path) -> Path | None:
    """Where an included file is: Abaqus starts from the folder of the first file."""
    name = name.strip().strip("\"'").replace("\\", "/")
    for folder in (first.parent, path.parent):
        try:
            if name and (folder / name).is_file():
                return folder / name
        except (OSError, ValueError):  # a damaged name
            continue
    return None
