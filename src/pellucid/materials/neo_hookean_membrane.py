"""Compressible neo-Hookean membrane, W = μ/2 (I₁-3) - μ ln J + λ/2 (ln J)², with the thickness from zero transverse stress."""

from math import exp, log, sqrt
from typing import Literal, NamedTuple

from pellucid.jit import point_function, pointwise
from pellucid.materials.elastic import ElasticMembraneMaterial, lame
from pellucid.materials.law import energy
from pellucid.materials.membrane import plane_response, plane_wave_speed
from pellucid.materials.membrane_gradient import by_gradient
from pellucid.materials.wrinkling import natural_width

TOLERANCE = 1e-14  # on the squared thickness stretch
MOST_ITERATIONS = 50


@by_gradient
class NeoHookeanMembrane(NamedTuple):
    """Parameters of the compressible neo-Hookean law of a membrane: Lamé's constants [Pa]."""

    lam: float
    mu: float


class NeoHookeanMembraneMaterial(ElasticMembraneMaterial):
    """Compressible neo-Hookean membrane in plane stress, for any strain."""

    kind: Literal["neo-hookean-membrane"] = "neo-hookean-membrane"

    def elastic_law(self) -> NeoHookeanMembrane:
        return NeoHookeanMembrane(*lame(self.young_modulus, self.poisson_ratio))


@pointwise
def _free_stretch_squared(law, held, share):
    """Return the squared stretch c in the stress-free directions, from μ (c - 1) + λ (ln held + share ln c) = 0 with Lamé's
    constants λ, μ of the law.

    held: product of the given stretches; share: exponent of c in the volume ratio J = held c^share. Newton's method in ln
    c, which converges monotonically.
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
    """Return the squared ratio of the thickness of a membrane to its thickness at rest, for a ratio `area` of present to
    initial area."""
    return _free_stretch_squared(law, area, 0.5)


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


@point_function(natural_width, NeoHookeanMembrane)
def _natural_width(law, stretch):
    return sqrt(_free_stretch_squared(law, stretch, 1.0))
