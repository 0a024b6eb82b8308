"""A table with exactly one key, which names what it is: the form of shapes and surfaces in a case."""

from typing import Any, ClassVar

from pydantic import model_validator

from pellucid.model import Model


class Choice(Model):
    """A table with one key that names the alternative; its field is None where it is not
    chosen."""

    what: ClassVar[str]
    """How a message calls it, with its article."""
    beside: ClassVar[tuple[str, ...]] = ()
    """Keys that are no alternatives and may stand beside one."""

    @classmethod
    def alternatives(cls) -> list[str]:
        """The keys of which there is one."""
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
        """The alternative that is there."""
        return next(value for name in self.alternatives() if (value := getattr(self, name)) is not None)
