"""Contact between bodies, as the user describes it."""

from collections.abc import Iterator

from pellucid.conditions.sliding import Sliding
from pellucid.findings import Finding, Path
from pellucid.model import check, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts


class Contact(Sliding):
    """How two bodies of different velocity fields touch. Fields that no contact names touch without friction."""

    between: tuple[str, str] = parameter("", "names of two bodies; the contact is that of their whole velocity fields")

    @check
    def _two_bodies(self) -> None:
        if self.between[0] == self.between[1]:
            raise ValueError(f"contact of {self.between[0]} with itself is not supported; name two bodies of different fields")

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
        yield from super().problems(path, parts)

    def _fields(self, parts: Parts) -> set[str] | None:
        """The velocity fields of its two bodies, where both are known."""
        bodies = [parts.named(BodyModel, name) for name in self.between]
        return None if None in bodies else {body.field for body in bodies if body is not None}
