"""Parser of the keyword and data lines of an Abaqus input file and of the files that it includes."""

import re
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from pellucid.geometry.files.contents import Damaged, text_of
from pellucid.users.users_code import file_bytes

DEEPEST = 10  # largest depth of nested includes
_PARAMETER = re.compile(r'(?:[^,"]|"[^"]*")+')
_INPUT = re.compile(rb"^[ \t]*\*[ \t]*(?:INCLUDE|NODE|ELEMENT|NSET|ELSET)\b[^\n]*?\bINPUT[ \t]*=([^,\r\n]+)", re.I | re.M)


@dataclass(frozen=True)
class Keyword:
    """A keyword in capitals, its parameters and its data lines without comments.

    where: file and line of the keyword, for messages; places: file and line of each data line.
    """

    name: str  # such as "NODE"
    parameters: dict[str, str]  # value of each parameter by its name, such as {"TYPE": "C3D4"}
    where: str
    lines: list[str] = field(default_factory=list)
    places: list[tuple[int, str]] = field(default_factory=list)

    def line_of(self, row: int) -> str:
        """Return file and line of the data line with index `row`, for messages."""
        number, here = self.places[row]
        return f"line {number}{here}"

    def words(self) -> list[list[str]]:
        """Return the comma-separated words of each data line."""
        return [[word.strip() for word in line.split(",")] for line in self.lines]


def keywords(path: str) -> list[Keyword]:
    """Return the keywords of a file in order, with the keywords of included files inserted. Raises Damaged if the file
    cannot be read."""
    found: list[Keyword] = []
    _read(Path(path), (Path(path),), found)
    return found


def included_files(path: str) -> list[str]:
    """Return the paths of the existing files that an Abaqus file includes, directly or through other files."""
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
    """Return the names of the files that a file includes. The result is cached for each version of the file, identified by
    its modification time `changed` [ns] and size [bytes]."""
    return [match[1].decode("latin-1") for match in _INPUT.finditer(file_bytes(path))]


def _read(path: Path, chain: tuple[Path, ...], found: list[Keyword]) -> None:
    """Append the keywords of a file to `found`; data lines at its start belong to the last keyword so far.

    chain: paths from the first file to this one; each file includes the next one.
    """
    first = chain[0]
    here = "" if path == first else f" of {path.name}"
    begun, start = "", 0  # a keyword line that is continued in the next line, and its number
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
                inner = _included(keyword, chain)
                _read(inner, (*chain, inner), found)
        if line.startswith("*"):
            begun, start = line, number
        elif found:
            found[-1].lines.append(line)
            found[-1].places.append((number, here))


def _included(keyword: Keyword, chain: tuple[Path, ...]) -> Path:
    source, first = keyword.parameters["INPUT"][:80], chain[0]
    inner = _place(source, chain[-1], first)
    if inner is None:
        text = f"{keyword.where} includes {source}, but there is no such file in the folder of {first.name}"
        raise Damaged(text, f"copy {source} into the folder of {first.name}")
    files = [path.resolve() for path in chain]
    if inner.resolve() in files:
        through = [path.name for path in chain[files.index(inner.resolve()) + 1 :]]
        text = f"{keyword.where}: {inner.name} includes itself" + (f" through {', '.join(through)}" if through else "")
        raise Damaged(text, f"remove {keyword.where}, or include a different file in this line")
    if len(chain) > DEEPEST:
        text = f"{keyword.where} includes {source}, but includes may only be nested to a depth of {DEEPEST}"
        raise Damaged(text, f"replace {keyword.where} by the contents of {source}")
    return inner


def _keyword(line: str, where: str) -> Keyword:
    name, *rest = [part.strip() for part in _PARAMETER.findall(line[1:])] or [""]
    parameters = {}
    for part in rest:
        key, _, value = part.partition("=")
        parameters[" ".join(key.upper().split())] = value.strip().strip('"')
    return Keyword(" ".join(name.upper().split()), parameters, where)


def _place(name: str, path: Path, first: Path) -> Path | None:
    """Return the path of a file that the file `path` includes under a name; None if it does not exist. Names are relative to
    the folder of the first file, as in Abaqus."""
    name = name.strip().strip("\"'").replace("\\", "/")
    for folder in (first.parent, path.parent):
        try:
            if name and (folder / name).is_file():
                return folder / name
        except (OSError, ValueError):  # a damaged name
            continue
    return None
