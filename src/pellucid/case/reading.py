"""Read a case: convert TOML text to a `Case`, and report all problems of the file together."""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

from pellucid import catalogue
from pellucid.case.checking import checked, forget_other_kinds, problem, related, setting
from pellucid.case.settings import find, parse_setting, put
from pellucid.case.spec import Case
from pellucid.case.toml import key_lines, parsed
from pellucid.errors import CaseError, Problem
from pellucid.findings import Finding, Path
from pellucid.users.users_code import file_bytes

SHOWN = 60  # characters of a faulty line on each side of the fault


def load(case: "str | FilePath", settings: Mapping[str, Any] | None = None, quick: bool = False) -> Case:
    """Read the case of a gallery id, such as "gan2011/shock-tube", or of a TOML file.

    Parameters
    ----------
    case
        Gallery id or path of the file.
    settings
        Values by dotted key, such as {"grid.cell": 0.02}. They replace the values of the file before the case is checked, so
        that settings can also correct an invalid file.
    quick
        True to apply the quick settings of the case, before `settings`.

    Raises
    ------
    CaseError
        All problems of the case as it would run: file and line or setting, key, value, limit and remedy.
    """
    text, filename = _source(case)
    folder = catalogue.folder(str(case)) if catalogue.has(str(case)) else str(FilePath(case).parent)
    try:
        loaded = loads(text, filename, folder)
    except CaseError:
        if not settings:
            raise
        loaded = _corrected(text, filename, folder, settings, quick)
    else:
        loaded = loaded.quick_variant() if quick else loaded
        loaded = loaded.with_settings(settings) if settings else loaded
    return loaded.model_copy(update={"id": case}) if catalogue.has(str(case)) and not loaded.id else loaded


def _corrected(text: str, filename: str, folder: str, settings: Mapping[str, Any], quick: bool) -> Case:
    """Read a case from TOML text that is not a valid case by itself, after applying settings.

    filename, folder: name of the file in messages, and folder of relative paths. settings, quick: see `load`. Raises
    CaseError as `load` does.
    """
    data, lines = _parse(text, filename, folder)
    coarse = data.get("quick", {}) if quick else {}
    chosen = {**(coarse if isinstance(coarse, dict) else {}), **settings}
    paths, problems = {}, []
    for key, value in chosen.items():
        own = setting(key, value) if key in settings else ""
        line = None if own else _line(("quick", key), lines)
        try:
            paths[key] = put(data, key, value)
        except CaseError as error:
            problems += error.blame(own, line).problems
    if problems:
        raise CaseError(problems, filename)
    forget_other_kinds(Case, data, list(paths.values()))
    case, found = checked(Case, data)
    if case is not None:
        return case
    for item in found:
        near = [key for key, path in paths.items() if related(path, item.path)]
        own = " ".join(setting(key, settings[key]) for key in near if key in settings)
        path: Path = next((("quick", key) for key in near), item.path)
        told = problem(item, data)
        problems.append(Problem(told.text, told.key, told.value, told.remedy, None if own else _line(path, lines), own))
    raise CaseError(problems, filename)


def located(error: CaseError, case: str, quick: bool = False, settings: Sequence[str] = ()) -> CaseError:
    """Complete an error that the set-up of a run raised, and return it: add the name of the case file, and the line or the
    setting that caused each problem.

    case: gallery id or path of the case file. quick: True if the quick settings of the case apply. settings: settings as
    written on the command line, such as "grid.cell=0.02".
    """
    text, filename = _source(case)
    data, lines = parsed(text), key_lines(text)
    own = [(find(data, key), setting(key, value)) for key, value in map(parse_setting, settings)]
    coarse = [(find(data, key), ("quick", key)) for key in data.get("quick", {})] if quick else []
    problems = []
    for item in error.problems:
        path = find(data, item.key) if item.key else ()
        blamed = " ".join(words for other, words in own if path and related(other, path))
        place = next((entry for other, entry in coarse if path and related(other, path)), path)
        problems.append(replace(item, line=_line(place, lines), setting=blamed))
    return CaseError(problems, filename)


def _source(case: "str | FilePath") -> tuple[str, str]:
    """Return the text of a case, given by its gallery id or path, and the name of its file. Raises CaseError if the file
    cannot be read."""
    if catalogue.has(str(case)):
        return catalogue.text(str(case)), f"{case}.toml"
    path = FilePath(case)
    try:
        return file_bytes(path).decode("utf-8-sig").replace("\r\n", "\n"), str(case)
    except (FileNotFoundError, NotADirectoryError):
        remedy = "Check the path of the file" if path.suffix == ".toml" else catalogue.suggestion(str(case))
        raise CaseError(Problem(f"no gallery case and no file is named {case}", remedy=remedy)) from None
    except IsADirectoryError:
        raise CaseError(f"{case} is a folder, not a case file") from None
    except UnicodeDecodeError as error:
        raise CaseError(f"{case} is not a UTF-8 text file: {error}") from None
    except OSError as error:
        raise CaseError(f"cannot read {case}: {error.strerror}") from None


def loads(text: str, filename: str = "", folder: str = "") -> Case:
    """Read a case from TOML text; `filename` is used in messages, relative paths start from `folder`.

    Raises CaseError as `load` does.
    """
    data, lines = _parse(text, filename, folder)
    case, found = checked(Case, data)
    if case is not None:
        found = _quick_findings(case)
    if case is None or found:
        raise CaseError([_at_line(item, data, lines) for item in found], filename)
    return case


def _parse(text: str, filename: str, folder: str) -> tuple[dict[str, Any], dict[Path, int]]:
    """Return the data of a TOML text, with relative paths resolved from `folder`, and the line number of each key. Raises
    CaseError."""
    try:
        data = parsed(text)
    except tomllib.TOMLDecodeError as error:
        raise CaseError(_syntax_problem(str(error), text), filename) from None
    lines = key_lines(text)
    _resolve_paths(data, folder)
    return data, lines


def _resolve_paths(data: Any, folder: str) -> None:
    """Make paths in the data of a case absolute, in place: `extensions` and all values of keys `path`, also in quick settings.
    Relative paths start from `folder`."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        if key == "extensions" and isinstance(value, list):
            data[key] = [str((FilePath(folder) / item).absolute()) if isinstance(item, str) else item for item in value]
        elif isinstance(value, (dict, list)):
            _resolve_paths(value, folder)
        elif isinstance(value, str) and str(key).rpartition(".")[2] == "path":
            data[key] = str((FilePath(folder) / value).absolute())


def _quick_findings(case: Case) -> list[Finding]:
    """Check the quick settings of a valid case by applying them; return a finding for each error in these settings."""
    found = []
    try:
        case.quick_variant()
    except CaseError as error:
        for item in error.problems:
            keys = [key for key in case.quick if item.setting == setting(key, case.quick[key])] or list(case.quick)[:1]
            text = item.text if item.key in ("", keys[0]) else f"{item.key}: {item.text}"
            found.append(Finding(("quick", keys[0]), text, item.remedy))
    return found


def _at_line(found: Finding, data: Any, lines: Mapping[Path, int]) -> Problem:
    item = problem(found, data)
    return Problem(item.text, item.key, item.value, item.remedy, _line(found.path, lines))


def _line(path: Path, lines: Mapping[Path, int]) -> int | None:
    """Return the line number of the key at a path; if the line is unknown, the line of the innermost enclosing table with a
    known line; None if no line is known. lines: result of `key_lines`."""
    return next((lines[path[:n]] for n in range(len(path), 0, -1) if path[:n] in lines), None)


def _about(line: str, column: int) -> str:
    """Return the part of a line around a column (from 1), with dots where a long line is cut."""
    start, end = max(0, column - SHOWN), column + SHOWN
    return f"{'...' if start > 0 else ''}{line[start:end].strip()}{'...' if end < len(line) else ''}"


def _syntax_problem(message: str, text: str) -> Problem:
    place = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)", message)
    line = None if place is None else int(place[1]) if place[1] else text.count("\n") + 1
    where = (
        f", at column {place[2]} of `{_about(text.splitlines()[line - 1], int(place[2]))}`"
        if line and place and place[2]
        else ""
    )
    reason = message[: place.start()] if place else message
    return Problem(
        f"invalid TOML: {reason[:1].lower()}{reason[1:]}{where}",
        remedy='Write text in quotes, lists in [ ] and tables in { }: name = "gas", lower = [0, 0, 0], box = { ... }.',
        line=line,
    )
