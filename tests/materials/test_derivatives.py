"""Energies that are differentiated: every operation, small strains, compiled code and its digest, and what cannot be."""

import math
from math import sqrt
from typing import NamedTuple

import numpy as np
import pytest

from pellucid.jit import MissingFunction, generic, implementation_of, kernel, point_function, pointwise
from pellucid.jit.elementary import exp, expm1, log, log1p, power
from pellucid.materials.derivatives import Energy, NotTraced, derive, partial_derivatives
from pellucid.materials.skalak_membrane import SkalakSurface
from pellucid.materials.surface_law import stretch_curvatures, stretch_energy, stretch_slopes


class Numbers(NamedTuple):
    c: float
    n: float


@pointwise
def _squared(x):
    return x * x


def cubic_product(law, a, b):
    return law.c * a * a * b - 2.0 * (a - b) ** 3 + b / law.n - 7.0


def quotient(law, a, b):
    return (a - b) / (law.c + a * b) + 3 / a / a - law.n / (b * b)


def powers(law, a, b):
    return a**2 + b**3.0 - (a * b) ** -2 + (a + b) ** 0.5 + a**-1.5 + b**1.3 + a**law.n + (a / b) ** 0


def roots_and_logarithms(law, a, b):
    return sqrt(a * b) - law.c * log(a) * log1p(b) + math.pi * _squared(log(a / b)) + power(2.0, 0.5)


def exponentials(law, a, b):
    return exp(law.c * a) * expm1(-a * b) + law.n * exp(-0.5 * (a - b) * (a - b)) + power(b, law.n)


@pointwise
def _halved(x, y):
    return 0.5 * (x / y)


@partial_derivatives(_halved)
def _halved_slopes(x, y):
    return 0.5 / y, -0.5 * x / (y * y)


def with_partial_derivatives(law, a, b):
    q = _halved(a * a, b + 1.0)
    return log(1.0 + q * q) * law.c + q


def of_one(law, a, b):
    return law.c * (a - 1.0) * (a - 1.0)


def of_libraries(law, a, b):
    return math.expm1(law.c * a) + math.sqrt(b) * np.log1p(a) - np.exp(-b) + 2.0**a + math.e


def alike(law, a, b):
    return -(a - 1.0) * (1.0 + a) - (b - a) - (a - b) + (2.0 - a) * (a - 1.0) + (a + b) * (a + b) + 0.0 * b


ENERGIES = [
    cubic_product,
    quotient,
    powers,
    roots_and_logarithms,
    exponentials,
    with_partial_derivatives,
    of_one,
    of_libraries,
    alike,
]
LAW = Numbers(0.7, 1.6)


def derived(function):
    W = Energy(stretch_energy, Numbers, function)
    return W.function(stretch_slopes, W.slopes), W.function(stretch_curvatures, W.curvatures)


def differences(function, a, b, step=1e-3):
    """Derivatives with respect to a and b, to the sixth order of the step."""
    along = [(step, 0.0), (0.0, step)]
    weights = ((1, 0.75), (2, -0.15), (3, 1.0 / 60.0))
    value = lambda k, d: np.array(function(LAW, a + k * d[0], b + k * d[1]))  # noqa: E731
    return [sum(w * (value(k, d) - value(-k, d)) for k, w in weights) / step for d in along]


@pytest.mark.parametrize("function", ENERGIES)
@pytest.mark.parametrize("stretches", [(1.0, 1.0), (1.3, 0.8), (0.7, 0.7), (0.6, 1.9)])
def test_derivatives_are_those_of_the_function(function, stretches):
    slopes, curvatures = derived(function)
    assert slopes(LAW, *stretches) == pytest.approx(differences(function, *stretches), rel=1e-10, abs=1e-10)
    (xx, xy), (yx, yy) = differences(slopes, *stretches)
    assert curvatures(LAW, *stretches) == pytest.approx((xx, yy, xy), rel=1e-10, abs=1e-10)
    assert xy == pytest.approx(yx, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("strain", [1e-2, 1e-5, 1e-9, 1e-12])
def test_derivatives_are_as_accurate_as_the_energy_at_small_strains(strain):
    """Skalak's law: W₁ = G λ₁ (I + C I₂ λ₂²), with I = λ₁² - 1, in numbers with more digits."""
    law, a, b = SkalakSurface(2.0, 50.0), 1.0 + strain, 1.0 - 0.3 * strain
    la, lb = np.longdouble(a), np.longdouble(b)
    x, y = (la - 1) * (la + 1), (lb - 1) * (lb + 1)
    even = 50 * (x + y + x * y)
    exact = 2 * la * (x + even * (1 + y)), 2 * lb * (y + even * (1 + x))
    assert stretch_slopes(law, a, b) == pytest.approx([float(value) for value in exact], rel=1e-14)


def test_constant_factors_are_collected_and_equal_terms_exist_once():
    slopes, curvatures = derived(of_one)
    assert slopes.__doc__.count("a") < 8
    assert curvatures(LAW, 1.2, 0.9) == (1.4, 0.0, 0.0)
    assert slopes.__doc__ == derived(of_one)[0].__doc__, "the same in every process"


respond = kernel()(lambda law, a, b: (stretch_slopes(law, a, b), stretch_curvatures(law, a, b)))


def test_derived_functions_compile_like_others():
    law = SkalakSurface(2.0, 50.0)
    slopes, curvatures = respond(law, 1.2, 0.9)
    assert slopes == pytest.approx(stretch_slopes(law, 1.2, 0.9), rel=1e-13)
    assert curvatures == pytest.approx(stretch_curvatures(law, 1.2, 0.9), rel=1e-13)


def test_an_edit_of_the_energy_changes_the_digest_of_compiled_code():
    from pellucid.jit.sources import lead_of

    same, edited = derived(of_one)[0], derived(lambda law, a, b: law.c * (a - 1.0) * (a - 1.5))[0]
    assert lead_of(derived(of_one)[0]).digest == lead_of(same).digest != lead_of(edited).digest


def branches(law, a, b):
    return law.c * (a if a > 1.0 else b)


def outside(law, a, b):
    return math.cosh(a) + b


def tuples(law, a, b):
    return law.c[0] * a * b


def texts(law, a, b):
    return a + "b"


def undecorated(x):
    return x * x


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (branches, "it compares its arguments or parameters"),
        (outside, "passes them to a function that cannot be differentiated"),
        (tuples, "'Term' object is not subscriptable"),
        (texts, "it combines a number with a str"),
        (lambda law, a, b: (a, b), "it returns a tuple"),
        (lambda law, a, b: undecorated(a) * b, "it calls `undecorated`, which is no pointwise function"),
        (lambda law, a, b: a == b, "it compares its arguments"),
        (lambda law, a, b: law.stiffness * a, "has no attribute 'stiffness'"),
    ],
)
def test_what_cannot_be_differentiated(function, words):
    with pytest.raises(NotTraced, match=f"`stretch_energy` of the law Numbers cannot be differentiated: .*{words}"):
        derived(function)


@generic
def potential(law: Numbers, a: float, b: float) -> float:
    """Return an energy that no law registers at first."""


@generic
def force(law: Numbers, a: float, b: float) -> tuple[float, float]:
    """Return the slopes of `potential`."""


def test_an_energy_is_differentiated_once_it_is_registered():
    derive(force, potential, lambda W: W.slopes)
    with pytest.raises(MissingFunction, match="Numbers has no `force`"):
        force(LAW, 1.2, 1.0)
    point_function(potential, Numbers)(of_one)
    assert force(LAW, 1.2, 1.0) == pytest.approx((0.28, 0.0), rel=1e-14)


@generic
def of_volume(law: Numbers, J: float) -> float:
    """Return an energy of one variable."""


@generic
def pressure(law: Numbers, J: float) -> float:
    """Return the slope of `of_volume`."""


@generic
def modulus(law: Numbers, J: float) -> float:
    """Return the curvature of `of_volume`."""


def test_an_energy_of_one_variable():
    derive(pressure, of_volume, lambda U: U.slopes)
    derive(modulus, of_volume, lambda U: U.curvatures)
    point_function(of_volume, Numbers)(lambda law, J: law.c * (J * J - 1.0 - 2.0 * log(J)))
    assert pressure(LAW, 1.25) == pytest.approx(0.7 * (2.5 - 1.6), rel=1e-14)
    assert modulus(LAW, 1.25) == pytest.approx(0.7 * (2.0 + 2.0 / 1.25**2), rel=1e-14)
    point_function(pressure, Numbers)(lambda law, J: 0.0)
    assert pressure(LAW, 1.25) == 0.0, "a registered function comes first"
    assert implementation_of(modulus, Numbers).__doc__.startswith("def modulus(law, J):")


def energy_at_random(seed):
    """Thirteen operations on what the ones before gave."""
    numbers = np.random.default_rng(seed)
    steps = [(int(numbers.integers(8)), *numbers.integers(0, 4 + k, 2)) for k in range(13)]

    def energy(law, a, b):
        found = [a, b, law.c, 1.5]
        for operation, i, j in steps:
            x, y = found[i], found[j]
            if operation in (0, 1, 2):
                found.append((x + y, x - y, x * y)[operation])
            else:
                square = x * x + 1.0
                found.append((x / (y * y + 1.0), sqrt(square), log(square), 1.0 / square, y * square**-0.5)[operation - 3])
        return found[-1] + 0.3 * found[-2] * found[-3] + found[-4]

    return energy


@pytest.mark.parametrize("seed", range(40))
def test_derivatives_of_energies_at_random(seed):
    function, point = energy_at_random(seed), (1.1, 0.7)
    slopes, curvatures = derived(function)
    found, size = np.array(differences(function, *point)), abs(function(LAW, *point))
    assert slopes(LAW, *point) == pytest.approx(found, rel=1e-7, abs=1e-9 * (1.0 + size))
    (xx, xy), (_, yy) = differences(slopes, *point)
    assert curvatures(LAW, *point) == pytest.approx((xx, yy, xy), rel=1e-7, abs=1e-9 * (1.0 + np.abs(found).max()))
