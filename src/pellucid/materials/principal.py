"""Isotropic functions of a symmetric tensor at a point, from its eigenvalues and without its eigenvectors.

With the mean eigenvalue m, p² = dev a:dev a / 6 and B = dev a / p, the eigenvalues are m + p t with t³ - 3t = det B. One
root is separated from the other two, √3 ≤ |t₁| ≤ 2, and well conditioned. The distance of the other two follows from the
discriminant as a sum of squares (the minors of the rows I, B, B²), so it is accurate to rounding even if they are nearly
equal; the difference of the cubic's terms would lose half of the digits.

An isotropic function f(a) is the polynomial that interpolates f at the eigenvalues, f₂₃ a + f₁₂₃ (a - x₂)(a - x₃) + ...,
with the divided differences f₂₃ = (f₂ - f₃)/(x₂ - x₃), f₁₂₃ = (f₁₂ - f₂₃)/(x₁ - x₃). Their errors are multiplied by factors
that vanish with the distances of the eigenvalues. The result is as accurate for equal eigenvalues as for others, provided
that f₂₃, supplied by the caller, is accurate.

There are no branches and no library calls, and few divisions, so that loops over points are vectorized.
"""

from math import sqrt
from typing import NamedTuple

from pellucid.jit import pointwise
from pellucid.tensors import Symmetric, double_dot, trace

Triple = tuple[float, float, float]
THIRD, SIXTH = 1.0 / 3.0, 1.0 / 6.0
ROUNDING = 2.0**-49
"""Smallest divisor for the deviator, relative to the mean eigenvalue; used if the eigenvalues are nearly equal."""
C0, C1, C2, C3, C4 = 1.73206086, 0.332823444, -0.0918438663, 0.0350243772, -0.00807079743
"""Coefficients of a polynomial that approximates 2 cos(arccos(r)/3), 0 ≤ r ≤ 1, to 1e-5."""


class Spectrum(NamedTuple):
    """Spectrum of a positive tensor a = m I + p B, with the mean eigenvalue m and p² = dev a:dev a / 6: the eigenvalues x₁
    and x₂ ≥ x₃. x₁ is the eigenvalue that is farthest from m, so that it is well separated from the others."""

    values: Triple  # x₁, x₂, x₃
    distance: float  # x₂ - x₃
    first: float  # x₁ - m
    across: tuple[float, float]  # x₁ - x₂ and x₁ - x₃, never 0
    deviator: Symmetric  # p B
    square: Symmetric  # p² dev(B²)


@pointwise
def _outermost_root(r: float) -> float:
    """Return the root of t³ - 3t = 2r between √3 and 2, for 0 ≤ r ≤ 1, by one step of Halley's method."""
    t = C0 + r * (C1 + r * (C2 + r * (C3 + r * C4)))
    f, slope = t * (t * t - 3.0) - 2.0 * r, 3.0 * (t * t - 1.0)
    return t - f * slope / (slope * slope - 3.0 * t * f)


@pointwise
def _discriminant(a: Symmetric, b: Symmetric) -> float:
    """Return the discriminant of a, i.e. the product of the squared differences of its eigenvalues; b: the square of a."""
    xy, yz, zx = (a[0] - a[1], b[0] - b[1]), (a[1] - a[2], b[1] - b[2]), (a[2] - a[0], b[2] - b[0])
    whole = xy[0] * yz[1] - yz[0] * xy[1]
    once = 0.0
    for k in range(3, 6):
        one, two, three = xy[0] * b[k] - a[k] * xy[1], yz[0] * b[k] - a[k] * yz[1], zx[0] * b[k] - a[k] * zx[1]
        once += one * one + two * two + three * three
    one, two, three = a[3] * b[4] - a[4] * b[3], a[4] * b[5] - a[5] * b[4], a[5] * b[3] - a[3] * b[5]
    return whole * whole + 2.0 * once + 12.0 * (one * one + two * two + three * three)


@pointwise
def spectrum(a: Symmetric) -> Spectrum:
    """Return the `Spectrum` of a positive tensor a (6-tuple). If a is not finite, the eigenvalues are not finite."""
    m = trace(a) / 3.0
    s = (a[0] - m, a[1] - m, a[2] - m, a[3], a[4], a[5])
    p, least = sqrt(SIXTH * double_dot(s, s)), ROUNDING * m
    usable = least if p < least else p
    over = 1.0 / usable
    xx, yy, zz, yz, xz, xy = over * s[0], over * s[1], over * s[2], over * s[3], over * s[4], over * s[5]
    square = (
        xx * xx + xy * xy + xz * xz,
        xy * xy + yy * yy + yz * yz,
        xz * xz + yz * yz + zz * zz,
        xy * xz + yy * yz + yz * zz,
        xx * xz + xy * yz + xz * zz,
        xx * xy + xy * yy + xz * yz,
    )
    B = (xx, yy, zz, yz, xz, xy)
    r = SIXTH * double_dot(B, square)
    size = 1.0 if abs(r) > 1.0 else abs(r)
    t = _outermost_root(size)
    distance = p * sqrt(_discriminant(B, square)) / (3.0 * (t * t - 1.0))
    t = -t if r < 0.0 else t
    first, apart, pp, mean = p * t, 1.5 * usable * t, p * p, THIRD * trace(square)
    return Spectrum(
        (m + first, m + 0.5 * (distance - first), m - 0.5 * (distance + first)),
        distance,
        first,
        (apart - 0.5 * distance, apart + 0.5 * distance),
        s,
        (
            pp * (square[0] - mean),
            pp * (square[1] - mean),
            pp * (square[2] - mean),
            pp * square[3],
            pp * square[4],
            pp * square[5],
        ),
    )


@pointwise
def isotropic_deviator(of: Spectrum, apart: float, slope: float) -> Symmetric:
    """Return dev f(a), the deviator of an isotropic function f of a tensor a with the given spectrum (eigenvalues x₁, x₂,
    x₃); apart: f(x₁) - f(x₂); slope: (f(x₂) - f(x₃))/(x₂ - x₃), or f'(x₂) if both are equal."""
    bend = (apart - slope * of.across[0]) / (of.across[0] * of.across[1])
    slope += bend * of.first  # of a, in (a - x₂)(a - x₃) too
    s, q = of.deviator, of.square
    return (
        slope * s[0] + bend * q[0],
        slope * s[1] + bend * q[1],
        slope * s[2] + bend * q[2],
        slope * s[3] + bend * q[3],
        slope * s[4] + bend * q[4],
        slope * s[5] + bend * q[5],
    )
