"""The JSON schema of a case, and the way through it along the keys that a user wrote."""

from functools import cache
from typing import Any

from pellucid.case.lines import Path


@cache
def json_schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of a case file; every number carries its SI unit under the key `unit`."""
    from pellucid.case.spec import Case

    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | Case.model_json_schema(by_alias=True)


def field_at(path: Path, data: Any) -> dict[str, Any]:
    """What the schema says of the key at `path`, chosen among alternatives by the data written; empty where unknown."""
    node: dict[str, Any] = json_schema()
    for part in path:
        node = _choice(node, data)
        if isinstance(part, int):
            items = node.get("prefixItems", [])
            node = items[part] if part < len(items) else node.get("items", {})
            data = data[part] if isinstance(data, (list, tuple)) and part < len(data) else None
        else:
            node = node.get("properties", {}).get(part, {})
            data = data.get(part) if isinstance(data, dict) else None
    return node


def keys_at(path: Path, data: Any) -> list[str]:
    """The keys that the table at `path` may have."""
    value = data
    for part in path:
        value = value[part]
    return list(_choice(field_at(path, data), value).get("properties", {}))


def _choice(node: dict[str, Any], value: Any) -> dict[str, Any]:
    """Follow references and choose among alternatives the one that fits the value best."""
    if "$ref" in node:
        return _choice(json_schema()["$defs"][node["$ref"].rpartition("/")[2]], value)
    options = [_choice(option, value) for option in node.get("anyOf", node.get("oneOf", ()))]
    if not options:
        return node
    if isinstance(value, dict) and len(kinds(node)) == len(options):
        kind = value.get("kind", kinds(node)[0])  # bodies have a kind that may be left out: the first
        return next((option for option in options if option["properties"]["kind"]["const"] == kind), {})
    wanted = "object" if isinstance(value, dict) else "array" if isinstance(value, (list, tuple)) else "number"
    return next((option for option in options if option.get("type") == wanted), options[0])


def kinds(node: dict[str, Any]) -> list[str]:
    """The kinds of table among which the key `kind` chooses."""
    options = [_choice(option, None) for option in node.get("oneOf", ())]
    return [kind["const"] for option in options if "const" in (kind := option.get("properties", {}).get("kind", {}))]
