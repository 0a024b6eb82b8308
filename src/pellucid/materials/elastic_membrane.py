"""Parameters of isotropic elastic membranes of any law: elasticity, damage, wrinkling."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import sqrt

from pellucid.materials.damage import DamageCase, Elastodamage, Undamaged
from pellucid.materials.elastic import ElasticMaterial
from pellucid.materials.law import Law
from pellucid.materials.membrane_material import MembraneMaterial
from pellucid.materials.trial import MEMBRANE, Operation, try_membrane
from pellucid.materials.wrinkling import TensionField, unwrinkled
from pellucid.model import check, parameter


class ElasticMembraneMaterial(ElasticMaterial, MembraneMaterial):
    """What isotropic elastic membranes share."""

    damage: DamageCase | None = parameter("", "how strain damages the membrane; without it never", None)
    wrinkling: bool = parameter("", "whether it wrinkles rather than bear compression (tension field)", False)

    @check
    def _wrinkles_or_tears(self) -> None:
        if self.wrinkling and self.damage:
            raise ValueError(
                "wrinkling = true and damage do not go together: there is no law of damage for wrinkles; leave out one of them"
            )

    @abstractmethod
    def elastic_law(self) -> Law:
        """The elastic law as kernels take it, for a membrane that bears compression."""

    def law(self) -> Law:
        """The law as kernels take it."""
        return TensionField(self.elastic_law()) if self.wrinkling else self.elastic_law()

    def operations(self, law: Law) -> Mapping[Law, Sequence[Operation]]:
        """What must be registered for its elastic law."""
        return {law: (*MEMBRANE, unwrinkled) if self.wrinkling else tuple(MEMBRANE)}

    @check
    def _law_is_whole(self) -> None:
        try_membrane(self)

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of pressure and shear waves in the plane at the start [m/s]: the thickness is free to change."""
        plane = self.young_modulus / (1.0 - self.poisson_ratio**2)
        return sqrt(plane / self.density), super().wave_speeds()[1]

    def damage_law(self) -> Elastodamage | Undamaged:
        """The law of damage as kernels take it."""
        return self.damage.law() if self.damage else Undamaged()

    @property
    def damage_radius(self) -> float | None:
        """Of the mean of the strain that drives damage [m]."""
        return self.damage.radius if self.damage else None
