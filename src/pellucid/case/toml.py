"""TOML text to tables, within what a case can need: `tomllib` alone ends in errors of Python's own beyond its limits."""

import tomllib
from collections.abc import Iterator
from typing import Any

DEEPEST = 32
"""Tables and lists within one another."""


def parsed(text: str) -> dict[str, Any]:
    """The tables of a TOML text. Raises `tomllib.TOMLDecodeError` also for what is too deep or a number too long to be read."""
    try:
        data = tomllib.loads(text)
        deep = _is_deeper(data)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        deep = True
    except ValueError as error:  # of a whole number with thousands of digits, which is not converted
        raise tomllib.TOMLDecodeError("a number has thousands of digits") from error
    if deep:
        raise tomllib.TOMLDecodeError(f"lists or tables are more than {DEEPEST} deep within one another")
    return data


def _is_deeper(data: Any) -> bool:
    level = [data]
    for _ in range(DEEPEST):
        level = [inner for item in level for inner in _within(item)]
        if not level:
            return False
    return True


def _within(item: Any) -> Iterator[Any]:
    if isinstance(item, (dict, list)):
        yield from item.values() if isinstance(item, dict) else item
