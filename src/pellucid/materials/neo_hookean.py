"""Compressible neo-Hookean solid, W = μ/2 (I₁-3) - μ ln J + λ/2 (ln J)².

Source: Bonet & Wood 2008, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed., eq. 6.28.
"""

from math import log, sqrt
from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.law import (
    AT_REST,
    artificial_heating,
    diffusivity,
    signal_speed,
    stored_energy,
    update,
    volume_growth,
)
from pellucid.materials.linear_elastic import ElasticMaterial, lame
from pellucid.tensors import IDENTITY, Symmetric, Tensor, deformed, determinant, largest_row_sum, left_cauchy_green


class NeoHookean(NamedTuple):
    """Lamé's constants [Pa] and the initial density [kg/m³]."""

    lam: float
    mu: float
    rho0: float


class FiniteStrainState(NamedTuple):
    """What a point of a hyperelastic solid carries: Cauchy stress [Pa] and deformation gradient."""

    stress: Symmetric
    deformation_gradient: Tensor


class NeoHookeanMaterial(ElasticMaterial):
    """Compressible neo-Hookean solid, stress from the deformation gradient: any strain."""

    kind: Literal["neo-hookean"] = "neo-hookean"

    def law(self) -> NeoHookean:
        """The law as kernels take it."""
        return NeoHookean(*lame(self.young_modulus, self.poisson_ratio), self.density)

    def initial_state(self) -> FiniteStrainState:
        """No stress, no deformation."""
        return FiniteStrainState((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), IDENTITY)

    def signals(self, length: float) -> tuple[float, float]:
        """Speed of signals [m/s] and kinematic viscosity [m²/s] at the start, in cells of the given length [m]."""
        law = self.law()
        return signal_speed(law, self.initial_state(), self.density, AT_REST, length), diffusivity(law, self.density)


@point_function(update, NeoHookean)
def _update(law, state, density, L, dt, length):
    F = deformed(L, dt, state.deformation_gradient)
    J = determinant(F)
    b = left_cauchy_green(F)
    m = law.mu / J
    normal = (law.lam * log(J) - law.mu) / J
    stress = (m * b[0] + normal, m * b[1] + normal, m * b[2] + normal, m * b[3], m * b[4], m * b[5])
    return FiniteStrainState(stress, F)


@point_function(volume_growth, NeoHookean)
def _volume_growth(law, L, dt):
    return determinant(deformed(L, dt, IDENTITY))


@point_function(signal_speed, NeoHookean)
def _signal_speed(law, state, density, L, length):
    # acoustic tensor of the spatial tangent, with ρ J = ρ₀: ρ₀ c² = λ + μ - λ ln J + μ n·b n along n, μ n·b n across,
    # and across is faster where J is large
    F = state.deformation_gradient
    stretch = largest_row_sum(left_cauchy_green(F))
    along = max(law.lam + law.mu - law.lam * log(determinant(F)), 0.0)
    return sqrt((along + law.mu * stretch) / law.rho0)


@point_function(diffusivity, NeoHookean)
def _diffusivity(law, density):
    return 0.0


@point_function(stored_energy, NeoHookean)
def _stored_energy(law, state, density):
    F = state.deformation_gradient
    b = left_cauchy_green(F)
    ln_J = log(determinant(F))
    return (0.5 * law.mu * (b[0] + b[1] + b[2] - 3.0) - law.mu * ln_J + 0.5 * law.lam * ln_J * ln_J) / law.rho0


@point_function(artificial_heating, NeoHookean)
def _artificial_heating(law, state, density, L, length):
    return 0.0
