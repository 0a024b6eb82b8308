"""Linear elasticity in rate form, σ^∇ = λ tr(D) I + 2μ D with the Jaumann rate, for small strains and any rotation."""

from math import sqrt
from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.contract import PointMaterial
from pellucid.materials.elastic import ElasticMaterial, lame
from pellucid.materials.law import rate_type, signal_speed, stored_energy, update
from pellucid.materials.point_state import point_state
from pellucid.tensors import NO_STRESS, Symmetric, double_dot, rotate, spin_rotation, symmetric_part


@rate_type
class LinearElastic(NamedTuple):
    """Parameters of linear elasticity in rate form: Lamé's constants [Pa]."""

    lam: float
    mu: float


@point_state()
class HypoelasticState(NamedTuple):
    """State of a point of a solid whose law is a rate form (stress rate as a function of the rate of deformation): Cauchy
    stress [Pa] and work done on it per unit mass [J/kg].

    A rate form has no strain energy function; the work of its stress counts as stored energy.
    """

    stress: Symmetric
    strain_energy: float


class LinearElasticMaterial(ElasticMaterial, PointMaterial):
    """Linear elastic solid in rate form (Jaumann), for small strains and any rotation."""

    kind: Literal["linear-elastic"] = "linear-elastic"

    def law(self) -> LinearElastic:
        return LinearElastic(*lame(self.young_modulus, self.poisson_ratio))

    def initial_state(self) -> HypoelasticState:
        return HypoelasticState(NO_STRESS, 0.0)

    def stressed(self, stress: Symmetric) -> tuple[float, HypoelasticState]:
        """Return the density [kg/m³] and the state of a point with this Cauchy stress [Pa]; its stored energy is that of
        linear elasticity, σ:ε/2 per unit volume."""
        trace = stress[0] + stress[1] + stress[2]
        squares = sum(value * value for value in stress[:3]) + 2.0 * sum(value * value for value in stress[3:])
        energy = 0.5 * ((1.0 + self.poisson_ratio) * squares - self.poisson_ratio * trace * trace) / self.young_modulus
        return self.density, HypoelasticState(stress, energy / self.density)


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
    return HypoelasticState(stress, state.strain_energy + dt * power * (1.0 - 0.5 * dt * trD) * (1.0 / density))


@point_function(signal_speed, LinearElastic)
def _signal_speed(law, state, density, L, length):
    return sqrt((law.lam + 2.0 * law.mu) * (1.0 / density))


@point_function(stored_energy, LinearElastic)
def _stored_energy(law, state, density):
    return state.strain_energy
