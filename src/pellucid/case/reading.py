"""Reading a case: TOML text to a `Case`, every problem of the file reported together."""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

from pydantic import TypeAdapter, ValidationError

from pellucid import catalogue
from pellucid.bodies.models import Body
from pellucid.case.explain import explain, problem, value_at
from pellucid.case.lines import Path, key_lines
from pellucid.case.relations import Conditions, Finding, findings
from pellucid.case.schema import keys_at
from pellucid.case.settings import find, parse_setting, put
from pellucid.case.spec import Case, OutputCase, Probe, TimeCase
from pellucid.conditions.absorbing import Absorbing
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.pressure import Pressure
from pellucid.conditions.support import Support
from pellucid.contact.model import Contact
from pellucid.errors import CaseError, Problem, shown
from pellucid.grid.model import GridCase


def load(case: "str | FilePath") -> Case:
    """The case of a gallery id, such as "gan2011/shock-tube", or of a TOML file.

    Raises CaseError naming file, line, key, value, limit and remedy of everything that is wrong.
    """
    text, filename = _source(case)
    folder = catalogue.folder(str(case)) if catalogue.has(str(case)) else str(FilePath(case).parent)
    loaded = loads(text, filename, folder)
    return loaded.model_copy(update={"id": case}) if catalogue.has(str(case)) and not loaded.id else loaded


def located(error: CaseError, case: str, quick: bool = False, settings: Sequence[str] = ()) -> CaseError:
    """What the set-up of a run found wrong, with the line of the case or the setting that it comes from."""
    text, filename = _source(case)
    data, lines = tomllib.loads(text), key_lines(text)
    own = [(find(data, key), _setting(key, value)) for key, value in map(parse_setting, settings)]
    coarse = [(find(data, key), ("quick", key)) for key in data.get("quick", {})] if quick else []
    problems = []
    for item in error.problems:
        path = find(data, item.key) if item.key else ()
        setting = " ".join(words for other, words in own if path and _related(other, path))
        place = next((entry for other, entry in coarse if path and _related(other, path)), path)
        problems.append(replace(item, line=_line(place, lines), setting=setting))
    return CaseError(problems, filename)


def _source(case: "str | FilePath") -> tuple[str, str]:
    """The text of a case and the name of its file."""
    if catalogue.has(str(case)):
        return catalogue.text(str(case)), f"{case}.toml"
    path = FilePath(case)
    try:
        return path.read_text(encoding="utf-8-sig"), str(case)
    except (FileNotFoundError, NotADirectoryError):
        remedy = "" if path.suffix == ".toml" else catalogue.suggestion(str(case))
        raise CaseError(Problem(f"there is no gallery case and no file {case}", remedy=remedy)) from None
    except IsADirectoryError:
        raise CaseError(f"{case} is a folder, not a case file") from None
    except UnicodeDecodeError as error:
        raise CaseError(f"{case} is no text in UTF-8: {error}") from None
    except OSError as error:
        raise CaseError(f"cannot read {case}: {error.strerror}") from None


def loads(text: str, filename: str = "", folder: str = "") -> Case:
    """The case of a TOML text; `filename` is for messages, relative paths in it start from `folder`.

    Raises CaseError as `load` does.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise CaseError(_syntax_problem(str(error), text), filename) from None
    lines = key_lines(text)
    _resolve_paths(data, folder)
    case, found = _validated(data)
    if case is not None:
        found = _quick_findings(case)
    if case is None or found:
        raise CaseError([_at_line(item, data, lines) for item in found], filename)
    return case


def changed(case: Case, settings: Mapping[str, Any]) -> Case:
    """The case with `settings` put at their dotted keys; problems name the setting. Raises CaseError."""
    data = case.to_data()
    paths: dict[str, Path] = {}
    problems: list[Problem] = []
    for key, value in settings.items():
        try:
            paths[key] = put(data, key, value)
        except CaseError as error:
            problems += error.blame(_setting(key, value)).problems
    if problems:
        raise CaseError(problems)
    _forget_other_kinds(data, list(paths.values()))
    result, found = _validated(data)
    if result is None:
        raise CaseError([_at_setting(item, data, settings, paths) for item in found])
    return result


def _forget_other_kinds(data: dict[str, Any], paths: list[Path]) -> None:
    """Where a `kind` was set, drop what only the kind before it knew, so that the new one starts from its defaults."""
    for path in paths:
        if path[-1] == "kind" and (known := keys_at(path[:-1], data)):
            table = value_at(path[:-1], data)
            for key in [key for key in table if key not in known and not any(_related(p, (*path[:-1], key)) for p in paths)]:
                del table[key]


def _resolve_paths(data: Any, folder: str) -> None:
    """Let the values of all keys `path`, also among the quick settings, start from a folder, in place."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        if isinstance(value, (dict, list)):
            _resolve_paths(value, folder)
        elif isinstance(value, str) and str(key).rpartition(".")[2] == "path":
            data[key] = str((FilePath(folder) / value).absolute())


def _validated(data: dict[str, Any]) -> tuple[Case | None, list[Finding]]:
    try:
        return Case.model_validate(data), []
    except ValidationError as error:
        found = explain(error, data)
        places = {item.path for item in found}
        return None, found + [item for item in _between_sound_parts(data) if item.path not in places]


def _between_sound_parts(data: dict[str, Any]) -> list[Finding]:
    """What does not fit together among the parts that are right in themselves; pydantic stops before this."""
    bodies = _sound(data.get("body"), Body) or [None]  # what is no list may still hold the body that a probe means
    for index, body in enumerate(bodies):
        written = data["body"][index] if isinstance(data.get("body"), list) and data["body"] else None
        if body is None and isinstance(written, dict) and isinstance(written.get("name"), str):
            bodies[index] = written["name"]
    grid, time = _sound([data.get("grid")], GridCase)[0], _sound([data.get("time")], TimeCase)[0]
    output = _sound([data.get("output", {})], OutputCase)[0]
    kinds = {"support": Support, "motion": Motion, "absorbing": Absorbing, "pressure": Pressure, "contact": Contact}
    conditions = Conditions(*(_sound(data.get(name), kind) for name, kind in kinds.items()))
    return findings(grid, bodies, conditions, _sound(data.get("probe"), Probe), time, output)


def _sound(items: Any, kind: Any) -> list[Any]:
    """Each item as `kind`, or None where it is wrong in itself."""
    adapter = TypeAdapter(kind)
    sound: list[Any] = []
    for item in items if isinstance(items, list) else ():
        try:
            sound.append(adapter.validate_python(item))
        except ValidationError:
            sound.append(None)
    return sound


def _quick_findings(case: Case) -> list[Finding]:
    """What is wrong with the quick settings of a case that is itself right."""
    found = []
    try:
        case.quick_variant()
    except CaseError as error:
        for item in error.problems:
            keys = [key for key in case.quick if item.setting == _setting(key, case.quick[key])] or list(case.quick)[:1]
            text = item.text if item.key in ("", keys[0]) else f"{item.key}: {item.text}"
            found.append(Finding(("quick", keys[0]), text, item.remedy))
    return found


def _at_line(found: Finding, data: Any, lines: Mapping[Path, int]) -> Problem:
    item = problem(found, data)
    return Problem(item.text, item.key, item.value, item.remedy, _line(found.path, lines))


def _line(path: Path, lines: Mapping[Path, int]) -> int | None:
    """The line of a path, or of the innermost table around it that has one."""
    return next((lines[path[:n]] for n in range(len(path), 0, -1) if path[:n] in lines), None)


def _at_setting(found: Finding, data: Any, settings: Mapping[str, Any], paths: Mapping[str, Path]) -> Problem:
    """A problem laid at the door of the setting that touches its place, else of all settings together."""
    item = problem(found, data)
    near = [key for key, path in paths.items() if _related(path, found.path)] or list(settings)
    return Problem(item.text, item.key, item.value, item.remedy, None, " ".join(_setting(key, settings[key]) for key in near))


def _related(one: Path, other: Path) -> bool:
    length = min(len(one), len(other))
    return one[:length] == other[:length]


def _setting(key: str, value: Any) -> str:
    return f"--set {key}={value if isinstance(value, str) else shown(value)}"


def _syntax_problem(message: str, text: str) -> Problem:
    place = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)", message)
    line = int(place[1]) if place and place[1] else text.count("\n") + 1
    where = f", at column {place[2]} of `{text.splitlines()[line - 1].strip()}`" if place and place[2] else ""
    reason = message[: place.start()] if place else message
    return Problem(
        f"this is no valid TOML: {reason[:1].lower()}{reason[1:]}{where}",
        remedy='texts stand in quotes, lists in [ ], tables in { }: name = "gas", lower = [0, 0, 0], box = { ... }',
        line=line,
    )
