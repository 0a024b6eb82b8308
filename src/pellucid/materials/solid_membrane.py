"""Base class of the materials of elastic membranes, with the keys that all of them have: damage, wrinkling, surface
viscosity."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence

from pellucid.materials.damage import DamageCase, Elastodamage, Undamaged
from pellucid.materials.law import Law
from pellucid.materials.membrane_material import MembraneMaterial
from pellucid.materials.trial import Operation, try_membrane
from pellucid.materials.viscous_membrane import ViscousMembrane
from pellucid.materials.wrinkling import TensionField
from pellucid.model import check, parameter


class SolidMembraneMaterial(MembraneMaterial):
    """Base of the materials of elastic membranes, with the keys for damage, wrinkling and surface viscosity."""

    damage: DamageCase | None = parameter("", "law of damage; default: no damage", None)
    wrinkling: bool = parameter("", "true: the membrane wrinkles instead of carrying compression (tension field)", False)
    viscosity: float = parameter("N*s/m", "surface shear viscosity μ, in addition to elasticity", 0.0, ge=0)
    dilatational_viscosity: float = parameter("N*s/m", "second viscosity λ of the surface", 0.0, ge=0)

    @check
    def _wrinkles_alone(self) -> None:
        if self.wrinkling and self.damage:
            raise ValueError("wrinkling = true cannot be combined with damage; remove one of them")
        if self.wrinkling and self.is_viscous:
            raise ValueError("wrinkling = true cannot be combined with viscosity; remove one of them")

    @property
    def is_viscous(self) -> bool:
        """True if the membrane has a surface viscosity."""
        return max(self.viscosity, self.dilatational_viscosity) > 0.0

    @abstractmethod
    def plain_law(self, thickness: float) -> Law:
        """Return the elastic law of a membrane of this thickness at rest [m], without wrinkling (it also carries
        compression) and without viscosity."""

    def law(self, thickness: float) -> Law:
        plain = self.plain_law(thickness)
        if self.is_viscous:
            return ViscousMembrane(plain, self.viscosity, self.dilatational_viscosity, thickness)
        return TensionField(plain) if self.wrinkling else plain

    @abstractmethod
    def operations(self) -> Mapping[Law, Sequence[Operation]]:
        """Return the functions of `pellucid.materials.membrane` or `pellucid.materials.surface_law` that must be registered
        for the law and for each of its component laws."""

    @check
    def _law_is_whole(self) -> None:
        try_membrane(self)

    def damage_law(self) -> Elastodamage | Undamaged:
        return self.damage.law() if self.damage else Undamaged()

    @property
    def damage_radius(self) -> float | None:
        return self.damage.radius if self.damage else None
