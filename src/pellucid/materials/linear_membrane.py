"""Linear elastic membrane in plane stress, σ'₁₁ = E/(1-ν²) (ε'₁₁ + ν ε'₂₂) etc. Source: Gan et al. 2011, eqs. 1, 2 in
reduced form.

The strain ε' is accumulated in a frame that rotates with the material; the stress σ' is in the same frame. The thickness
strain is -ν/(1-ν) tr ε'.
"""

from math import exp, log, sqrt
from typing import ClassVar, Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.elastic import ElasticMembraneMaterial
from pellucid.materials.law import energy
from pellucid.materials.membrane import (
    initial_shape,
    largest_strain,
    plane_response,
    plane_wave_speed,
    shape_of,
    smoothed,
    stretched,
    stretched_midway,
    turned_to,
)
from pellucid.materials.wrinkling import unwrinkled


class LinearMembrane(NamedTuple):
    """Parameters of the linear elastic membrane: Young's modulus [Pa] and Poisson's ratio."""

    E: float
    nu: float


class LinearMembraneMaterial(ElasticMembraneMaterial):
    """Linear elastic membrane in plane stress, for small strains and any rotation."""

    has_energy: ClassVar[bool] = False

    kind: Literal["linear-membrane"] = "linear-membrane"

    def elastic_law(self) -> LinearMembrane:
        return LinearMembrane(self.young_modulus, self.poisson_ratio)


@point_function(initial_shape, LinearMembrane)
def _initial_shape(law):
    return (0.0, 0.0, 0.0, 0.0)


@point_function(stretched, LinearMembrane)
@point_function(stretched_midway, LinearMembrane)
def _stretched(law, shape, D, dt):
    return (shape[0] + dt * D[0], shape[1] + dt * D[1], shape[2] + dt * D[2], 0.0)


@point_function(shape_of, LinearMembrane)
def _shape_of(law, axes, major, minor):
    e11, e22, e12 = turned_to(axes[0], axes[1], axes[2], log(major), log(minor))
    return (e11, e22, e12, 0.0)


@point_function(smoothed, LinearMembrane)
def _smoothed(law, shape, major, minor):
    return major, minor


@point_function(plane_response, LinearMembrane)
def _plane_response(law, shape):
    C = law.E / (1.0 - law.nu * law.nu)
    ratio = 1.0 - law.nu / (1.0 - law.nu) * (shape[0] + shape[1])
    return (
        C * (shape[0] + law.nu * shape[1]),
        C * (shape[1] + law.nu * shape[0]),
        law.E / (1.0 + law.nu) * shape[2],
        ratio,
    )


@point_function(energy, LinearMembrane)
def _energy(law, F):
    # F holds the strains, and this is the work of straining in proportion: ∫ J(s) s σ:ε ds with J = exp(s t) (1 - s t ν/(1-ν))
    # and t = tr ε, by three points of Gauss. On other paths it differs in the third order: the law is for small strains
    s11, s22, s12, _ = plane_response(law, F)
    trace, thinner = F[0] + F[1], law.nu / (1.0 - law.nu)
    mean = 0.0
    for s, weight in ((0.1127016653792583, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.8872983346207417, 5.0 / 18.0)):
        mean += weight * s * exp(s * trace) * (1.0 - s * trace * thinner)
    return mean * (s11 * F[0] + s22 * F[1] + 2.0 * s12 * F[2])


@point_function(largest_strain, LinearMembrane)
def _largest_strain(law, shape):
    half = 0.5 * (shape[0] - shape[1])
    return 0.5 * (shape[0] + shape[1]) + sqrt(half * half + shape[2] * shape[2])


@point_function(plane_wave_speed, LinearMembrane)
def _plane_wave_speed(law, shape, density):
    return sqrt(law.E / ((1.0 - law.nu * law.nu) * density))


@point_function(unwrinkled, LinearMembrane)
def _unwrinkled(law, shape):
    half = 0.5 * (shape[0] - shape[1])
    mean, radius = 0.5 * (shape[0] + shape[1]), sqrt(half * half + shape[2] * shape[2])
    major, minor = mean + radius, mean - radius
    if major <= 0.0:
        return (0.0, 0.0, 0.0, 0.0), exp(-major - minor)
    natural = -law.nu * major
    if minor >= natural:
        return shape, 1.0
    e11, e22, e12 = turned_to(shape[0], shape[1], shape[2], major, natural)
    # strains add up rates, so that what is missing of the width is a logarithm
    return (e11, e22, e12, 0.0), exp(natural - minor)
