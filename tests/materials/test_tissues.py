"""Mooney-Rivlin, Ogden, Holzapfel-Gasser-Ogden: closed forms of simple states, what they reduce to, and their wave speeds."""

from typing import NamedTuple

import numpy as np
import pytest
from algebra import eigen, matrix, rotation, tensor
from pydantic import ValidationError
from samples import BULK, SPECIAL, material_of

from pellucid.jit import point_function
from pellucid.materials.decoupled import decoupled
from pellucid.materials.law import (
    cauchy_stress,
    energy,
    invariant_energy,
    isochoric_energy,
    isochoric_stiffness,
    isochoric_stress,
    wave_speed,
)
from pellucid.tensors import IDENTITY

every_seed = pytest.mark.parametrize("seed", range(4))
every_stretch = pytest.mark.parametrize("stretch", [0.3, 0.8, 1.0, 1.0 + 1e-9, 1.3, 2.5])
MOONEY, OGDEN = material_of("mooney-rivlin", SPECIAL["mooney-rivlin"]), material_of("ogden", SPECIAL["ogden"])
C1, C2 = 2e3, 1e3
ISOCHORIC = {
    "decoupled-neo-hookean": material_of(
        "decoupled-neo-hookean", {"density": 1100.0, "young_modulus": 1e4, "poisson_ratio": 0.3}
    ),
    "mooney-rivlin": MOONEY,
    "second-invariant": material_of("mooney-rivlin", BULK | {"c1": 0.0, "c2": 1e3}),
    "ogden": OGDEN,
    "steep-ogden": material_of("ogden", BULK | {"shear_moduli": [10.0, -5.0], "exponents": [9.0, -7.0]}),
}


def fibrous(**changes):
    return material_of("holzapfel-gasser-ogden", SPECIAL["holzapfel-gasser-ogden"] | changes)


def gradient(seed, size=0.4):
    return np.eye(3) + np.random.default_rng(seed).uniform(-size, size, (3, 3))


def difference(material, stretches, turn=None):
    """σ₁ - σ₃ [Pa] along turned axes at principal stretches whose product is 1."""
    Q = np.eye(3) if turn is None else turn
    stress = Q.T @ matrix(cauchy_stress(material.law(), tensor(Q @ np.diag(stretches) @ Q.T))) @ Q
    assert stress == pytest.approx(np.diag(np.diag(stress)), abs=1e-9 * max(1.0, abs(stress).max()))
    return stress[0, 0] - stress[2, 2]


def uniaxial(stretch):
    return stretch, stretch**-0.5, stretch**-0.5


def equibiaxial(stretch):
    return stretch, stretch, stretch**-2.0


@every_stretch
def test_mooney_rivlin_in_uniaxial_and_equibiaxial_extension(stretch):
    """σ₁ - σ₃ = 2 (λ₁² - λ₃²) (c₁ + λ₂² c₂). Source: Rivlin 1948, Philos. Trans. R. Soc. A 241, 379."""
    for stretches in (uniaxial(stretch), equibiaxial(stretch)):
        a, b, c = stretches
        expected = 2.0 * (a * a - c * c) * (C1 + b * b * C2)
        found = difference(MOONEY, stretches, rotation(1))
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-10 * C1)


@every_stretch
def test_ogden_in_uniaxial_and_equibiaxial_extension(stretch):
    """σ₁ - σ₃ = Σ μ_p (λ₁^α_p - λ₃^α_p). Source: Ogden 1972, Proc. R. Soc. Lond. A 328, 567."""
    for stretches in (uniaxial(stretch), equibiaxial(stretch)):
        terms = zip(OGDEN.shear_moduli, OGDEN.exponents, strict=True)
        expected = sum(mu * (stretches[0] ** alpha - stretches[2] ** alpha) for mu, alpha in terms)
        found = difference(OGDEN, stretches, rotation(1))
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-10 * 6e3)


@every_seed
def test_ogden_with_an_exponent_of_2_is_neo_hookean_and_with_2_and_minus_2_mooney_rivlin(seed):
    F = tensor(gradient(seed))
    neo = material_of("decoupled-neo-hookean", {"density": 1100.0, "young_modulus": 9e3, "poisson_ratio": 0.4})
    mu, kappa = neo.moduli()
    table = {"density": 1100.0, "bulk_modulus": kappa, "shear_moduli": [mu], "exponents": [2.0]}
    pairs = [(material_of("ogden", table), neo)]
    table = BULK | {"shear_moduli": [2.0 * C1, -2.0 * C2], "exponents": [2.0, -2.0]}
    pairs.append((material_of("ogden", table), MOONEY))
    pairs.append((material_of("mooney-rivlin", {"density": 1100.0, "c1": 0.5 * mu, "c2": 0.0, "bulk_modulus": kappa}), neo))
    for one, other in pairs:
        assert one.moduli() == pytest.approx(other.moduli(), rel=1e-14)
        assert energy(one.law(), F) == pytest.approx(energy(other.law(), F), rel=1e-12)
        assert cauchy_stress(one.law(), F) == pytest.approx(cauchy_stress(other.law(), F), rel=1e-11, abs=1e-10 * kappa)


@pytest.mark.parametrize("apart", [0.0, 1e-15, 1e-12, 1e-9, 1e-8, 3e-8, 1e-6, 1e-3])
@pytest.mark.parametrize("pair", [(1.0, 1.0), (1.6, 0.4), (0.4, 1.6)])
def test_ogden_where_stretches_are_nearly_equal(apart, pair):
    """Exponents of 4 and -4 need no eigenvalues: τ = dev(Σ μ_p b̄^(α_p/2))."""
    table = BULK | {"shear_moduli": [3e3, -2e3], "exponents": [4.0, -4.0]}
    law = material_of("ogden", table).law()
    one, other = pair
    for seed in range(3):
        Q, R = rotation(seed), rotation(seed + 9)
        F = Q @ np.diag([one, other, other * (1.0 + apart)]) @ R
        b = F @ F.T * np.linalg.det(F) ** (-2.0 / 3.0)
        power = 3e3 * b @ b - 2e3 * np.linalg.inv(b @ b)
        exact = power - np.trace(power) / 3.0 * np.eye(3)
        size = 3e3 + abs(power).max()
        assert matrix(isochoric_stress(law, tensor(F))) == pytest.approx(exact, abs=2e-14 * size)
        W = 750.0 * (np.trace(b @ b) - 3.0) + 500.0 * (np.trace(np.linalg.inv(b @ b)) - 3.0)
        assert isochoric_energy(law, tensor(F)) == pytest.approx(W, abs=2e-14 * size)
        assert isochoric_stiffness(law, tensor(F)) < 1e3 * size


@pytest.mark.parametrize(
    ("stretches", "error"),
    [
        ((1.0, 1.0, 1.0), 1e-14),
        ((1.0, 1.0 + 1e-9, 1.0 - 1e-10), 1e-14),
        ((1.3, 1.0, 0.8), 1e-14),
        ((1.7, 0.6, 0.6 + 1e-13), 1e-14),
        ((0.4, 1.6, 1.6 + 1e-8), 1e-14),
        ((6.0, 0.5, 0.3), 5e-13),  # rounding of b over its smallest eigenvalue, as in the next ones
        ((0.05, 1.0, 1.2), 5e-13),
        ((10.0, 1.0, 0.1), 2e-12),
    ],
)
@pytest.mark.parametrize("name", ["ogden", "steep-ogden"])
def test_ogden_beside_principal_axes_with_more_digits(name, stretches, error):
    law = ISOCHORIC[name].law()
    for seed in range(4):
        F = rotation(seed) @ np.diag(stretches) @ rotation(seed + 9)
        x, Q = eigen(F.astype(np.longdouble) @ F.T.astype(np.longdouble))
        strain = 0.5 * np.log(x) - np.log(x).sum() / 6.0
        terms = [(mu, alpha, np.exp(alpha * strain)) for mu, alpha in zip(law.moduli, law.exponents, strict=True)]
        principal = sum(mu * power for mu, _, power in terms)
        exact = Q * (principal - principal.mean()) @ Q.T
        size = float(abs(principal).max())
        assert matrix(isochoric_stress(law, tensor(F))) == pytest.approx(exact.astype(float), abs=error * size)
        W = sum(mu / alpha * (power.sum() - 3.0) for mu, alpha, power in terms)
        assert isochoric_energy(law, tensor(F)) == pytest.approx(float(W), abs=error * size)


def sampled_stiffness(law, F, step=1e-4):
    """The largest d²W_iso(F + ε m⊗Fᵀn)/dε² over all m and many n, by differences."""

    def stored(m, n):
        return isochoric_energy(law, tensor((np.eye(3) + step * np.outer(m, n)) @ F))

    numbers, axes = np.random.default_rng(0), np.eye(3)
    largest = -np.inf
    for n in [v / np.linalg.norm(v) for v in (*axes, *numbers.normal(size=(40, 3)))]:
        hessian = np.zeros((3, 3))
        for i, j in np.ndindex(3, 3):
            p, q = axes[i], axes[j]
            hessian[i, j] = stored(p + q, n) - stored(p - q, n) - stored(q - p, n) + stored(-p - q, n)
        largest = max(largest, np.linalg.eigvalsh(hessian)[-1] / (4.0 * step**2))
    return largest


@pytest.mark.parametrize("name", ISOCHORIC)
def test_the_isochoric_stiffness_is_exact_at_rest_and_a_bound_elsewhere(name):
    material = ISOCHORIC[name]
    law = material.law()
    assert isochoric_stiffness(law, IDENTITY) == pytest.approx(4.0 / 3.0 * material.moduli()[0], rel=1e-13)
    # differences: step² = 1e-8 times fourth derivatives, and rounding over step², 1e-8
    assert sampled_stiffness(law, np.eye(3)) == pytest.approx(4.0 / 3.0 * material.moduli()[0], rel=1e-5)
    for seed in range(6):
        F = gradient(seed, 0.5)
        found, bound = sampled_stiffness(law, F), isochoric_stiffness(law, tensor(F))
        assert found <= bound * (1.0 + 1e-4)
        assert bound < 3.0 * found, "a bound so loose would waste steps"


@decoupled
class General(NamedTuple):
    """W = c₁ x + c₂ y + c₃ x² + c₄ y² + c₅ x y, x = Ī₁ - 3, y = Ī₂ - 3."""

    c: float
    d: float
    e: float
    f: float
    g: float
    kappa: float
    rho0: float


@point_function(invariant_energy, General)
def _general(law, first, second):
    return law.c * first + law.d * second + law.e * first**2 + law.f * second**2 + law.g * first * second


@pytest.mark.parametrize("factors", [(3, 1, 0.2, 0.1, 0.15), (5, -1, 0, 0.3, 0.2), (2, 1, 0.3, 0.2, -0.2), (-1, 4, 0.1, 0, 0)])
@every_seed
def test_the_stiffness_by_both_invariants_is_a_bound_for_any_slopes_and_curvatures(factors, seed):
    law = General(*factors, 10.0, 1.0)
    shear = 2.0 * (factors[0] + factors[1])
    at_rest = sampled_stiffness(law, np.eye(3))
    assert at_rest == pytest.approx(4.0 / 3.0 * shear, rel=1e-5)
    assert isochoric_stiffness(law, IDENTITY) >= at_rest * (1.0 - 1e-5)
    F = gradient(seed, 0.5)
    found, bound = sampled_stiffness(law, F), isochoric_stiffness(law, tensor(F))
    assert found <= bound * (1.0 + 1e-4)
    if min(factors) >= 0.0:
        assert bound < 3.0 * found, "a bound so loose would waste steps"


@pytest.mark.parametrize("strain", [1e-2, 1e-5, 1e-9])
def test_a_derived_stress_at_small_strains(strain):
    """A simple shear γ has the shear stress μ γ to first order, to the rounding of 1 + γ²."""
    for name in ("decoupled-neo-hookean", "mooney-rivlin", "second-invariant"):
        law, mu = ISOCHORIC[name].law(), ISOCHORIC[name].moduli()[0]
        F = (1.0, strain, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
        assert isochoric_stress(law, F)[5] == pytest.approx(mu * strain, rel=1e-14)
        extended = (1.0 + strain, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
        assert isochoric_stress(law, extended)[0] == pytest.approx(4.0 / 3.0 * mu * strain, rel=max(2.0 * strain, 1e-6))


@every_stretch
def test_fibres_in_an_extension_along_them(stretch):
    """σ₁ - σ₃ = μ (λ² - 1/λ) + 2 ψ' (d (λ² - 1/λ) + (1-3d) λ²), ψ' = k₁ E exp(k₂ E²),
    E = d (λ² + 2/λ - 3) + (1-3d) (λ² - 1)."""
    for d, families in ((0.0, 1), (0.1, 1), (0.226, 2), (1.0 / 3.0, 1)):
        material = fibrous(dispersion=d, fibres=[(0.0, 3.0, 0.0)] * families)
        x, slant = stretch**2 - 1.0 / stretch, (1.0 - 3.0 * d) * stretch**2
        E = max(d * (stretch**2 + 2.0 / stretch - 3.0) + (1.0 - 3.0 * d) * (stretch**2 - 1.0), 0.0)
        if E > 6.0:
            continue  # the exponential leaves the range of numbers
        expected = 5e3 * x + 2.0 * families * 2e3 * E * np.exp(0.8 * E**2) * (d * x + slant)
        turn = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # the first axis along the fibres
        found = difference(material, uniaxial(stretch), turn)
        # 1 + 1e-9: a strain of 2e-9 is a difference of numbers near 1
        assert found == pytest.approx(expected, rel=1e-11, abs=1e-10 * 5e3)


def test_slack_fibres_leave_the_matrix_alone():
    plain = material_of("decoupled-neo-hookean", {"density": 1100.0, "young_modulus": 1.0, "poisson_ratio": 0.3})
    material = fibrous(dispersion=0.0, fibres=[(1.0, 0.0, 0.0)])
    law = material.law()
    matrix_law = plain.law()._replace(mu=law.mu, kappa=law.kappa)
    shortened, lengthened = tensor(np.diag([0.9, 1.1, 1.02])), tensor(np.diag([1.1, 0.9, 1.02]))
    assert cauchy_stress(law, shortened) == pytest.approx(cauchy_stress(matrix_law, shortened), rel=1e-13)
    assert energy(law, shortened) == pytest.approx(energy(matrix_law, shortened), rel=1e-13)
    assert cauchy_stress(law, lengthened)[0] > 1.2 * cauchy_stress(matrix_law, lengthened)[0]


@every_seed
def test_fully_dispersed_fibres_have_no_direction_and_aligned_ones_have(seed):
    F = tensor(rotation(seed) @ np.diag([1.5, 0.8, 0.9]))
    for d in (1.0 / 3.0, 0.0):
        one, other = (fibrous(dispersion=d, fibres=[fibre]) for fibre in ((1.0, 0.2, 0.0), (0.0, -0.3, 1.0)))
        same = energy(one.law(), F) == pytest.approx(energy(other.law(), F), rel=1e-12)
        assert same == (d > 0.0)


@every_seed
def test_the_wave_speed_of_fibres_is_that_of_taut_ones(seed):
    """At rest the slope of their stress jumps: the bound is that of the side on which they bear."""
    material = fibrous(fibres=[(1.0, 0.0, 0.0)], dispersion=0.0)
    law, kappa, mu, k1 = material.law(), 6e4, 5e3, 2e3
    # along the fibres E = 4/3 ε to the first order: 4 k₁ (2/3)² beside κ + 4/3 μ
    along = kappa + 4.0 / 3.0 * mu + 16.0 / 9.0 * k1
    assert wave_speed(law, IDENTITY) ** 2 * 1100.0 == pytest.approx(along, rel=1e-12)
    F = gradient(seed)
    assert sampled_stiffness(fibrous().law(), F) <= isochoric_stiffness(fibrous().law(), tensor(F)) * (1.0 + 1e-4)


@pytest.mark.parametrize(
    ("kind", "changes", "words"),
    [
        ("mooney-rivlin", {"c1": 0.0, "c2": 0.0}, "the shear modulus 2"),
        ("mooney-rivlin", {"c1": -1.0}, "greater than or equal to 0"),
        ("mooney-rivlin", {"bulk_modulus": 0.0}, "greater than 0"),
        ("ogden", {"exponents": [2.0]}, "shear_moduli has 3 numbers but exponents 1"),
        ("ogden", {"shear_moduli": [1.0, 2.0, 3.0]}, r"shear_moduli\[2\] = 3 and exponents\[2\] = -2"),
        ("ogden", {"shear_moduli": [], "exponents": []}, "at least 1 item"),
        ("holzapfel-gasser-ogden", {"dispersion": 0.34}, "less than or equal to 0.33"),
        ("holzapfel-gasser-ogden", {"fibres": [(0.0, 0.0, 0.0)]}, r"fibres\[0\] = \[0, 0, 0\] has no direction; give a vector"),
        ("holzapfel-gasser-ogden", {"fibres": [(1.0, 0.0, 0.0)] * 3}, "at most 2 items"),
        ("holzapfel-gasser-ogden", {"k2": 0.0}, "greater than 0"),
    ],
)
def test_impossible_parameters(kind, changes, words):
    with pytest.raises(ValidationError, match=words):
        material_of(kind, SPECIAL[kind] | changes)


def test_no_incompressible_solid():
    with pytest.raises(ValidationError, match=r"less than 0\.5"):
        material_of("decoupled-neo-hookean", {"density": 1.0, "young_modulus": 1.0, "poisson_ratio": 0.5})


def test_the_moduli_at_rest():
    """E and ν of a bulk modulus and a shear modulus."""
    assert MOONEY.moduli() == (6e3, 6e4)
    assert pytest.approx(9 * 6e4 * 6e3 / (3 * 6e4 + 6e3), rel=1e-14) == MOONEY.young_modulus
    assert pytest.approx((3 * 6e4 - 2 * 6e3) / (2 * (3 * 6e4 + 6e3)), rel=1e-14) == MOONEY.poisson_ratio
    assert OGDEN.moduli()[0] == pytest.approx(0.5 * (6e3 * 1.3 + 10.0 * 5.0 + 1e3 * 2.0), rel=1e-14)
