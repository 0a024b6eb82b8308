"""Surface viscosity of an elastic membrane, in parallel with its elasticity: T + 2μ D + λ tr D I (Kelvin-Voigt).

D is the in-plane rate of deformation; μ and λ [N s/m] are surface viscosities, independent of the thickness (Scriven 1960,
Chem. Eng. Sci. 12, 98). The dissipation per unit area is (2μ D + λ tr D I) : D.
"""

from math import sqrt
from typing import NamedTuple

from pellucid.jit import point_function, pointwise
from pellucid.materials.law import Law
from pellucid.materials.membrane import (
    InPlane,
    around,
    damped_rate,
    plane_diffusivity,
    plane_response,
    record_loss,
    with_viscosity,
)


@around
class ViscousMembrane(NamedTuple):
    """Parameters of an elastic membrane with surface viscosity: elastic law of the membrane, surface viscosities μ and λ [N
    s/m], thickness at rest [m]."""

    law: Law
    mu: float
    lam: float
    thickness: float


@pointwise
def _viscous_stress(law: ViscousMembrane, D: InPlane, ratio: float) -> InPlane:
    inverse = 1.0 / (law.thickness * ratio)
    even, two_mu = inverse * law.lam * (D[0] + D[1]), 2.0 * inverse * law.mu
    return even + two_mu * D[0], even + two_mu * D[1], two_mu * D[2]


@point_function(with_viscosity, ViscousMembrane)
def _with_viscosity(law, stress, D, ratio):
    v11, v22, v12 = _viscous_stress(law, D, ratio)
    return stress[0] + v11, stress[1] + v22, stress[2] + v12


@point_function(record_loss, ViscousMembrane)
def _record_loss(law, dissipated, p, D, ratio, scale):
    v11, v22, v12 = _viscous_stress(law, D, ratio)
    dissipated[p] += scale * (v11 * D[0] + v22 * D[1] + 2.0 * v12 * D[2])


@point_function(plane_diffusivity, ViscousMembrane)
def _plane_diffusivity(law, shape, density):
    return (2.0 * law.mu + law.lam) / (density * law.thickness * plane_response(law.law, shape)[3])


@point_function(damped_rate, ViscousMembrane)
def _damped_rate(law, rate, spread):
    # a mode that swings at ω and fades at β by a force of the step before: dt = 2/(√(ω² + β²/4) + β/2); ω = 2 rate, and
    # momentum that spreads at ν over h fades at 4ν/h² at the most
    return sqrt(rate * rate + spread * spread) + spread
