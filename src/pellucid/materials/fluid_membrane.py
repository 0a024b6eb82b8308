"""Fluid membranes: the in-plane stress depends on the area and the rate of deformation, not on the shape.

The stress times the initial thickness is the surface force: σ = γ + K (1 - 1/A) + λ tr D + 2μ D, where A is the ratio of
the area to the initial area (Scriven 1960, Chem. Eng. Sci. 12, 98, with a linear law of the density 1/A as in Benet 2015,
eq. 3.45). The material is incompressible: its thickness is 1/A times the initial one.
"""

from math import sqrt
from typing import Literal, NamedTuple

import numpy as np

from pellucid.jit import point_function
from pellucid.materials.membrane import (
    damped_rate,
    initial_shape,
    plane_diffusivity,
    plane_response,
    plane_wave_speed,
    stretched,
)
from pellucid.materials.membrane_material import MembraneMaterial
from pellucid.model import check, parameter


class FluidMembrane(NamedTuple):
    """Parameters of the law of a fluid membrane: tension γ [Pa], area stiffness K [Pa], viscosities μ, λ [Pa s]. Each is the
    surface quantity divided by the initial thickness."""

    gamma: float
    K: float
    mu: float
    lam: float


class FluidMembraneMaterial(MembraneMaterial):
    """A membrane that is fluid within its surface: surface tension, stiffness against a change of area, viscosity."""

    kind: Literal["fluid-membrane"] = "fluid-membrane"
    tension: float = parameter("Pa", "surface tension divided by the thickness, γ; independent of the area", 0.0, ge=0)
    stiffness: float = parameter(
        "Pa", "area modulus divided by the thickness, K; adds K (1 - 1/A) to the tension, A: area ratio", 0.0, ge=0
    )
    viscosity: float = parameter("Pa*s", "surface shear viscosity divided by the thickness, μ", 0.0, ge=0)
    dilatational_viscosity: float = parameter("Pa*s", "surface second viscosity divided by the thickness, λ", 0.0, ge=0)

    @check
    def _bears_something(self) -> None:
        if max(self.tension, self.stiffness, self.viscosity, self.dilatational_viscosity) == 0.0:
            raise ValueError("a fluid membrane needs a tension, a stiffness or a viscosity; set one of them")

    def law(self, thickness: float) -> FluidMembrane:
        return FluidMembrane(self.tension, self.stiffness, self.viscosity, self.dilatational_viscosity)

    def recoverable_energy(self, shape: np.ndarray) -> np.ndarray:
        """Return the recoverable energy per unit mass [J/kg], shape (n,): γ (A - 1) + K (A - 1 - ln A) per unit initial
        volume with the area ratio A, divided by the density. shape: in-plane shapes of the points (A and the rate of
        deformation), (n, 4)."""
        area = shape[:, 0]
        return np.asarray((self.tension * (area - 1.0) + self.stiffness * (area - 1.0 - np.log(area))) / self.density)

    def wave_speeds(self, thickness: float = 1.0) -> tuple[float, float]:
        """Return the speed of dilatational (area-changing) waves [m/s], and 0 since there are no shear waves; neither
        depends on the thickness."""
        return sqrt(self.stiffness / self.density), 0.0


@point_function(initial_shape, FluidMembrane)
def _initial_shape(law):
    return (1.0, 0.0, 0.0, 0.0)  # area, and the rate of deformation


@point_function(stretched, FluidMembrane)
def _stretched(law, shape, D, dt):
    return (shape[0] * (1.0 + dt * (D[0] + D[1])), D[0], D[1], D[2])


@point_function(plane_response, FluidMembrane)
def _plane_response(law, shape):
    area = shape[0]
    even = law.gamma + law.K * (1.0 - 1.0 / area) + law.lam * (shape[1] + shape[2])
    two_mu = 2.0 * law.mu
    # the force in the surface is over the initial thickness; the stress is over that now, 1/A of it
    return (
        area * (even + two_mu * shape[1]),
        area * (even + two_mu * shape[2]),
        area * two_mu * shape[3],
        1.0 / area,
    )


@point_function(plane_wave_speed, FluidMembrane)
def _plane_wave_speed(law, shape, density):
    # with the tension σ beside it: along the surface by the change of tension with area, A dσ/dA = K/A, across it by σ itself
    area = shape[0]
    across = law.gamma + law.K * (1.0 - 1.0 / area)
    return sqrt(max(law.K / area - max(across, 0.0), 0.0) * area / density)


@point_function(plane_diffusivity, FluidMembrane)
def _plane_diffusivity(law, shape, density):
    return shape[0] * (2.0 * law.mu + law.lam) / density  # over the thickness that is there


@point_function(damped_rate, FluidMembrane)
def _damped_rate(law, rate, spread):
    return rate if rate > 2.0 * spread else 2.0 * spread
