"""Hyperelastic solids: the rate form for material points, derived from energy and stress as functions of F.

The parameters of a law include the initial density `rho0` [kg/m³]. Its file registers `energy`, `cauchy_stress` and
`wave_speed`; `neo_hookean` is an example. A law whose stress depends on F and on other variables is decorated with
`finite_strain` and registers `update`, `signal_speed` and `stored_energy` itself.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from pellucid.jit import point_function
from pellucid.materials.contract import PointMaterial
from pellucid.materials.law import (
    Law,
    LawType,
    cauchy_stress,
    energy,
    energy_and_stress,
    first_piola_kirchhoff,
    rate_type,
    signal_speed,
    stored_energy,
    update,
    volume_growth,
    wave_speed,
)
from pellucid.materials.point_state import point_state
from pellucid.materials.stressed_state import stretch_under
from pellucid.materials.trial import Operation
from pellucid.tensors import IDENTITY, NO_STRESS, Symmetric, Tensor, deformed, determinant, piola_transform


@point_state()
class FiniteStrainState(NamedTuple):
    """State of a point of a hyperelastic solid: Cauchy stress [Pa] and deformation gradient."""

    stress: Symmetric
    deformation_gradient: Tensor


class HyperelasticMaterial(PointMaterial):
    """Base of the materials of hyperelastic solids, whose stress follows from a strain energy of the deformation gradient."""

    def initial_state(self) -> FiniteStrainState:
        return FiniteStrainState(NO_STRESS, IDENTITY)

    def stressed(self, stress: Symmetric) -> tuple[float, FiniteStrainState]:
        """Return the density [kg/m³] and the state of a point that is stretched so that it has this Cauchy stress [Pa]."""
        F = stretch_under(self.law(), stress)
        return self.density / determinant(F), FiniteStrainState(stress, F)

    def operations(self, law: Law) -> Mapping[Law, Sequence[Operation]]:
        return {law: (*super().operations(law)[law], energy, cauchy_stress, wave_speed)}


def finite_strain(law: type[LawType]) -> type[LawType]:
    """Class decorator: register the default functions of `rate_type` for a law that integrates the deformation gradient, F ←
    (I + dt L) F, with the velocity gradient L."""
    point_function(volume_growth, rate_type(law))(_volume_growth)
    return law


def hyperelastic(law: type[LawType]) -> type[LawType]:
    """Class decorator: register the rate form of a law (functions of the velocity gradient) and its first Piola-Kirchhoff
    stress, derived from its energy, Cauchy stress and wave speed."""
    finite_strain(law)
    point_function(update, law)(_update)
    point_function(signal_speed, law)(_signal_speed)
    point_function(stored_energy, law)(_stored_energy)
    point_function(first_piola_kirchhoff, law)(_first_piola_kirchhoff)
    point_function(energy_and_stress, law)(_energy_and_stress)
    return law


def _volume_growth(law, L, dt):
    return determinant(deformed(L, dt, IDENTITY))


def _update(law, state, density, L, dt, length):
    F = deformed(L, dt, state.deformation_gradient)
    return FiniteStrainState(cauchy_stress(law, F), F)


def _signal_speed(law, state, density, L, length):
    return wave_speed(law, state.deformation_gradient)


def _stored_energy(law, state, density):
    return energy(law, state.deformation_gradient) * (1.0 / law.rho0)


def _first_piola_kirchhoff(law, F):
    return piola_transform(cauchy_stress(law, F), F)


def _energy_and_stress(law, F):
    return energy(law, F), first_piola_kirchhoff(law, F)
