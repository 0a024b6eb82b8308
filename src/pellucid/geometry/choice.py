"""Base classes of tables of a case: a table that selects an alternative by its key, and a mesh of limited size."""

from abc import abstractmethod
from typing import Any, ClassVar

from pydantic import model_validator

from pellucid.findings import Refusal
from pellucid.model import Model, check


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


MOST_POINTS = 2_000_000
"""Largest number of vertices or nodes. Surfaces of this size take about 3 s, solids with twelve tetrahedra per cube about 1 GB.
"""


def refuse_too_many(points: float) -> None:
    """Raise Refusal if the number of points exceeds the limit for generated meshes."""
    if not points <= MOST_POINTS:
        text = f"the mesh would have about {points:.3g} points, but at most {MOST_POINTS:.3g} are allowed"
        raise Refusal(text, "make the mesh coarser")


class Countable(Model):
    """A generated surface or mesh of a case; its number of points is checked before it is generated."""

    @check
    def _can_be_held(self) -> None:
        refuse_too_many(self.expected_points())

    @abstractmethod
    def expected_points(self) -> float:
        """Return the approximate number of vertices or nodes, without generating the mesh."""
