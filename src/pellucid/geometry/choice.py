"""A table with exactly one key, which names what it is: the form of shapes and surfaces in a case."""

from typing import Any, ClassVar

from pydantic import model_validator

from pellucid.model import Model


class Choice(Model):
    """A table with one key that names the alternative; every field is an alternative, None where it is not chosen."""

    what: ClassVar[str]
    """How a message calls it, with its article."""

    @model_validator(mode="before")
    @classmethod
    def _exactly_one(cls, data: Any) -> Any:
        if isinstance(data, dict) and len(data) != 1:
            names = list(cls.model_fields)
            example = f"for example {{ {names[0]} = {{ ... }} }}"
            raise ValueError(f"{cls.what} is a table with exactly one of the keys {', '.join(names)}, {example}")
        return data

    def chosen(self) -> Any:
        """The alternative that is there."""
        return next(value for name in type(self).model_fields if (value := getattr(self, name)) is not None)
