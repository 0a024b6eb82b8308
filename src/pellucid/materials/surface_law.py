"""Elastic laws of surfaces: energy W per unit initial area [J/m²] as a function of in-plane stretches, moduli [N/m] without
a thickness.

An isotropic law defines W as a function of the principal stretches λ₁, λ₂. Its slopes and curvatures are derived from it
unless the law registers its own, and the functions of the in-plane deformation gradient for kernels follow from them. An
anisotropic law defines these functions itself, for initial axes whose first axis is the `direction` of its material. The
tension per current length is T₁ = (1/λ₂) ∂W/∂λ₁. This module uses τ = J T instead, τ₁ = λ₁ ∂W/∂λ₁, i.e. force times length
per initial area.
"""

from math import exp, log, sqrt

from pellucid.jit import default_function, generic, point_function, pointwise
from pellucid.materials.derivatives import derive, partial_derivatives
from pellucid.materials.law import Law, LawType
from pellucid.materials.membrane import InPlane, Shape, turned_to
from pellucid.materials.membrane_gradient import larger_principal, left_stretch_squared
from pellucid.materials.wrinkling import natural_width

ALIKE = 1e-4  # relative difference of stretches below which they count as equal in a bound on the step
NARROWEST, TOLERANCE, MOST_ITERATIONS = 1e-4, 1e-14, 80  # of a natural width: the least, and its logarithm's change


@generic
def stretch_energy(law: Law, a: float, b: float) -> float:
    """Return the energy W per unit initial area for the principal stretches a, b [J/m²]."""


@generic
def stretch_slopes(law: Law, a: float, b: float) -> tuple[float, float]:
    """Return the slopes ∂W/∂a and ∂W/∂b of the energy with respect to the principal stretches [N/m]."""


@generic
def stretch_curvatures(law: Law, a: float, b: float) -> tuple[float, float, float]:
    """Return the second derivatives ∂²W/∂a², ∂²W/∂b² and ∂²W/∂a∂b of the energy with respect to the principal stretches
    [N/m]."""


derive(stretch_slopes, stretch_energy, lambda W: W.slopes)
derive(stretch_curvatures, stretch_energy, lambda W: W.curvatures)


@generic
def surface_energy(law: Law, F: Shape) -> float:
    """Return the energy W per unit initial area for an in-plane deformation gradient F = (11, 12, 21, 22) [J/m²]."""


@generic
def surface_tension(law: Law, F: Shape) -> InPlane:
    """Return τ = J T in the local frame of a point at an in-plane deformation gradient F, i.e. the tension T times the area
    ratio J: components 11, 22, 12 [N/m]."""


@generic
def surface_stiffness(law: Law, F: Shape) -> float:
    """Return the stiffness [N/m] at an in-plane deformation gradient F that determines the speed of plane waves and,
    multiplied by a sum of squared gradients of shape functions, the frequency of elements. It follows from the tangent of τ
    = J T, the area ratio J times the tension T; the stiffness due to tension is added separately."""


@pointwise
def _principal(F: Shape) -> tuple[InPlane, float, float]:
    """Return the left Cauchy-Green tensor b = F Fᵀ, (11, 22, 12), and the principal stretches, the larger first, of an
    in-plane deformation gradient F."""
    b = left_stretch_squared(F)
    major = sqrt(larger_principal(b))
    return b, major, (F[0] * F[3] - F[1] * F[2]) / major


@default_function(surface_energy)
def _energy(law, F):
    _, major, minor = _principal(F)
    return stretch_energy(law, major, minor)


@default_function(surface_tension)
def _tension(law, F):
    b, major, minor = _principal(F)
    first, second = stretch_slopes(law, major, minor)
    return turned_to(b[0], b[1], b[2], major * first, minor * second)


@default_function(surface_stiffness)
def _stiffness(law, F):
    # the tangent in principal axes: C_iiii = λ_i² W_ii - τ_i, C₁₁₂₂ = λ₁λ₂ W₁₂, C₁₂₁₂ = (λ₂² τ₁ - λ₁² τ₂)/(λ₁² - λ₂²)
    # (Ogden 1984, Non-Linear Elastic Deformations, section 6.1)
    _, major, minor = _principal(F)
    first, second = stretch_slopes(law, major, minor)
    one, two, mixed = stretch_curvatures(law, major, minor)
    tau, other = major * first, minor * second
    c11, c22, c12 = major * major * one - tau, minor * minor * two - other, major * minor * mixed
    x, y = major * major, minor * minor
    apart = x - y
    alike = apart < ALIKE * x
    shear = (y * tau - x * other) / (1.0 if alike else apart)
    shear = 0.25 * (c11 + c22) - 0.5 * c12 if alike else shear
    # m⊗n : C : m⊗n of unit vectors is k p² + d p q + e q² + c₁₂₁₂ (1 - q²), with the cosines p of the difference and q of the
    # sum of their angles; the largest at p = 1, a parabola in q, or where k is below 0 within
    k, d, e = 0.25 * (c11 + c22) + 0.5 * c12, 0.5 * (c11 - c22), 0.25 * (c11 + c22) - 0.5 * c12
    curve = e - shear
    top = k + shear - 0.25 * d * d / (curve if curve < 0.0 else -1.0)
    along = top if curve < 0.0 and abs(d) < -2.0 * curve else max(c11, c22)
    across = e - 0.25 * d * d / (k if k < 0.0 else -1.0) if k < 0.0 and abs(d) < -2.0 * k else e
    # where c₁₁₂₂ exceeds what resists one stretch, elements that stretch both ways at once swing faster than plane waves: with
    # p = c₁₁ + τ by at most ½ (p + c₁₁₂₂) of the sum over both gradients
    pulled = max(tau, other, 0.0)
    both = 0.5 * (max(c11, c22) + abs(c12) - pulled)
    return max(along, across, shear, both, 0.0)


@default_function(natural_width)
def by_search(law, stretch):
    """Return the width of a strip with zero transverse tension, at a stretch along it, relative to its width at rest;
    default for `natural_width`.

    Uses Newton's method for the logarithm of the width, between bounds; the upper bound is the width `stretch`, since a
    sheet that is stretched equally in both directions is in tension.

    """
    low, high = log(NARROWEST), log(stretch)
    y = -0.5 * high
    for _ in range(MOST_ITERATIONS):
        width = exp(y)
        _, slope = stretch_slopes(law, stretch, width)
        _, curvature, _ = stretch_curvatures(law, stretch, width)
        low, high = (low, y) if slope > 0.0 else (y, high)
        growth = slope + width * curvature
        after = y - slope / growth if growth > 0.0 else low
        after = after if low < after < high else 0.5 * (low + high)
        change = after - y
        y = after
        if abs(change) < TOLERANCE:
            break
    return exp(y)


def incompressible(law: type[LawType]) -> type[LawType]:
    """Class decorator for the law of an incompressible sheet, whose thickness λ₃ = 1/(λ₁λ₂) is eliminated: register the width
    of a strip, stretch^(-½), since neither its sides nor its faces carry stress."""
    point_function(natural_width, law)(_incompressible_width)
    return law


def _incompressible_width(law, stretch):
    return 1.0 / sqrt(stretch)


@pointwise
def invariant_excess(a: float, b: float) -> float:
    """Return I - 3, with the first invariant I = a² + b² + 1/(ab)² of an incompressible sheet with the principal stretches
    a, b, accurate also for small values."""
    x, y = (a - 1.0) * (a + 1.0), (b - 1.0) * (b + 1.0)
    J = a * b
    return (x * x + x * y + y * y + x * y * (x + y)) / (J * J)


@partial_derivatives(invariant_excess)
def _invariant_slopes(a, b):
    J = a * b
    inverse = 1.0 / (J * J)
    return 2.0 * (a - inverse / a), 2.0 * (b - inverse / b)
