"""The functions of a law at a point: kernels and plain Python call the same ones.

A law is a NamedTuple of its parameters. The state of a point under it is a NamedTuple too, declared with
`pellucid.materials.point_state`; every state has a `stress` (Cauchy, 6-tuple xx, yy, zz, yz, xz, xy) [Pa].

Material points ask for the rate form: `update` and what stands beside it. `rate_type` registers what most laws have in
common, so that a law only registers what it has of its own. A hyperelastic law is stated by `energy`, `cauchy_stress` and
`wave_speed` as functions of the deformation gradient; `pellucid.materials.hyperelastic` derives its rate form.

Divisions are slow. The functions of a point become one loop, in which 1 / density is found once, where all of them multiply
by it; the inverse of a parameter is found before the loop.
"""

from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from pellucid.jit import generic, point_function
from pellucid.materials.point_state import PointState
from pellucid.tensors import PlaneTensor, Symmetric, Tensor

ZERO_GRADIENT = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
SQUEEZED = (-1e-300, 0.0, 0.0, 0.0, -1e-300, 0.0, 0.0, 0.0, -1e-300)
"""Velocity gradients [1/s]: none, and one of which only the sign counts."""


class Law(Protocol):
    """A law as kernels take it: a NamedTuple of its parameters."""

    @property
    def _fields(self) -> tuple[str, ...]: ...


LawType = TypeVar("LawType", bound=Law)


@generic
def update(law: Law, state: PointState, density: float, L: Tensor, dt: float, length: float) -> PointState:
    """The state after a step dt [s] with velocity gradient L [1/s].

    density: at the end of the step [kg/m³]; length: that of a grid cell [m], for artificial viscosity.
    """


@generic
def volume_growth(law: Law, L: Tensor, dt: float) -> float:
    """Volume after the step over volume before, consistent with how the law integrates L."""


@generic
def signal_speed(law: Law, state: PointState, density: float, L: Tensor, length: float) -> float:
    """Fastest signal relative to the material [m/s], artificial viscosity included: it bounds the step."""


@generic
def diffusivity(law: Law, density: float) -> float:
    """Kinematic viscosity (2μ + λ)/ρ of plane waves [m²/s]."""


@generic
def stored_energy(law: Law, state: PointState, density: float) -> float:
    """Internal or strain energy of unit mass [J/kg]."""


@generic
def dissipated_energy(law: Law, state: PointState, density: float) -> float:
    """The part of the work of the stress on unit mass that was lost so far [J/kg], of laws that tell it apart from what they
    store: `stored_energy` is without it."""


@generic
def artificial_heating(law: Law, state: PointState, density: float, L: Tensor, length: float) -> float:
    """Power of the artificial viscosity on unit mass [W/kg]; part of the internal energy's rate, recorded apart."""


@generic
def point_pressure(law: Law, state: PointState, density: float) -> float:
    """Pressure [Pa] that results show: of a fluid that of its equation of state, of a solid minus the mean stress."""


@generic
def energy(law: Law, F: Tensor | PlaneTensor) -> float:
    """Strain energy W of unit reference volume [J/m³] at the deformation gradient F: a 9-tuple, in the plane of a membrane
    the 4-tuple (11, 12, 21, 22)."""


@generic
def cauchy_stress(law: Law, F: Tensor) -> Symmetric:
    """Cauchy stress σ = 1/J ∂W/∂F Fᵀ [Pa]."""


@generic
def first_piola_kirchhoff(law: Law, F: Tensor) -> Tensor:
    """First Piola-Kirchhoff stress P = ∂W/∂F [Pa]: force in the current by area in the reference configuration."""


@generic
def energy_and_stress(law: Law, F: Tensor) -> tuple[float, Tensor]:
    """`energy` and `first_piola_kirchhoff` together; a law registers it where both come from the same costly numbers."""


@generic
def wave_speed(law: Law, F: Tensor) -> float:
    """Fastest plane wave relative to the material in the current configuration [m/s], or a bound above it."""


@generic
def volumetric_energy(law: Law, J: float) -> float:
    """The part U(J) of the strain energy of unit reference volume [J/m³] that depends on the volume ratio alone."""


@generic
def volumetric_stress(law: Law, J: float) -> float:
    """dU/dJ [Pa], the mean stress that resists a change of volume."""


def rate_type(law: type[LawType]) -> type[LawType]:
    """Class decorator: register for a law what most laws driven by the velocity gradient share.

    Volume grows by 1 + dt tr L, the pressure is minus the mean stress, and there is neither viscosity nor artificial
    viscosity, and nothing is dissipated. What the law registers of its own stands instead.
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
"""What `rate_type` registers."""
