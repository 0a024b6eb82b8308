"""JSON schema of a table, and access to its parts by the keys that a user wrote."""

from functools import lru_cache
from typing import Any

from pydantic import BaseModel

from pellucid.findings import Path
from pellucid.registry import Registry


class Schema:
    """JSON schema (draft 2020-12) of a case or of one of its tables, with methods that find the schema of a key that a user
    wrote. Every number has its SI unit under the key `unit`.

    model: class of the case or table. In the methods, path is the path of a key in the case, data the data of the case, and
    node the schema of a key.
    """

    def __init__(self, model: type[BaseModel]) -> None:
        self.whole: dict[str, Any] = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
        self.whole |= model.model_json_schema(by_alias=True)

    def field_at(self, path: Path, data: Any) -> dict[str, Any]:
        """Return the schema of the key at `path`; empty if the key is unknown. If a table can be of several kinds, the data
        determine the kind."""
        node = self.whole
        for part in path:
            node = self._choice(node, data)
            if isinstance(part, int):
                items = node.get("prefixItems", [])
                node = items[part] if part < len(items) else node.get("items", {})
                data = data[part] if isinstance(data, (list, tuple)) and part < len(data) else None
            else:
                node = node.get("properties", {}).get(part, {})
                data = data.get(part) if isinstance(data, dict) else None
        return node

    def keys_at(self, path: Path, data: Any) -> list[str]:
        """Return the names of the keys that the table at `path` may have; an empty list if the data contain no table at
        this path."""
        value = data
        try:
            for part in path:
                value = value[part]
        except (TypeError, LookupError):
            return []
        return list(self._choice(self.field_at(path, data), value).get("properties", {}))

    def keys_of(self, node: dict[str, Any]) -> list[str]:
        """Return the names of the keys of a table that a case does not contain, of the first of its kinds; an empty list if
        the key does not hold a table. node: schema of the key that would hold the table."""
        return list(self._choice(node, {}).get("properties", {}))

    def required_at(self, path: Path, data: Any) -> list[str]:
        """Return the names of the keys that the table at `path` must have."""
        return list(self._choice(self.field_at(path, data), {}).get("required", ()))

    def kinds(self, node: dict[str, Any], key: str = "kind") -> list[str]:
        """Return the names of the kinds of tables that a key accepts. With `key`, only kinds with a key of this name are
        returned. node: schema of the key that holds the table."""
        tables = (self._choice(option, None).get("properties", {}) for option in node.get("oneOf", ()))
        return [kind["const"] for table in tables if key in table and "const" in (kind := table.get("kind", {}))]

    def lengths(self, node: dict[str, Any]) -> list[tuple[int, int | None]]:
        """Return the smallest and largest number of items (None: no limit) for each type of list that a key accepts. node:
        schema of the key."""
        if "$ref" in node:
            return self.lengths(self.whole["$defs"][node["$ref"].rpartition("/")[2]])
        options = node.get("anyOf", node.get("oneOf"))
        if options is not None:
            return list(dict.fromkeys(length for option in options for length in self.lengths(option)))
        if node.get("type") != "array":
            return []
        return [(node.get("minItems", len(node.get("prefixItems", ()))), node.get("maxItems"))]

    def is_list_of_tables(self, node: dict[str, Any]) -> bool:
        """Return True if a key holds a list of tables. node: schema of the key."""
        items = node.get("items", {})
        return "prefixItems" not in node and bool(items) and "properties" in self._choice(items, None)

    def _choice(self, node: dict[str, Any], value: Any) -> dict[str, Any]:
        """Return the schema of a key from its node: references are followed, and if the key accepts several types of
        values, the schema of the type that fits `value` best is returned."""
        if "$ref" in node:
            return self._choice(self.whole["$defs"][node["$ref"].rpartition("/")[2]], value)
        options = [self._choice(option, value) for option in node.get("anyOf", node.get("oneOf", ()))]
        if not options:
            return node
        kinds = self.kinds(node)
        if isinstance(value, dict) and len(kinds) == len(options):
            kind = value.get("kind", kinds[0])  # bodies have a kind that may be left out: the first
            return next((option for option in options if option["properties"]["kind"]["const"] == kind), {})
        wanted = "object" if isinstance(value, dict) else "array" if isinstance(value, (list, tuple)) else "number"
        return next((option for option in options if option.get("type") == wanted), options[0])


def schema_of(model: type[BaseModel]) -> Schema:
    """Return the schema of a model (class of a case or table), with all kinds that are registered at the time of the call."""
    return _made(model, Registry.changes)


@lru_cache(maxsize=4)
def _made(model: type[BaseModel], changes: int) -> Schema:
    return Schema(model)
