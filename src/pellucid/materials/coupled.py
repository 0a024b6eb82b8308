"""Isotropic hyperelastic solids stated by their energy alone, W(I₁ - 3, I₂ - 3, J): I₁ = tr b, I₂ = tr B, b = FFᵀ, B = cof b.

Shear and volume may be coupled, unlike in `decoupled`. Stress and wave speed follow from the energy. With W₁, W₂, W_J for its
slopes and the Cayley-Hamilton theorem (Holzapfel 2000, Nonlinear Solid Mechanics, section 6.2) the Kirchhoff stress is

    τ = 2 W₁ (b - I) - 2 W₂ (B - I) + (2 W₁ + 4 W₂ + 2 W₂ (I₂ - 3) + J W_J) I ,

whose three terms are small at small strain. Along F + ε m⊗Fᵀn with unit vectors m and n, a = m·n, and e perpendicular to n,
m = a n + s e, the second derivatives are I₁'' = 2 n·bn, ½ I₂'' = a² (tr B - n·Bn) + s² e·Be and J'' = 0. The first ones are
I₁' = m·A₁n, I₂' = m·A₂n, J' = m·A₃n with A₁ = 2 b, A₂ = 2 (tr B I - B), A₃ = J I, so that for principal values A_ki the
products of the first derivatives are a quadratic form xᵀHx of x_i = m_i n_i with ∑|x_i| ≤ 1 and H_ij = ∑ W_kl A_ki A_lj.
It is at most the largest of H_ii and |H_ij|. The sum of the bounds is ρ₀ c²; negative ones, of a law that is unstable at this
strain, count as zero.

The volumetric energy, which meshless solids average, is that of a uniform dilatation, unless the law registers another one.
"""

from collections.abc import Callable, Mapping, Sequence
from math import sqrt
from typing import Any

from pellucid.jit import pointwise
from pellucid.jit.elementary import expm1, log
from pellucid.materials.decoupled import ElasticModuli, principal_bounds
from pellucid.materials.derivatives import Energy, derive
from pellucid.materials.law import (
    Law,
    cauchy_stress,
    coupled_curvatures,
    coupled_energy,
    coupled_slopes,
    energy,
    volumetric_energy,
    volumetric_stress,
    wave_speed,
)
from pellucid.materials.principal import spectrum
from pellucid.materials.trial import Operation
from pellucid.tensors import Symmetric, Tensor, cofactor, determinant, left_cauchy_green, trace


class CoupledMaterial(ElasticModuli):
    """Base of isotropic hyperelastic solids whose law registers `coupled_energy`."""

    def moduli(self) -> tuple[float, float]:
        law = self.law()
        one, two, _ = coupled_slopes(law, 0.0, 0.0, 1.0)
        w11, w22, w33, w12, w13, w23 = coupled_curvatures(law, 0.0, 0.0, 1.0)
        mu = 2.0 * (one + two)
        along = 2.0 * one + 4.0 * two + 4.0 * w11 + 16.0 * w22 + w33 + 16.0 * w12 + 4.0 * w13 + 8.0 * w23
        return mu, along - 4.0 / 3.0 * mu

    def operations(self, law: Law) -> Mapping[Law, Sequence[Operation]]:
        return {law: (*super().operations(law)[law], volumetric_energy, volumetric_stress)}


@pointwise
def _invariants(F: Tensor) -> tuple[float, Symmetric, Symmetric, float, float]:
    """Return J, b = F Fᵀ and its cofactor B, I₁ - 3 and I₂ - 3."""
    b, B = left_cauchy_green(F), left_cauchy_green(cofactor(F))
    return determinant(F), b, B, trace(b) - 3.0, trace(B) - 3.0


def _energy(law, F):
    J, _, _, first, second = _invariants(F)
    return coupled_energy(law, first, second, J)


def _stress(law, F):
    J, b, B, first, second = _invariants(F)
    one, two, by_J = coupled_slopes(law, first, second, J)
    over = 1.0 / J
    p, q = 2.0 * one * over, 2.0 * two * over
    mean = p + 2.0 * q + q * second + by_J
    return (
        p * (b[0] - 1.0) - q * (B[0] - 1.0) + mean,
        p * (b[1] - 1.0) - q * (B[1] - 1.0) + mean,
        p * (b[2] - 1.0) - q * (B[2] - 1.0) + mean,
        p * b[3] - q * B[3],
        p * b[4] - q * B[4],
        p * b[5] - q * B[5],
    )


def _wave_speed_apart(law, F):
    # without mixed derivatives H is a sum of squares: bounds of the principal values are enough
    J, b, B, first, second = _invariants(F)
    one, two, _ = coupled_slopes(law, first, second, J)
    w11, w22, w33, _, _, _ = coupled_curvatures(law, first, second, J)
    (high, _), (highest, lowest), whole = principal_bounds(b), principal_bounds(B), trace(B)
    most = max(whole - lowest, highest)
    linear = max(one * high, 0.0) + max(two * most, 0.0)
    squares = 4.0 * max(w11, 0.0) * high * high + 4.0 * max(w22, 0.0) * most * most + max(w33, 0.0) * J * J
    return sqrt((2.0 * linear + squares) / law.rho0)


def _wave_speed(law, F):
    J, b, _, first, second = _invariants(F)
    one, two, _ = coupled_slopes(law, first, second, J)
    of = coupled_curvatures(law, first, second, J)
    x, y, z = spectrum(b).values
    X, Y, Z = y * z, z * x, x * y
    linear = max(one, 0.0) * max(x, y, z) + max(two, 0.0) * max(Y + Z, Z + X, X + Y)
    xx, yy, zz = _product(of, J, x, x, Y + Z, Y + Z), _product(of, J, y, y, Z + X, Z + X), _product(of, J, z, z, X + Y, X + Y)
    xy, yz = abs(_product(of, J, x, y, Y + Z, Z + X)), abs(_product(of, J, y, z, Z + X, X + Y))
    zx = abs(_product(of, J, z, x, X + Y, Y + Z))
    return sqrt((2.0 * linear + max(xx, yy, zz, xy, yz, zx)) / law.rho0)


@pointwise
def _product(of: tuple[float, ...], J: float, b: float, d: float, c: float, e: float) -> float:
    """Return H_ij from the second derivatives of W, J, the principal values b, d of b and c, e of tr B I - B."""
    w11, w22, w33, w12, w13, w23 = of
    squares = 4.0 * (w11 * b * d + w22 * c * e + w12 * (b * e + c * d)) + w33 * J * J
    return squares + 2.0 * J * (w13 * (b + d) + w23 * (c + e))


def _dilatation_energy(law, J):
    by = 2.0 / 3.0 * log(J)
    return coupled_energy(law, 3.0 * expm1(by), 3.0 * expm1(2.0 * by), J)


def _wave_speed_of(W: Energy) -> Callable[..., Any]:
    return _wave_speed_apart if all(term.operation == 0.0 for term in W.curvatures[3:]) else _wave_speed


derive(energy, coupled_energy, lambda W: _energy)
derive(cauchy_stress, coupled_energy, lambda W: _stress)
derive(wave_speed, coupled_energy, _wave_speed_of)
derive(volumetric_energy, coupled_energy, lambda W: _dilatation_energy)
