"""Write a case: convert a `Case` to TOML, without loss."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pellucid.case.spec import Case


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
