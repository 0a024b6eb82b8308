"""Contact between bodies, as the user describes it."""

from collections.abc import Iterator
from typing import Literal

from pydantic import model_validator

from pellucid.findings import Finding, Path
from pellucid.model import name_parameter, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts


class Contact(Condition):
    """How two bodies of different velocity fields touch. Fields that no contact names touch without friction."""

    name: str | None = name_parameter("name for probes of its force on the first body", None)
    between: tuple[str, str] = parameter("", "names of two bodies; the contact is that of their whole velocity fields")
    kind: Literal["frictionless", "stick", "coulomb"] = parameter(
        "", "how they slide: freely, not at all while they press, or with friction", "frictionless"
    )
    friction: float | None = parameter("", 'coefficient of friction for kind "coulomb"', None, ge=0)

    @model_validator(mode="after")
    def _friction_belongs_to_coulomb(self) -> "Contact":
        if (self.kind == "coulomb") != (self.friction is not None):
            raise ValueError('`friction` belongs to `kind = "coulomb"`: give both or neither')
        if self.between[0] == self.between[1]:
            raise ValueError(f"contact of {self.between[0]} with itself is not supported; name two bodies of different fields")
        return self

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Bodies that are not there or move together, and contacts that are there twice, by velocity fields or by name."""
        yield from parts.no_grid((*path, "between"), "contact is found on the nodes of a grid")
        for name in self.between:
            yield from parts.unknown(BodyModel, (*path, "between"), name)
        fields = self._fields(parts)
        if fields is not None and len(fields) == 1:
            text = f"both bodies belong to the velocity field `{min(fields)}` and move together: they never touch"
            yield Finding((*path, "between"), text, "give one of them another `field`")
        others = [place for place, other in parts.placed(Contact) if place < path and other._fields(parts) == fields]
        if fields is not None and others:
            text = f"contact.{others[0][1]} (counted from 0) is between the same velocity fields"
            yield Finding((*path, "between"), text, "keep one of the two")
        yield from self._name_problems(path, parts)

    def _fields(self, parts: Parts) -> set[str] | None:
        """The velocity fields of its two bodies, where both are known."""
        bodies = [parts.named(BodyModel, name) for name in self.between]
        return None if None in bodies else {body.field for body in bodies if body is not None}

    def _name_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A name that another condition has: a probe of that name could not tell which is meant."""
        for place, other in parts.placed(Condition):
            later = isinstance(other, Contact) and place >= path
            if self.name is not None and other.reaction() == self.name and not later:
                text = f"{place[0]} number {int(place[1]) + 1} has this name already"
                yield Finding((*path, "name"), text, "give each its own name")
                return

    def reaction(self) -> str | None:
        """Its own name."""
        return self.name
