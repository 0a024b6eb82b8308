"""Read TOML text to tables, with limits on its depth, find the line of each key for error messages, and write a case as TOML,
without loss."""

import re
import tomllib
from bisect import bisect_right
from typing import TYPE_CHECKING, Any

from pellucid.findings import Path

if TYPE_CHECKING:
    from pellucid.case.spec import Case


DEEPEST = 32
"""Largest accepted depth of nested tables and lists in a TOML text."""


def parsed(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text. Raises `tomllib.TOMLDecodeError`, also for text nested too deeply and for numbers
    with too many digits."""
    try:
        data = tomllib.loads(text)
        deep = _is_deeper(data)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        deep = True
    except ValueError as error:  # of a whole number with thousands of digits, which is not converted
        raise tomllib.TOMLDecodeError("a number has too many digits") from error
    if deep:
        raise tomllib.TOMLDecodeError(f"lists or tables are nested more than {DEEPEST} levels deep")
    return data


def _is_deeper(data: Any) -> bool:
    level = [data]
    for _ in range(DEEPEST):
        lists = [item.values() if isinstance(item, dict) else item for item in level if isinstance(item, (dict, list))]
        level = [inner for one in lists for inner in one]
        if not level:
            return False
    return True


_BLANK = re.compile(r"(?:\s|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_STRING = re.compile(r'"""(?:\\.|[^\\])*?"""+|\'\'\'.*?\'\'\'+|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'', re.DOTALL)
_SCALAR = re.compile(r"[^,\]}#\n]+")


def key_lines(text: str) -> dict[Path, int]:
    """Return the line number (from 1) of every key, table and list item of a valid TOML text: ("body", 0, "shape") -> 12."""
    return _Scanner(text).scan()


class _Scanner:
    """Scanner of a valid TOML text, which finds the line number of each key, table and list item (see `key_lines`)."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.breaks = [found.start() for found in re.finditer("\n", text)]
        self.lines: dict[Path, int] = {}
        self.counts: dict[Path, int] = {}

    def scan(self) -> dict[Path, int]:
        table: Path = ()
        while self.skip(_BLANK) < len(self.text):
            if self.text[self.at] == "[":
                table = self.header()
            else:
                self.pair(table)
        return self.lines

    def skip(self, pattern: re.Pattern[str]) -> int:
        found = pattern.match(self.text, self.at)
        self.at = found.end() if found else self.at
        return self.at

    def note(self, path: Path, line: int | None = None) -> None:
        for length in range(1, len(path) + 1):  # a dotted key also opens the tables on its way
            self.lines.setdefault(path[:length], line or bisect_right(self.breaks, self.at - 1) + 1)

    def header(self) -> Path:
        line = bisect_right(self.breaks, self.at - 1) + 1
        is_list = self.text.startswith("[[", self.at)
        self.at += 2 if is_list else 1
        path: Path = ()
        parts = self.key()
        for number, part in enumerate(parts, 1):
            path += (part,)
            if is_list and number == len(parts):
                self.counts[path] = self.counts.get(path, 0) + 1
            if path in self.counts:
                path += (self.counts[path] - 1,)
        self.at += 2 if is_list else 1
        self.note(path, line)
        return path

    def key(self) -> list[str]:
        parts = []
        while True:
            self.skip(_SPACE)
            found = _STRING.match(self.text, self.at) or _BARE_KEY.match(self.text, self.at)
            if found is None:
                raise ValueError(f"no key at offset {self.at}")
            parts.append(next(iter(tomllib.loads(f"{found.group()} = 0"))))
            self.at = found.end()
            self.skip(_SPACE)
            if not self.text.startswith(".", self.at):
                return parts
            self.at += 1

    def pair(self, table: Path) -> None:
        line = bisect_right(self.breaks, self.at - 1) + 1
        path = table + tuple(self.key())
        self.note(path, line)
        self.at += 1  # the "=" sign
        self.value(path)

    def value(self, path: Path) -> None:
        self.skip(_BLANK)
        self.note(path)
        first = self.text[self.at]
        if first in "[{":
            self.at += 1
            number = 0
            while self.text[self.skip(_BLANK)] not in "]}":
                if first == "[":
                    self.value((*path, number))
                    number += 1
                else:
                    self.pair(path)
                if self.text[self.skip(_BLANK)] == ",":
                    self.at += 1
            self.at += 1
        elif self.skip(_STRING) and first in "\"'":
            return
        else:
            self.skip(_SCALAR)


def dumps(case: "Case") -> str:
    """Return the case as TOML text in SI units, including all defaults, so that `loads(dumps(case)) == case`."""
    import tomlkit

    document = tomlkit.document()
    data = case.to_data()
    tables = {key: value for key, value in data.items() if isinstance(value, dict) or _is_list_of_tables(value)}
    for key, value in data.items():
        if key not in tables and value != []:
            document.add(key, _inline(value))
    for key, value in tables.items():
        if isinstance(value, dict) and value:
            document.add(key, _table(value))
        elif isinstance(value, list):
            items = tomlkit.aot()
            for item in value:
                items.append(_table(item))
            document.add(key, items)
    return tomlkit.dumps(document)


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)


def _table(data: dict[str, Any]) -> Any:
    import tomlkit

    table = tomlkit.table()
    for key, value in data.items():
        table.add(key, _inline(value))
    return table


def _inline(value: Any) -> Any:
    import tomlkit

    if isinstance(value, dict):
        inline = tomlkit.inline_table()
        for key, item in value.items():
            inline.add(key, _inline(item))
        return inline
    if isinstance(value, list):
        array = tomlkit.array()
        for item in value:
            array.append(_inline(item))
        return array
    return tomlkit.item(value)
