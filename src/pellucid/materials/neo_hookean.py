"""Compressible neo-Hookean solid, W = μ/2 (I₁-3) - μ ln J + λ/2 (ln J)².

Source: Bonet & Wood 2008, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed., eq. 6.28.
"""

from math import sqrt
from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.jit.elementary import log
from pellucid.materials.elastic import ElasticMaterial, lame
from pellucid.materials.hyperelastic import HyperelasticMaterial, hyperelastic
from pellucid.materials.law import cauchy_stress, energy, volumetric_energy, volumetric_stress, wave_speed
from pellucid.tensors import determinant, largest_row_sum, left_cauchy_green


@hyperelastic
class NeoHookean(NamedTuple):
    """Parameters of the compressible neo-Hookean law: Lamé's constants [Pa] and initial density [kg/m³]."""

    lam: float
    mu: float
    rho0: float


class NeoHookeanMaterial(ElasticMaterial, HyperelasticMaterial):
    """Compressible neo-Hookean solid, stress from the deformation gradient: any strain."""

    kind: Literal["neo-hookean"] = "neo-hookean"

    def law(self) -> NeoHookean:
        return NeoHookean(*lame(self.young_modulus, self.poisson_ratio), self.density)


@point_function(energy, NeoHookean)
def _energy(law, F):
    b = left_cauchy_green(F)
    ln_J = log(determinant(F))
    return 0.5 * law.mu * (b[0] + b[1] + b[2] - 3.0) - law.mu * ln_J + 0.5 * law.lam * ln_J * ln_J


@point_function(cauchy_stress, NeoHookean)
def _cauchy_stress(law, F):
    J = determinant(F)
    b = left_cauchy_green(F)
    by_J = 1.0 / J
    m = law.mu * by_J
    normal = (law.lam * log(J) - law.mu) * by_J
    return (m * b[0] + normal, m * b[1] + normal, m * b[2] + normal, m * b[3], m * b[4], m * b[5])


@point_function(wave_speed, NeoHookean)
def _wave_speed(law, F):
    # acoustic tensor of the spatial tangent, with ρ J = ρ₀: ρ₀ c² = λ + μ - λ ln J + μ n·b n along n, μ n·b n across,
    # and across is faster where J is large
    stretch = largest_row_sum(left_cauchy_green(F))
    along = max(law.lam + law.mu - law.lam * log(determinant(F)), 0.0)
    return sqrt((along + law.mu * stretch) * (1.0 / law.rho0))


@point_function(volumetric_energy, NeoHookean)
def _volumetric_energy(law, J):
    return 0.5 * law.lam * log(J) * log(J)


@point_function(volumetric_stress, NeoHookean)
def _volumetric_stress(law, J):
    return law.lam * log(J) / J
