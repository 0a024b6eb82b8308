"""Kelvin-Voigt solid: a hyperelastic solid with an additional viscous stress, σ = σ(F) + 2η dev D.

The hyperelastic solid stores the strain energy; the viscous stress dissipates 2η dev D : dev D per unit volume and time.
Source: Landau & Lifshitz 1986, Theory of Elasticity, 3rd ed., section 34, without volume viscosity, with the rate of
deformation D instead of the rate of the small strain.
"""

from typing import Annotated, Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.contract import MATERIALS
from pellucid.materials.hyperelastic import HyperelasticMaterial, finite_strain
from pellucid.materials.law import (
    Law,
    cauchy_stress,
    diffusivity,
    dissipated_energy,
    energy,
    signal_speed,
    stored_energy,
    update,
    wave_speed,
)
from pellucid.materials.point_state import point_state
from pellucid.materials.viscoelastic import ELASTIC, ViscoelasticMaterial, lost_so_far
from pellucid.model import parameter
from pellucid.registry import OneOf
from pellucid.tensors import IDENTITY, NO_STRESS, Symmetric, Tensor, add, deformed, deviator, double_dot, scale, symmetric_part


@finite_strain
class KelvinVoigt(NamedTuple):
    """Parameters of the Kelvin-Voigt law: law of the hyperelastic solid, viscosity η [Pa s], initial density [kg/m³]."""

    elastic: Law
    viscosity: float
    rho0: float


@point_state()
class KelvinVoigtState(NamedTuple):
    """State of a point of a Kelvin-Voigt solid: Cauchy stress [Pa], deformation gradient, energy dissipated so far [J/kg]."""

    stress: Symmetric
    deformation_gradient: Tensor
    dissipated_energy: float


class KelvinVoigtMaterial(ViscoelasticMaterial):
    """Kelvin-Voigt solid: a hyperelastic solid with an additional viscous stress, σ = σ(F) + 2η dev D."""

    kind: Literal["kelvin-voigt"] = "kelvin-voigt"
    elastic: Annotated[HyperelasticMaterial, OneOf(MATERIALS, HyperelasticMaterial)] = parameter("", ELASTIC)
    viscosity: float = parameter("Pa*s", "shear viscosity η", ge=0)

    def hyperelastic(self) -> HyperelasticMaterial:
        return self.elastic

    def law(self) -> KelvinVoigt:
        return KelvinVoigt(self.elastic.law(), self.viscosity, self.density)

    def initial_state(self) -> KelvinVoigtState:
        return KelvinVoigtState(NO_STRESS, IDENTITY, 0.0)

    def wave_speeds(self) -> tuple[float, float]:
        return self.elastic.wave_speeds()


@point_function(update, KelvinVoigt)
def _update(law, state, density, L, dt, length):
    F, d = deformed(L, dt, state.deformation_gradient), deviator(symmetric_part(L))
    viscous = scale(2.0 * law.viscosity, d)
    lost = dt * double_dot(viscous, d) / density
    return KelvinVoigtState(add(cauchy_stress(law.elastic, F), viscous), F, state.dissipated_energy + lost)


@point_function(signal_speed, KelvinVoigt)
def _signal_speed(law, state, density, L, length):
    return wave_speed(law.elastic, state.deformation_gradient)


@point_function(diffusivity, KelvinVoigt)
def _diffusivity(law, density):
    return 4.0 / 3.0 * law.viscosity / density


@point_function(stored_energy, KelvinVoigt)
def _stored_energy(law, state, density):
    return energy(law.elastic, state.deformation_gradient) / law.rho0


point_function(dissipated_energy, KelvinVoigt)(lost_so_far)
