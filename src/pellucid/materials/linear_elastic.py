"""Linear elasticity in rate form, σ^∇ = λ tr(D) I + 2μ D with the Jaumann rate, for small strains and any rotation."""

from math import sqrt
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
from pellucid.model import Model, parameter
from pellucid.tensors import Symmetric, double_dot, rotate, spin_rotation, symmetric_part


def lame(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Lamé's λ and μ [Pa]."""
    mu = young_modulus / (2.0 * (1.0 + poisson_ratio))
    return 2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio), mu


class ElasticMaterial(Model):
    """What isotropic elastic solids share."""

    density: float = parameter("kg/m^3", "initial density", gt=0)
    young_modulus: float = parameter("Pa", "Young's modulus E", gt=0)
    poisson_ratio: float = parameter("", "Poisson's ratio ν", gt=-1, lt=0.5)

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of plane pressure and shear waves at the start [m/s]."""
        lam, mu = lame(self.young_modulus, self.poisson_ratio)
        return sqrt((lam + 2.0 * mu) / self.density), sqrt(mu / self.density)


class LinearElastic(NamedTuple):
    """Lamé's constants [Pa]."""

    lam: float
    mu: float


class HypoelasticState(NamedTuple):
    """What a point of a rate-form solid carries: Cauchy stress [Pa] and the work done on it [J/kg].

    A rate form has no strain energy function; what it stores is the work of its stress.
    """

    stress: Symmetric
    work: float


class LinearElasticMaterial(ElasticMaterial):
    """Linear elastic solid in rate form (Jaumann), for small strains and any rotation."""

    kind: Literal["linear-elastic"] = "linear-elastic"

    def law(self) -> LinearElastic:
        """The law as kernels take it."""
        return LinearElastic(*lame(self.young_modulus, self.poisson_ratio))

    def initial_state(self) -> HypoelasticState:
        """No stress."""
        return HypoelasticState((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0.0)

    def signals(self, length: float) -> tuple[float, float]:
        """Speed of signals [m/s] and kinematic viscosity [m²/s] at the start, in cells of the given length [m]."""
        law = self.law()
        return signal_speed(law, self.initial_state(), self.density, AT_REST, length), diffusivity(law, self.density)


@point_function(update, LinearElastic)
def _update(law, state, density, L, dt, length):
    D = symmetric_part(L)
    trD = D[0] + D[1] + D[2]
    s = rotate(spin_rotation(L, dt), state.stress)
    bulk = dt * law.lam * trD
    m = 2.0 * dt * law.mu
    stress = (
        s[0] + m * D[0] + bulk,
        s[1] + m * D[1] + bulk,
        s[2] + m * D[2] + bulk,
        s[3] + m * D[3],
        s[4] + m * D[4],
        s[5] + m * D[5],
    )
    # stress and volume of the middle of the step
    power = 0.5 * (double_dot(s, D) + double_dot(stress, D))
    return HypoelasticState(stress, state.work + dt * power * (1.0 - 0.5 * dt * trD) / density)


@point_function(volume_growth, LinearElastic)
def _volume_growth(law, L, dt):
    return 1.0 + dt * (L[0] + L[4] + L[8])


@point_function(signal_speed, LinearElastic)
def _signal_speed(law, state, density, L, length):
    return sqrt((law.lam + 2.0 * law.mu) / density)


@point_function(diffusivity, LinearElastic)
def _diffusivity(law, density):
    return 0.0


@point_function(stored_energy, LinearElastic)
def _stored_energy(law, state, density):
    return state.work


@point_function(artificial_heating, LinearElastic)
def _artificial_heating(law, state, density, L, length):
    return 0.0
