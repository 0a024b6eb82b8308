"""Settings: values at dotted keys such as `body.driver.material.eos.gamma`, applied to the data of a case."""

import difflib
import re
import tomllib
from collections.abc import Mapping
from typing import Any

from pellucid.case.toml import DEEPEST, parsed
from pellucid.errors import CaseError, Problem, cut, shown
from pellucid.findings import Path

_PART = re.compile(r'"([^"]*)"|\'([^\']*)\'|([^.\s"\']+)')

_BROKEN = re.compile(r"""^["'\[{]|^[^"]*"$|^[^']*'$""")  # begins a text, list or table, or ends a text that never began


def parse_setting(text: str) -> tuple[str, Any]:
    """Split a setting such as "grid.cell=0.02" into its key and its value, read as TOML or else as plain text.

    Raises CaseError if "=" or the key is missing, or if the value starts or ends like TOML but is not valid.
    """
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise CaseError(Problem("a setting must have the form KEY=VALUE, for example grid.cell=0.02", setting=f"--set {text}"))
    read = parse_value(value.strip())
    if isinstance(read, str) and read == value.strip() and _BROKEN.search(read):
        remedy = "Close all quotes and brackets. In a shell, put the whole setting in single quotes."
        raise CaseError(Problem(f"`{cut(read)}` is not valid TOML", remedy=remedy, setting=f"--set {text}"))
    return key.strip(), read


def parse_value(text: str) -> Any:
    """Read a value in TOML syntax. Text that is not TOML is returned unchanged, so that `trilinear` and `3 kPa` need no
    quotes."""
    try:
        return parsed(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def split_key(key: str) -> list[str]:
    """Split a dotted key such as "body.driver.velocity" at its dots; a part in quotes may contain dots. Raises CaseError
    for an invalid key."""
    parts = ["".join(groups) for groups in _PART.findall(key)]
    if not parts or _PART.sub("", key) != "." * (len(parts) - 1):
        raise CaseError(f"`{cut(key)}` is not a dotted key such as grid.cell or body.driver.material.density")
    if len(parts) > DEEPEST:
        raise CaseError(f"`{shown(parts[0])}...` has {len(parts)} parts; a key may have at most {DEEPEST}")
    return parts


def find(data: Mapping[str, Any], key: str) -> Path:
    """Return the path in `data` of a dotted key such as "body.driver.velocity". List items are given by index; path
    components that do not exist in the data remain as written."""
    here: Any = data
    path: Path = ()
    for part in split_key(key):
        try:
            step = _step(here, part, path)
            here = here[step]
        except (CaseError, KeyError):
            step, here = part, {}
        path += (step,)
    return path


def put(data: dict[str, Any], key: str, value: Any) -> Path:
    """Set the value of `key` in the nested tables and lists of `data`, in place, and return its path.

    Missing tables on the path are created; a list item is selected by its index or its `name`. Raises CaseError if the path
    contains a value that is not a table, or a list item that does not exist.
    """
    *way, last = split_key(key)
    here: Any = data
    path: Path = ()
    for part in way:
        step = _step(here, part, path)
        if isinstance(here, dict) and step not in here:
            here[step] = {}
        here = here[step]
        path += (step,)
    step = _step(here, last, path)
    here[step] = value
    return (*path, step)


def _step(here: Any, part: str, path: Path) -> str | int:
    place = ".".join(str(item) for item in path)
    if isinstance(here, dict):
        return part
    if not isinstance(here, list):
        raise CaseError(f"`{cut(place)}` is {shown(here)}, not a table, so it has no key `{cut(part)}`")
    if part in map(str, range(len(here))):
        return int(part)
    names = [str(item["name"]) for item in here if isinstance(item, dict) and "name" in item]
    if part in names:
        return names.index(part)
    close = difflib.get_close_matches(part, names, 1)
    listed = f"available: {', '.join(names)}" if names else f"it has {len(here)} items, with indices from 0"
    remedy = f"did you mean `{place}.{close[0]}`?" if close else ""
    raise CaseError(Problem(f"`{cut(place)}` has no item `{cut(part)}`; {listed}", remedy=remedy))
