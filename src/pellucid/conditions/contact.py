"""Data model of contact between bodies, which slide without friction, stick, or slide with Coulomb friction."""

from collections.abc import Iterator
from typing import ClassVar, Literal

from pydantic import field_validator

from pellucid.findings import Finding, Path, Reason, Refusal
from pellucid.model import check, name_parameter, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition, LoadKind
from pellucid.parts.part import Parts

OTHER_NAMES = ("friction", "frictional", "slip-friction", "rough")


class Sliding(Condition):
    """Base of the data models of contacts and walls: sliding with or without friction. A probe (a requested history of a
    quantity) reads the contact force by the name of the condition."""

    load_kind: ClassVar[LoadKind] = "contact"
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
            if self.friction is None:
                raise ValueError('kind = "coulomb" needs a coefficient of friction; add `friction`, e.g. friction = 0.3')
            raise ValueError(f'`friction` has no effect with kind = "{self.kind}"; set kind = "coulomb", or remove `friction`')

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


class Contact(Sliding):
    """Contact of two bodies in different velocity fields, or of one body with itself. The default for pairs of velocity
    fields is frictionless contact; self-contact requires a contact with a single name."""

    between: tuple[str, ...] = parameter(
        "",
        "names of two bodies, for contact of their velocity fields, or of one body, for self-contact",
        min_length=1,
        max_length=2,
    )

    @check
    def _names_differ(self) -> None:
        if len(self.between) == 2 and self.between[0] == self.between[1]:
            name = self.between[0]
            raise ValueError(f'`between` names {name} twice; write `between = ["{name}"]` for contact of {name} with itself')

    @property
    def is_of_one_body(self) -> bool:
        """True for self-contact, i.e. contact of a body with itself."""
        return len(self.between) == 1

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about unknown bodies, bodies that share one velocity field, bodies without self-contact, and
        repeated contacts or names. path: location of the condition in the case; parts: all parts of the case."""
        yield from parts.no_grid((*path, "between"), "contact needs a grid")
        for name in self.between:
            yield from parts.unknown(BodyModel, (*path, "between"), name)
        fields = self._fields(parts)
        if self.is_of_one_body:
            yield from self._problems_of_one(path, parts)
        elif fields is not None and len(fields) == 1:
            text = f"both bodies share the velocity field `{min(fields)}` and move together: they cannot be in contact"
            yield Finding((*path, "between"), text, "set another `field` for one of them")
        alike = [(place, other) for place, other in parts.placed(Contact) if other.is_of_one_body == self.is_of_one_body]
        others = [place for place, other in alike if place < path and other._fields(parts) == fields]
        if fields is not None and others:
            what = "of the same body with itself" if self.is_of_one_body else "between the same velocity fields"
            text = f"contact number {int(others[0][1]) + 1} is {what}"
            yield Finding((*path, "between"), text, "keep one of the two contacts")
        yield from super().problems(path, parts)

    def _problems_of_one(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding if self-contact cannot be computed for the body. path: location of the condition in the case;
        parts: all parts of the case."""
        body = parts.named(BodyModel, self.between[0])
        if body is None:
            return
        alone = sum(other.field == body.field for other in parts.of(BodyModel)) == 1
        reason = why_no_self_contact(body, alone)
        if reason is not None:
            yield Finding((*path, "between"), *reason)
        elif not all(parts.active_axes):
            text = "contact of a body with itself needs three dimensions, and the grid is one cell thick along an axis"
            yield Finding((*path, "between"), text, "compute the case in three dimensions, or name two bodies")
        elif self.name is not None:
            text = f"contact of {self.between[0]} with itself has no force for a probe, since its forces sum up to zero"
            yield Finding((*path, "name"), text, "remove `name`")

    def _fields(self, parts: Parts) -> set[str] | None:
        """Return the names of the velocity fields of the bodies (one or two) of the contact; None if a body is unknown."""
        bodies = [parts.named(BodyModel, name) for name in self.between]
        return None if None in bodies else {body.field for body in bodies if body is not None}


def why_no_self_contact(body: BodyModel, alone: bool) -> Reason | None:
    """Return the reason why contact of the body with itself cannot be computed, or None; alone: True if no other body is in
    its velocity field."""
    if not body.own_material_nodes:
        text = f'body {body.name} of kind "{body.kind}" cannot have contact with itself: points on both '
        text += "sides of a fold share the nodes of the grid, and stick to each other"
        return Reason(text, "use kind membrane-elements or meshless-solid, or two bodies")
    if not alone:
        text = f"contact with itself requires a separate velocity field, but other bodies share the field of body {body.name}"
        return Reason(text, "set a separate `field` for it")
    if body.crumples:
        text = (
            f"body {body.name} resists neither compression (wrinkling = true) nor bending: it crumples within the length "
            f"of an element, where contact cannot keep its sides apart"
        )
        return Reason(text, "add [body.bending], or remove `wrinkling`")
    return None
