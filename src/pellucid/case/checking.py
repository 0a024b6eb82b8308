"""Check data against the model of a case: returns the case, or all findings in the data. Pydantic's errors are translated to
problems for the user: key as written, value, limit, remedy."""

from collections import defaultdict
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel, ValidationError

from pellucid.case.schema import Schema, schema_of
from pellucid.case.sections import parts_in
from pellucid.case.settings import put
from pellucid.errors import CaseError, Problem, shown
from pellucid.findings import Disagreement, Finding, Path, Refusal, hint, listed

MISSING = object()
INTO = "Move it into the table `"

LIMITS = {
    "greater_than": ("gt", "greater than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}

TYPES = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "string_type": 'text in quotes, such as "name"',
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "finite_number": "a finite number",
}


class Detail(NamedTuple):
    """An error of pydantic, from which `explain` makes findings: the path of the key as the user wrote it, the type of the
    error (`kind`), the context of the error by name (e.g. a limit), and the message."""

    path: Path
    kind: str
    context: Mapping[str, Any]
    message: str


def explain(error: ValidationError, data: Any, schema: Schema) -> list[Finding]:
    """Convert the errors that pydantic raised for the data of a case to findings without repetitions. Each finding has the
    path of the key as the user wrote the key. schema: JSON schema of the case."""
    details = [
        Detail(written_path(item["loc"], item["type"], data), item["type"], item.get("ctx", {}), item["msg"])
        for item in error.errors(include_url=False)
    ]
    groups: dict[Path, list[Detail]] = defaultdict(list)
    for detail in details:
        groups[detail.path].append(detail)
    found: list[Finding] = []
    for path, group in groups.items():
        alternatives = [other for other in groups if len(other) > len(path) and other[: len(path)] == path]
        if alternatives and all(detail.kind in TYPES or detail.kind in ("literal_error", "too_short") for detail in group):
            continue  # the value is of the other alternative's type, or lacks an item that is itself wrong: that says more
        found += _findings(path, group, data, schema)
    return _without_echoes(list(dict.fromkeys(found)))  # several missing items of a list are one fault


def written_path(location: tuple[int | str, ...], kind: str, data: Any) -> Path:
    """Return the path in the data of the location in a pydantic error: without the names of the alternatives that pydantic
    tried, which are not in the case. kind: pydantic's type of the error."""
    path: Path = ()
    for part in location:
        following = value_at((part,), data)
        if following is not MISSING:
            path += (part,)
            data = following
    return (*path, location[-1]) if kind == "missing" else path


def value_at(path: Path, data: Any) -> Any:
    """Return the value at a path of keys in nested tables and lists; MISSING if no value exists at the path."""
    for part in path:
        is_key = isinstance(data, dict) and part in data
        is_item = isinstance(data, (list, tuple)) and part in range(len(data))
        if is_key or is_item:
            data = data[part]
        else:
            return MISSING
    return data


def problem(found: Finding, data: Any) -> Problem:
    """Convert a finding in the data of a case to a problem for the user, with key and value as written in the case."""
    path = found.path
    if path[-1:] == (0,) and isinstance(value_at(path[:-1], data), str):
        path = path[:-1]  # one name where there may be a list
    value = value_at(path, data)
    return Problem(found.text, dotted(path, data), None if value is MISSING else value, found.remedy)


def dotted(path: Path, data: Any) -> str:
    """Return a path in the data of a case as a dotted key, with list items by name or, for unnamed items, by index."""
    parts = []
    for part in path:
        data = data[part] if value_at((part,), data) is not MISSING else None
        name = data.get("name") if isinstance(part, int) and isinstance(data, dict) else None
        label = name if isinstance(name, str) and name else str(part)
        parts.append(f'"{label}"' if "." in label else label)
    return ".".join(parts)


def _findings(path: Path, group: list[Detail], data: Any, schema: Schema) -> list[Finding]:
    first = next((detail for detail in group if detail.kind == "value_error"), group[0])  # it says more than a wrong type
    value = value_at(path, data)
    field = schema.field_at(path, data)
    meaning = _meaning(field)
    if first.kind == "value_error":
        error = first.context["error"]
        if isinstance(error, Disagreement):
            return list(error.findings)
        return [Finding(path, *error.reason) if isinstance(error, Refusal) else Finding(path, str(error))]
    if first.kind == "missing" and isinstance(path[-1], int):
        around = schema.field_at(path[:-1], data)
        return [Finding(path[:-1], f"must have {_lengths(around, schema)}{_meaning(around)}")]
    if first.kind == "missing":
        return [Finding(path, f"is missing{meaning}", f"Add `{path[-1]} = ...`.")]
    if first.kind == "extra_forbidden":
        keys = schema.keys_at(path[:-1], data)
        place = f"`{dotted(path[:-1], data)}`" if len(path) > 1 else "a case"
        remedy = _belongs(path, data, schema) or _of_others(path, data, schema) or hint(str(path[-1]), keys)
        return [Finding(path, f"unknown key; the keys of {place} are {listed(keys)}", remedy)]
    if first.kind in ("union_tag_invalid", "union_tag_not_found"):
        return [_unknown_kind(path, first, value, schema.kinds(field))]
    if first.kind in LIMITS:
        name, words = LIMITS[first.kind]
        limit = " ".join(filter(None, (f"{first.context[name]:g}", field.get("unit"))))
        item = isinstance(path[-1], int) and "description" not in field  # of a list, which has the meaning
        about = _meaning(schema.field_at(path[:-1], data) if item else field, with_unit=False)
        return [Finding(path, f"must be {words} {limit}{about}")]
    if first.kind in ("too_long", "too_short"):
        return [Finding(path, f"must have {_lengths(field, schema)}{meaning}")]
    if first.kind == "string_too_long":
        return [Finding(path, f"must have at most {first.context['max_length']} characters")]
    if first.kind == "string_pattern_mismatch":
        return [Finding(path, "must start with a letter and contain only letters, digits, - and _")]
    choices = [choice for detail in group if detail.kind == "literal_error" for choice in _choices(detail)]
    wanted = [TYPES[detail.kind] for detail in group if detail.kind in TYPES]
    if choices:
        quoted = [choice if choice.isdecimal() else f'"{choice}"' for choice in choices]
        wanted = [f"one of {listed(quoted)}" if len(quoted) > 1 else quoted[0], *dict.fromkeys(wanted)]
    if not wanted:
        return [Finding(path, first.message)]
    text = f"must be {' or '.join(dict.fromkeys(wanted))}{meaning}"
    if wanted == ["a list"] and isinstance(value, dict):
        return [Finding(path, text, _list_remedy(path, field, schema))]
    if wanted == ["a table"] and (keys := schema.keys_of(field)):
        return [Finding(path, text, f"Write `{path[-1]} = {{ ... }}` with some of the keys {listed(keys)}.")]
    return [Finding(path, text, hint(value, choices) if isinstance(value, str) else "")]


def _belongs(path: Path, data: Any, schema: Schema) -> str:
    """Return the remedy for an unknown key, at `path`, that would be valid in a neighbouring or enclosing table; an empty
    text if the key is valid in none of these tables."""
    key, around = path[-1], path[:-1]
    for needed in schema.required_at(around, data):
        if value_at((*around, needed), data) is MISSING and key in schema.keys_of(schema.field_at((*around, needed), data)):
            table = f"{needed} = {{ {key} = ... }}"
            table = f"{path[-2]} = {{ {table} }}" if isinstance(path[-2], str) else table
            return f"{INTO}{needed}`: `{table}`."
    if len(path) > 1 and key in schema.keys_at(path[:-2], data):
        table = f"`{dotted(path[:-2], data)}`" if len(path) > 2 else "the case"
        return f"Move it to {table}, next to `{path[-2]}`."
    table = value_at(around, data)
    for other in table if isinstance(table, dict) else ():
        if isinstance(table[other], dict) and key in schema.keys_at((*around, other), data):
            return f"Move it to `{dotted((*around, other), data)}`."
    return ""


def _of_others(path: Path, data: Any, schema: Schema) -> str:
    """Return the remedy for a key at `path` that is valid only in other kinds of its table; an empty text if no kind has
    this key."""
    kinds = schema.kinds(schema.field_at(path[:-1], data), str(path[-1]))
    if not kinds:
        return ""
    return f"Remove it: this is a key of {listed([f'`{kind}`' for kind in kinds])} only."


def _unknown_kind(path: Path, detail: Detail, value: Any, kinds: list[str]) -> Finding:
    tags = [tag.strip("'") for tag in detail.context.get("expected_tags", "").split(", ") if tag]
    kinds = tags or kinds
    text = f"must be one of {listed([shown(kind) for kind in kinds])}"
    if detail.kind == "union_tag_not_found":
        return Finding((*path, "kind"), f"is missing; it {text}")
    return Finding((*path, "kind"), text, hint(str(value.get("kind")), kinds))


def _list_remedy(path: Path, field: dict[str, Any], schema: Schema) -> str:
    """Return the remedy for a table at `path` where a list is required. field: schema of the key."""
    if "prefixItems" in field:
        return f"Write `{path[-1]} = [{', '.join('xyz'[: len(field['prefixItems'])])}]`, with one number for each."
    if len(path) == 1 and schema.is_list_of_tables(field):
        return f"Write the header `[[{path[0]}]]`, with double brackets, above each of them."
    return "Write it in [ ]."


def _choices(detail: Detail) -> list[str]:
    return str(detail.context["expected"]).replace(" or ", ", ").replace("'", "").split(", ")


def _lengths(field: dict[str, Any], schema: Schema) -> str:
    """Return the allowed numbers of items of a list in words, such as "at least 2 items". field: schema of the key."""
    words = []
    for least, most in schema.lengths(field):
        if least == most:
            words.append(f"{least} components")
        elif most is None:
            words.append(f"at least {least} {'item' if least == 1 else 'items'}")
        else:
            words.append(f"at least {least} and at most {most} items")
    return " or ".join(words) or "another number of items"


def _meaning(field: dict[str, Any], with_unit: bool = True) -> str:
    unit = f", {field['unit']}" if with_unit and field.get("unit") else ""
    return f" ({field['description']}{unit})" if field.get("description") else ""


def _without_echoes(found: list[Finding]) -> list[Finding]:
    """Remove each finding of a missing key that only repeats a finding of a misspelt or misplaced key in the same table."""
    meant = {(*item.path[:-1], item.remedy.split("`")[1]) for item in found if item.remedy.startswith(("did you mean `", INTO))}
    return [item for item in found if not (item.text.startswith("is missing") and item.path in meant)]


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
