"""Dictionary for users, whose error for an unknown name lists the known names."""

from collections.abc import Mapping
from typing import Any, TypeVar

from pellucid.errors import UnknownName
from pellucid.findings import absent

Value = TypeVar("Value")


class Named(dict[str, Value]):
    """A dictionary that raises `UnknownName`, with the list of known names, for an unknown name.

    what: beginning of the error message, such as "the history has no column"; values: the content of the dictionary.
    """

    def __init__(self, what: str, values: Mapping[str, Value]) -> None:
        super().__init__(values)
        self._what = what

    def __missing__(self, name: Any) -> Value:
        raise UnknownName(absent(self._what, name, self))
