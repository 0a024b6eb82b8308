"""Functions of a law at a point; kernels and plain Python call the same functions.

A law is a NamedTuple of its parameters. The state of a point under a law is a NamedTuple too, declared with
`pellucid.materials.point_state`; every state has a `stress` (Cauchy, 6-tuple xx, yy, zz, yz, xz, xy) [Pa].

Material points use the rate form: `update` and the functions that follow it here. `rate_type` registers default functions
shared by most laws, so that a law registers only functions that differ from them. A hyperelastic law is defined by
`energy`, `cauchy_stress` and `wave_speed` as functions of the deformation gradient; `pellucid.materials.hyperelastic`
derives its rate form. An isotropic one may state its energy alone, by invariants, see `pellucid.materials.coupled`. A
decoupled law is the sum of an isochoric and a volumetric part; `pellucid.materials.decoupled`
derives the functions of a hyperelastic law from both.

Divisions are slow. The compiler combines the functions of a point to one loop and computes 1 / density once if all
functions multiply by it; it computes the inverse of a parameter before the loop.
"""

from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from pellucid.jit import generic, point_function
from pellucid.materials.derivatives import derive
from pellucid.materials.point_state import PointState
from pellucid.tensors import PlaneTensor, Symmetric, Tensor

ZERO_GRADIENT = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
SQUEEZED = (-1e-300, 0.0, 0.0, 0.0, -1e-300, 0.0, 0.0, 0.0, -1e-300)
"""Velocity gradients [1/s]: zero, and an infinitesimally slow compression, which only selects the laws' branch for
compression."""


class Law(Protocol):
    """A material law in the form for kernels (compiled loops): a NamedTuple of its parameters, whose type selects the
    functions."""

    @property
    def _fields(self) -> tuple[str, ...]: ...


LawType = TypeVar("LawType", bound=Law)


@generic
def update(law: Law, state: PointState, density: float, L: Tensor, dt: float, length: float) -> PointState:
    """Return the state of a point after a step dt [s] with the velocity gradient L [1/s].

    state: before the step; density: at the end of the step [kg/m³]; length: cell size [m], for artificial viscosity.
    """


@generic
def volume_growth(law: Law, L: Tensor, dt: float) -> float:
    """Return the ratio of the volumes after and before a step dt [s], as the law integrates the velocity gradient L [1/s]."""


@generic
def signal_speed(law: Law, state: PointState, density: float, L: Tensor, length: float) -> float:
    """Return the fastest signal speed relative to the material [m/s], with artificial viscosity, which limits the time
    step. state: state of the point; density [kg/m³]; L: velocity gradient [1/s]; length: cell size [m]."""


@generic
def diffusivity(law: Law, density: float) -> float:
    """Return the kinematic viscosity (2μ + λ)/ρ [m²/s] that damps plane pressure waves, with the shear viscosity μ, the
    second viscosity λ and the density ρ [kg/m³]."""


@generic
def stored_energy(law: Law, state: PointState, density: float) -> float:
    """Return the internal energy of a fluid or the strain energy of a solid per unit mass [J/kg]. state: state of the
    point; density [kg/m³]."""


@generic
def dissipated_energy(law: Law, state: PointState, density: float) -> float:
    """Return the work of the stress per unit mass dissipated so far [J/kg], for laws that separate the dissipated energy
    from the stored energy; `stored_energy` excludes it. state: state of the point; density [kg/m³]."""


@generic
def artificial_heating(law: Law, state: PointState, density: float, L: Tensor, length: float) -> float:
    """Return the power of the artificial viscosity per unit mass [W/kg]; it is part of the rate of internal energy and
    recorded separately. state: state of the point; density [kg/m³]; L: velocity gradient [1/s]; length: cell size [m]."""


@generic
def point_pressure(law: Law, state: PointState, density: float) -> float:
    """Return the pressure for results [Pa] at a state and a density [kg/m³]: from the equation of state for a fluid, minus
    the mean stress for a solid."""


@generic
def energy(law: Law, F: Tensor | PlaneTensor) -> float:
    """Return the strain energy W per unit reference volume [J/m³] at the deformation gradient F: a 9-tuple, or the in-plane
    4-tuple (11, 12, 21, 22) for membranes."""


@generic
def cauchy_stress(law: Law, F: Tensor) -> Symmetric:
    """Return the Cauchy stress σ = 1/J ∂W/∂F Fᵀ [Pa] at the deformation gradient F, with the energy W of `energy` and J =
    det F."""


@generic
def first_piola_kirchhoff(law: Law, F: Tensor) -> Tensor:
    """Return the first Piola-Kirchhoff stress P = ∂W/∂F [Pa], i.e. current force per reference area, at the deformation
    gradient F, with the energy W of `energy`."""


@generic
def energy_and_stress(law: Law, F: Tensor) -> tuple[float, Tensor]:
    """Return the strain energy per unit reference volume [J/m³] and the first Piola-Kirchhoff stress [Pa] at the
    deformation gradient F together; a law registers this function if both results need the same costly intermediate
    results."""


@generic
def wave_speed(law: Law, F: Tensor) -> float:
    """Return the speed of the fastest plane wave relative to the material in the configuration with the deformation gradient
    F [m/s], or an upper bound."""


@generic
def volumetric_energy(law: Law, J: float) -> float:
    """Return U(J), the part of the strain energy per unit reference volume [J/m³] that depends only on the volume ratio J."""


@generic
def volumetric_stress(law: Law, J: float) -> float:
    """Return dU/dJ [Pa], the derivative of `volumetric_energy` with respect to the volume ratio J: the mean stress that
    resists a change of volume."""


@generic
def volumetric_stiffness(law: Law, J: float) -> float:
    """Return d²U/dJ² [Pa], the second derivative of `volumetric_energy` with respect to the volume ratio J."""


derive(volumetric_stress, volumetric_energy, lambda U: U.slopes)
derive(volumetric_stiffness, volumetric_energy, lambda U: U.curvatures)


@generic
def isochoric_energy(law: Law, F: Tensor) -> float:
    """Return the isochoric energy W_iso per unit reference volume [J/m³]; it depends on the isochoric part F̄ of the
    deformation gradient F only."""


@generic
def isochoric_stress(law: Law, F: Tensor) -> Symmetric:
    """Return the isochoric Kirchhoff stress ∂W_iso/∂F Fᵀ [Pa] at the deformation gradient F, a deviator."""


@generic
def isochoric_stiffness(law: Law, F: Tensor) -> float:
    """Return the largest d²W_iso(F + ε m⊗Fᵀn)/dε² at ε = 0 over unit vectors m and n [Pa], or an upper bound: the isochoric
    part of ρ₀ c² for the speed c of plane waves."""


@generic
def invariant_energy(law: Law, first: float, second: float) -> float:
    """Return the isochoric energy W_iso of an isotropic law per unit reference volume [J/m³]; first, second: Ī₁ - 3 and
    Ī₂ - 3."""


@generic
def invariant_slopes(law: Law, first: float, second: float) -> tuple[float, float]:
    """Return the derivatives of `invariant_energy` with respect to Ī₁ and Ī₂ [Pa]."""


@generic
def invariant_curvatures(law: Law, first: float, second: float) -> tuple[float, float, float]:
    """Return the second derivatives of `invariant_energy` [Pa]: ∂²/∂Ī₁², ∂²/∂Ī₂² and ∂²/∂Ī₁∂Ī₂."""


@generic
def coupled_energy(law: Law, first: float, second: float, J: float) -> float:
    """Return the strain energy W of an isotropic law per unit reference volume [J/m³]; first, second: I₁ - 3 and I₂ - 3 of
    the left Cauchy-Green tensor; J: volume ratio."""


@generic
def coupled_slopes(law: Law, first: float, second: float, J: float) -> tuple[float, float, float]:
    """Return the derivatives of `coupled_energy` with respect to I₁, I₂ and J [Pa]."""


@generic
def coupled_curvatures(law: Law, first: float, second: float, J: float) -> tuple[float, float, float, float, float, float]:
    """Return the second derivatives of `coupled_energy` [Pa]: ∂²/∂I₁², ∂²/∂I₂², ∂²/∂J², ∂²/∂I₁∂I₂, ∂²/∂I₁∂J and ∂²/∂I₂∂J."""


derive(coupled_slopes, coupled_energy, lambda W: W.slopes)
derive(coupled_curvatures, coupled_energy, lambda W: W.curvatures)
derive(invariant_slopes, invariant_energy, lambda W: W.slopes)
derive(invariant_curvatures, invariant_energy, lambda W: W.curvatures)


def rate_type(law: type[LawType]) -> type[LawType]:
    """Class decorator: register the default functions of laws driven by the velocity gradient.

    Defaults: volume grows by 1 + dt tr L, the pressure is minus the mean stress, and there is no viscosity, artificial
    viscosity or dissipation. Functions registered by the law replace the defaults.
    """
    for operation, shared in DEFAULTS.items():
        point_function(operation, law)(shared)
    return law


def _linear_growth(law, L, dt):
    return 1.0 + dt * (L[0] + L[4] + L[8])


def _no_diffusivity(law, density):
    return 0.0


def _no_dissipation(law, state, density):
    return 0.0


def _no_heating(law, state, density, L, length):
    return 0.0


def _minus_mean_stress(law, state, density):
    return -(state.stress[0] + state.stress[1] + state.stress[2]) / 3.0


DEFAULTS: dict[Callable[..., Any], Callable[..., Any]] = {
    volume_growth: _linear_growth,
    diffusivity: _no_diffusivity,
    dissipated_energy: _no_dissipation,
    artificial_heating: _no_heating,
    point_pressure: _minus_mean_stress,
}
"""Default functions registered by `rate_type`."""
