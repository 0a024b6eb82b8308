"""Write docs/reference/case.md from the data model of a case. Run it after a change of the model."""

import json
from pathlib import Path
from typing import Any

from pellucid.case import json_schema

PAGE = Path(__file__).parent / "reference" / "case.md"
OPENING = """\
<!-- Written by docs/case_reference.py from the data model. Do not edit: run the script. -->
# Case reference

Every table and key of a case file. Where the unit column names a unit, a value is a number in that unit or a text with
a unit of its own, such as `"3 kPa"`. `pellucid schema` prints the same as a JSON schema.

In `--set`, a key is reached by its dotted path; an item of a list is named by its `name`, or counted from 0:
`--set body.driver.material.eos.gamma=1.6 --set "support.0.velocity=[1, 0, 0]"`.
"""
LIMITS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}


def reference() -> str:
    """Return the text of the page, with a section for the case and for every table in it, in the order of their first
    mention."""
    schema = json_schema()
    pages: dict[str, str] = {}
    _section("Case", "the whole file", schema, schema["$defs"], pages)
    return OPENING + "".join(pages.values())


def _section(name: str, place: str, node: dict[str, Any], definitions: dict[str, Any], pages: dict[str, str]) -> None:
    """Add the section of a table to `pages`, then the sections of the tables inside it; place: where the table stands in a
    case; node: JSON schema of the table."""
    if name in pages:
        return
    needed = node.get("required", [])
    rows = [
        f"| `{key}` | {_type(field)} | {field.get('unit') or _unit_inside(field)} | {_default(field, key in needed)} "
        f"| {_limits(field)} | {_escaped(field.get('description', ''))} |"
        for key, field in node.get("properties", {}).items()
    ]
    head = "| key | type | unit | default | limits | meaning |\n|---|---|---|---|---|---|\n"
    text = " ".join(node.get("description", "").split())
    pages[name] = f"\n## {name}\n*{place}* {text}\n\n{head}" + "\n".join(rows) + "\n"
    for key, field in node.get("properties", {}).items():
        for inner in _references(field):
            where = f"`{key}`" if name == "Case" else f"`{key}` of [{name}](#{_anchor(name)})"
            _section(inner, f"Table {where}.", definitions[inner], definitions, pages)


def _references(field: Any) -> list[str]:
    """Return the names of the tables that a field may contain, from its JSON schema."""
    if isinstance(field, dict):
        own = [field["$ref"].rpartition("/")[2]] if "$ref" in field else []
        inside = [value for key, value in field.items() if key not in ("default", "discriminator")]
        return list(dict.fromkeys(own + [name for value in inside for name in _references(value)]))
    if isinstance(field, list):
        return list(dict.fromkeys(name for value in field for name in _references(value)))
    return []


def _type(field: dict[str, Any]) -> str:
    if "$ref" in field:
        name = field["$ref"].rpartition("/")[2]
        return f"[{name}](#{_anchor(name)})"
    if "const" in field:
        return f"`{json.dumps(field['const'])}`"
    if "enum" in field:
        return ", ".join(f"`{json.dumps(value)}`" for value in field["enum"])
    options = [option for option in field.get("anyOf", field.get("oneOf", [])) if option.get("type") != "null"]
    if options:
        return " or ".join(_type(option) for option in options)
    if field.get("type") == "array":
        if "prefixItems" in field:
            kinds = dict.fromkeys(_type(item) for item in field["prefixItems"])
            return f"{len(field['prefixItems'])} × {' or '.join(kinds)}"
        return f"list of {_type(field['items'])}"
    return {"string": "text", "object": "table", "boolean": "`true`, `false`"}.get(field.get("type", ""), field.get("type", ""))


def _unit_inside(field: dict[str, Any]) -> str:
    """Return the unit of an optional field, which the JSON schema stores in its alternatives; empty if it has none."""
    return next((option["unit"] for option in field.get("anyOf", []) if option.get("unit")), "")


def _default(field: dict[str, Any], needed: bool) -> str:
    if needed:
        return "*required*"
    value = field.get("default")
    if value is None or isinstance(value, dict) or value in ([], ""):
        return ""
    return f"`{json.dumps(value)}`"


def _limits(field: dict[str, Any]) -> str:
    found = []
    for option in (field, *field.get("anyOf", [])):
        found += [f"{sign} {option[key]:g}" for key, sign in LIMITS.items() if key in option]
        if "maxLength" in option:
            found.append(f"at most {option['maxLength']} characters")
    return ", ".join(found)


def _anchor(name: str) -> str:
    return name.lower()


def _escaped(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
