"""Data model of sliding in contact: frictionless, stick, or Coulomb friction."""

from collections.abc import Iterator
from typing import Literal

from pydantic import field_validator

from pellucid.findings import Finding, Path, Refusal
from pellucid.model import check, name_parameter, parameter
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts

OTHER_NAMES = ("friction", "frictional", "slip-friction", "rough")


class Sliding(Condition):
    """Base of the data models of contacts and walls: sliding with or without friction. A probe (a requested history of a
    quantity) reads the contact force by the name of the condition."""

    name: str | None = name_parameter(
        "name of the contact or wall, for probes of its force: on the first body, or on all bodies at a wall", None
    )
    kind: Literal["frictionless", "stick", "coulomb"] = parameter(
        "", "sliding in contact: frictionless, none (stick), or with Coulomb friction", "frictionless"
    )
    friction: float | None = parameter("", 'coefficient of friction for kind "coulomb"', None, ge=0)

    @field_validator("kind", mode="before")
    @classmethod
    def _with_friction(cls, kind: object) -> object:
        if isinstance(kind, str) and kind.lower() in OTHER_NAMES:
            raise Refusal(f'"{kind}" is not a kind of contact', 'use kind = "coulomb", with `friction` for its coefficient')
        return kind

    @check
    def _friction_belongs_to_coulomb(self) -> None:
        if (self.kind == "coulomb") != (self.friction is not None):
            raise ValueError('`friction` belongs to `kind = "coulomb"`: give both or neither')

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding about a name that another condition already has, since a probe reads the force of a contact or
        wall by its name. path: location of the condition in the case; parts: all parts of the case."""
        for place, other in parts.placed(Condition):
            later = isinstance(other, Sliding) and place >= path
            if self.name is not None and other.reaction() == self.name and not later:
                text = f"{place[0]} number {int(place[1]) + 1} already has this name"
                yield Finding((*path, "name"), text, "choose different names")
                return

    def reaction(self) -> str | None:
        return self.name
