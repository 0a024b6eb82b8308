"""Base classes of the materials of membranes in plane stress, and of elastic membranes, with the keys that all of these have
(damage, wrinkling, surface viscosity), and their surface viscosity in parallel with the elasticity: T + 2μ D + λ tr D I
(Kelvin-Voigt).

D is the in-plane rate of deformation; μ and λ [N s/m] are surface viscosities, independent of the thickness (Scriven 1960,
Chem. Eng. Sci. 12, 98). The dissipation per unit area is (2μ D + λ tr D I) : D.
"""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from pellucid.jit import point_function, pointwise
from pellucid.materials.contract import BodyMaterial
from pellucid.materials.damage import DamageCase, Elastodamage, Undamaged
from pellucid.materials.law import Law
from pellucid.materials.membrane import (
    InPlane,
    around,
    damped_rate,
    plane_diffusivity,
    plane_response,
    record_loss,
    with_viscosity,
)
from pellucid.materials.trial import Operation, try_membrane
from pellucid.materials.wrinkling import TensionField
from pellucid.model import check, parameter
from pellucid.registry import Family


class MembraneMaterial(BodyMaterial):
    """Base of membrane materials. A new one is a subclass with its own `kind`."""

    @abstractmethod
    def law(self, thickness: float) -> Law:
        """Return the material law, as a NamedTuple of its parameters for the kernels, for a membrane of this thickness at
        rest [m]."""

    @abstractmethod
    def wave_speeds(self, thickness: float = 1.0) -> tuple[float, float]:
        """Return the speeds of in-plane pressure and shear waves at the start [m/s]. The thickness [m] matters only for
        surface moduli."""

    @property
    def plane_poisson_ratio(self) -> float:
        """In-plane Poisson's ratio in the initial state; 1 for a film that resists only changes of its area."""
        pressure, shear = self.wave_speeds()
        return 1.0 - 2.0 * (shear / pressure) ** 2 if pressure > 0.0 else 1.0

    @property
    def direction(self) -> np.ndarray | None:
        """Direction whose projection onto the surface is the first initial axis of anisotropic laws, shape (3,); None if the
        axes are arbitrary."""
        return None

    def damage_law(self) -> Elastodamage | Undamaged:
        """Return the damage law, as a NamedTuple of its parameters for the kernels; `Undamaged` without damage."""
        return Undamaged()

    @property
    def damage_radius(self) -> float | None:
        """Radius over which the strain that drives damage is averaged [m]; None for the strain at the point, or without
        damage."""
        return None

    def recoverable_energy(self, shape: np.ndarray) -> np.ndarray | None:
        """Return the energy per unit mass that points with given in-plane shapes, (n, 4), can give back [J/kg], shape (n,);
        None if all energy is recoverable, or if losses are recorded."""
        return None


MEMBRANE_MATERIALS = Family("material of a membrane", MembraneMaterial)
"""Kinds that a case can name, registered in `pellucid.materials`."""


@around
class ViscousMembrane(NamedTuple):
    """Parameters of an elastic membrane with surface viscosity: elastic law of the membrane, surface viscosities μ and λ [N
    s/m], thickness at rest [m]."""

    law: Law
    mu: float
    lam: float
    thickness: float


@pointwise
def _viscous_stress(law: ViscousMembrane, D: InPlane, ratio: float) -> InPlane:
    inverse = 1.0 / (law.thickness * ratio)
    even, two_mu = inverse * law.lam * (D[0] + D[1]), 2.0 * inverse * law.mu
    return even + two_mu * D[0], even + two_mu * D[1], two_mu * D[2]


@point_function(with_viscosity, ViscousMembrane)
def _with_viscosity(law, stress, D, ratio):
    v11, v22, v12 = _viscous_stress(law, D, ratio)
    return stress[0] + v11, stress[1] + v22, stress[2] + v12


@point_function(record_loss, ViscousMembrane)
def _record_loss(law, dissipated, p, D, ratio, scale):
    v11, v22, v12 = _viscous_stress(law, D, ratio)
    dissipated[p] += scale * (v11 * D[0] + v22 * D[1] + 2.0 * v12 * D[2])


@point_function(plane_diffusivity, ViscousMembrane)
def _plane_diffusivity(law, shape, density):
    return (2.0 * law.mu + law.lam) / (density * law.thickness * plane_response(law.law, shape)[3])


@point_function(damped_rate, ViscousMembrane)
def _damped_rate(law, rate, spread):
    # a mode that swings at ω and fades at β by a force of the step before: dt = 2/(√(ω² + β²/4) + β/2); ω = 2 rate, and
    # momentum that spreads at ν over h fades at 4ν/h² at the most
    return sqrt(rate * rate + spread * spread) + spread


class SolidMembraneMaterial(MembraneMaterial):
    """Base of the materials of elastic membranes, with the keys for damage, wrinkling and surface viscosity."""

    has_energy: ClassVar[bool] = True
    """True if the stress is the derivative of an energy for all strains, False if only for small strains."""

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
