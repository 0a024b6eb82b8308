"""Contact between bodies, as the user describes it."""

from typing import Literal

from pydantic import model_validator

from pellucid.model import Model, parameter


class Contact(Model):
    """How two bodies of different velocity fields touch. Fields that no contact names touch without friction."""

    name: str | None = parameter(
        "", "name for probes of its force on the first body", None, pattern=r"^[A-Za-z][A-Za-z0-9_-]*$"
    )
    between: tuple[str, str] = parameter("", "names of two bodies; what is said holds for their whole velocity fields")
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
