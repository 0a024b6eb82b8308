"""Base class of tables with exactly one key that selects an alternative, such as shapes and surfaces in a case."""

from typing import Any, ClassVar

from pydantic import model_validator

from pellucid.model import Model


class Choice(Model):
    """A table with exactly one key, which selects an alternative. The fields of all other alternatives are None."""

    what: ClassVar[str]
    """Name of this kind of table in messages, with its article."""
    beside: ClassVar[tuple[str, ...]] = ()
    """Keys that are not alternatives and may be given in addition to the selected one."""

    @classmethod
    def alternatives(cls) -> list[str]:
        """Return the keys of the alternatives; a table must contain exactly one of them."""
        return [name for name in cls.model_fields if name not in cls.beside]

    @model_validator(mode="before")
    @classmethod
    def _exactly_one(cls, data: Any) -> Any:
        if isinstance(data, dict) and len(data.keys() - set(cls.beside)) != 1:
            names = cls.alternatives()
            example = f"for example {{ {names[0]} = {{ ... }} }}"
            raise ValueError(f"{cls.what} is a table with exactly one of the keys {', '.join(names)}, {example}")
        return data

    def chosen(self) -> Any:
        """Return the value of the key that selects the alternative."""
        return next(value for name in self.alternatives() if (value := getattr(self, name)) is not None)
