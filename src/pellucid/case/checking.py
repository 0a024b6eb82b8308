"""Check data against the model of a case: returns the case, or all findings in the data."""

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from pellucid.case.explain import explain, problem, value_at
from pellucid.case.schema import schema_of
from pellucid.case.sections import parts_in
from pellucid.case.settings import put
from pellucid.errors import CaseError, Problem, shown
from pellucid.findings import Finding, Path

CaseType = TypeVar("CaseType", bound=BaseModel)


def checked(model: type[CaseType], data: dict[str, Any]) -> tuple[CaseType | None, list[Finding]]:
    """Check the data of a case file against `model`, the class of the case. Return the case and no findings; or None and all
    findings: errors within tables, and conflicts between the valid tables."""
    try:
        return model.model_validate(data), []
    except ValidationError as error:
        found = explain(error, data, schema_of(model))
        places = {item.path for item in found}
        return None, found + [item for item in parts_in(model, data).findings() if item.path not in places]


def changed(model: type[CaseType], data: dict[str, Any], settings: Mapping[str, Any]) -> CaseType:
    """Apply settings to the data of a case, in place, and return the resulting case.

    model: class of the case. data: nested tables of the case as read from TOML. settings: values by dotted key, such as
    {"grid.cell": 0.02}. Raises CaseError, whose problems name the setting.
    """
    paths: dict[str, Path] = {}
    problems: list[Problem] = []
    for key, value in settings.items():
        try:
            paths[key] = put(data, key, value)
        except CaseError as error:
            problems += error.blame(setting(key, value)).problems
    if problems:
        raise CaseError(problems)
    forget_other_kinds(model, data, list(paths.values()))
    case, found = checked(model, data)
    if case is None:
        raise CaseError([_at_setting(item, data, settings, paths) for item in found])
    return case


def related(one: Path, other: Path) -> bool:
    """Return True if one of two paths (keys from the case down to a value) is the beginning of the other."""
    length = min(len(one), len(other))
    return one[:length] == other[:length]


def setting(key: str, value: Any) -> str:
    """Return a setting as an option of the command line, such as `--set grid.cell=0.02`."""
    return f"--set {key}={value if isinstance(value, str) else shown(value)}"


def forget_other_kinds(model: type[BaseModel], data: dict[str, Any], paths: list[Path]) -> None:
    """Remove, from each table whose `kind` a setting changed, the keys that the new kind does not have, so that the new kind
    starts from its defaults. Keys that settings changed are kept.

    model: class of the case. data: nested tables of the case. paths: paths of the values that settings changed.
    """
    for path in paths:
        if path[-1] == "kind" and (known := schema_of(model).keys_at(path[:-1], data)):
            table = value_at(path[:-1], data)
            for key in [key for key in table if key not in known and not any(related(p, (*path[:-1], key)) for p in paths)]:
                del table[key]


def _at_setting(found: Finding, data: Any, settings: Mapping[str, Any], paths: Mapping[str, Path]) -> Problem:
    """Return a finding as a problem that names the setting with the same key as the finding, or with an enclosing or
    enclosed key; if there is no such setting, the problem names all settings.

    settings: values by dotted key; paths: path of each of these keys in the data.
    """
    item = problem(found, data)
    near = [key for key, path in paths.items() if related(path, found.path)] or list(settings)
    return Problem(item.text, item.key, item.value, item.remedy, None, " ".join(setting(key, settings[key]) for key in near))
