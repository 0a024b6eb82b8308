"""Decoupled neo-Hookean solid, W = μ/2 (Ī₁-3) + κ/2 (J-1)², Ī₁ = J^(-2/3) tr b.

Source: Holzapfel 2000, Nonlinear Solid Mechanics, section 6.5. It differs from the coupled form of `neo_hookean` at finite
strain, and has the same Lamé constants at rest.
"""

from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.decoupled import DecoupledMaterial, decoupled
from pellucid.materials.elastic import ElasticMaterial, lame
from pellucid.materials.law import invariant_energy


@decoupled
class DecoupledNeoHookean(NamedTuple):
    """Parameters of the decoupled neo-Hookean law: shear and bulk modulus [Pa], initial density [kg/m³]."""

    mu: float
    kappa: float
    rho0: float


class DecoupledNeoHookeanMaterial(ElasticMaterial, DecoupledMaterial):
    """Neo-Hookean solid with separate shear and volume response, W = μ/2 (J^(-2/3) I₁ - 3) + κ/2 (J-1)²: any strain."""

    kind: Literal["decoupled-neo-hookean"] = "decoupled-neo-hookean"

    def moduli(self) -> tuple[float, float]:
        lam, mu = lame(self.young_modulus, self.poisson_ratio)
        return mu, lam + 2.0 / 3.0 * mu

    def law(self) -> DecoupledNeoHookean:
        return DecoupledNeoHookean(*self.moduli(), self.density)


@point_function(invariant_energy, DecoupledNeoHookean)
def _energy(law, first, second):
    return 0.5 * law.mu * first
