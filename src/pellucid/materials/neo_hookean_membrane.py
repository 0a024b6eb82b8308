"""Compressible neo-Hookean membrane, W = μ/2 (I₁-3) - μ ln J + λ/2 (ln J)²; its thickness leaves no stress across it."""

from math import exp, log, sqrt
from typing import Literal, NamedTuple

from pellucid.jit import point_function, pointwise
from pellucid.materials.elastic import lame
from pellucid.materials.elastic_membrane import ElasticMembraneMaterial
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

TOLERANCE = 1e-14  # on the squared thickness stretch
MOST_ITERATIONS = 50


class NeoHookeanMembrane(NamedTuple):
    """Lamé's constants [Pa]."""

    lam: float
    mu: float


class NeoHookeanMembraneMaterial(ElasticMembraneMaterial):
    """Compressible neo-Hookean membrane in plane stress, for any strain."""

    kind: Literal["neo-hookean-membrane"] = "neo-hookean-membrane"

    def elastic_law(self) -> NeoHookeanMembrane:
        """Its Lamé constants."""
        return NeoHookeanMembrane(*lame(self.young_modulus, self.poisson_ratio))


@point_function(initial_shape, NeoHookeanMembrane)
def _initial_shape(law):
    return (1.0, 0.0, 0.0, 1.0)


@point_function(stretched, NeoHookeanMembrane)
def _stretched(law, shape, D, dt):
    F = shape
    # F = (I + dt D) F in the frame, which has taken the rotation
    return (
        F[0] + dt * (D[0] * F[0] + D[2] * F[2]),
        F[1] + dt * (D[0] * F[1] + D[2] * F[3]),
        F[2] + dt * (D[2] * F[0] + D[1] * F[2]),
        F[3] + dt * (D[2] * F[1] + D[1] * F[3]),
    )


@point_function(stretched_midway, NeoHookeanMembrane)
def _stretched_midway(law, shape, D, dt):
    # F = (I - ½ dt D)⁻¹ (I + ½ dt D) F: with A = (I - ½ dt D)⁻¹ D, which commutes with D, it is (I + dt A) F
    half = 0.5 * dt
    spread = D[0] * D[1] - D[2] * D[2]
    scale = 1.0 / (1.0 - half * (D[0] + D[1]) + half * half * spread)
    return stretched(law, shape, (scale * (D[0] - half * spread), scale * (D[1] - half * spread), scale * D[2]), dt)


@pointwise
def _free_stretch_squared(law, held, share):
    """c = (stretch of the directions that bear no stress)² from μ (c - 1) + λ (ln held + share ln c) = 0.

    held: the part of the volume ratio that is given, J = held c^share. Newton's method in ln c, which is monotone.
    """
    y = 0.0
    for _ in range(MOST_ITERATIONS):
        c = exp(y)
        change = (law.mu * (c - 1.0) + law.lam * (log(held) + share * y)) / (law.mu * c + share * law.lam)
        y -= change
        if abs(change) < TOLERANCE:
            break
    return exp(y)


@pointwise
def _thickness_squared(law, area):
    """(thickness stretch)² of a membrane at a ratio of area."""
    return _free_stretch_squared(law, area, 0.5)


@point_function(shape_of, NeoHookeanMembrane)
def _shape_of(law, axes, major, minor):
    U11, U22, U12 = turned_to(axes[0], axes[1], axes[2], major, minor)
    return (U11, U12, U12, U22)


@point_function(smoothed, NeoHookeanMembrane)
def _smoothed(law, shape, major, minor):
    return major, minor


@point_function(plane_response, NeoHookeanMembrane)
def _plane_response(law, shape):
    F = shape
    area = F[0] * F[3] - F[1] * F[2]
    c = _thickness_squared(law, area)
    J = area * sqrt(c)
    m = law.mu / J
    normal = (law.lam * log(J) - law.mu) / J
    return (
        m * (F[0] * F[0] + F[1] * F[1]) + normal,
        m * (F[2] * F[2] + F[3] * F[3]) + normal,
        m * (F[0] * F[2] + F[1] * F[3]),
        sqrt(c),
    )


@point_function(energy, NeoHookeanMembrane)
def _energy(law, F):
    area = F[0] * F[3] - F[1] * F[2]
    c = _thickness_squared(law, area)
    ln_J = log(area * sqrt(c))
    I1 = F[0] * F[0] + F[1] * F[1] + F[2] * F[2] + F[3] * F[3] + c
    return 0.5 * law.mu * (I1 - 3.0) - law.mu * ln_J + 0.5 * law.lam * ln_J * ln_J


@point_function(largest_strain, NeoHookeanMembrane)
def _largest_strain(law, shape):
    F = shape
    # the larger singular value of F is the sum of the radii of its turning and its reflecting part
    turning = sqrt((F[0] + F[3]) * (F[0] + F[3]) + (F[2] - F[1]) * (F[2] - F[1]))
    reflecting = sqrt((F[0] - F[3]) * (F[0] - F[3]) + (F[1] + F[2]) * (F[1] + F[2]))
    return log(0.5 * (turning + reflecting))


@point_function(plane_wave_speed, NeoHookeanMembrane)
def _plane_wave_speed(law, shape, density):
    F = shape
    area = F[0] * F[3] - F[1] * F[2]
    c = _thickness_squared(law, area)
    # no stress across leaves μ - λ ln J = μ c; with that the tangent of the Kirchhoff stress, λ I⊗I + 2(μ - λ ln J) 𝕀, becomes
    # one of plane stress, isotropic, E/(1-ν²) at rest
    m = law.mu * c
    stiffness = max(4.0 * m * (law.lam + m) / (law.lam + 2.0 * m), m)
    return sqrt(stiffness / (area * sqrt(c) * density))


@pointwise
def _natural_width_squared(law, stretch):
    """(width stretch)² = (thickness stretch)² of a strip pulled to a stretch."""
    return _free_stretch_squared(law, stretch, 1.0)


@point_function(unwrinkled, NeoHookeanMembrane)
def _unwrinkled(law, shape):
    F = shape
    # squares of the principal stretches, from the left Cauchy-Green tensor
    b11, b22, b12 = F[0] * F[0] + F[1] * F[1], F[2] * F[2] + F[3] * F[3], F[0] * F[2] + F[1] * F[3]
    half = 0.5 * (b11 - b22)
    major = 0.5 * (b11 + b22) + sqrt(half * half + b12 * b12)
    area = F[0] * F[3] - F[1] * F[2]
    if major <= 1.0:
        return (1.0, 0.0, 0.0, 1.0), 1.0 / area
    stretch = sqrt(major)
    c = _natural_width_squared(law, stretch)
    if area * area >= c * major:
        return shape, 1.0
    width = sqrt(c)
    v11, v22, v12 = turned_to(b11, b22, b12, stretch, width)
    return (v11, v12, v12, v22), stretch * width / area
