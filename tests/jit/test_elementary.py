"""Logarithm, exponential, power and cube root beside numpy's, compiled and plain."""

import math
import re

import numba
import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.elementary import cube_root, exp, expm1, log, log1p, power
from pellucid.jit.registry import IN_KERNELS

SPECIAL = [0.0, -0.0, -1.0, np.inf, -np.inf, np.nan, 1.0, 5e-324, 1e-310, 2.3e-308, 1.7e308]


@kernel()
def logs(x, out):
    for i in range(len(x)):
        out[i] = log(x[i])


@kernel()
def exps(x, out):
    for i in range(len(x)):
        out[i] = exp(x[i])


@kernel()
def logs_beside_one(x, out):
    for i in range(len(x)):
        out[i] = log1p(x[i])


@kernel()
def exps_beside_one(x, out):
    for i in range(len(x)):
        out[i] = expm1(x[i])


@kernel()
def powers(x, y, out):
    for i in range(len(x)):
        out[i] = power(x[i], y)


@kernel()
def cube_roots(x, out):
    for i in range(len(x)):
        out[i] = cube_root(x[i])


def compiled(function, x, *more):
    out = np.empty_like(x)
    function(x, *more, out)
    return out


def units_apart(found, exact):
    return np.max(np.abs(found - exact) / np.spacing(np.abs(exact)))


def positive(rng):
    near_one, small, wide = 1e-3 * rng.normal(size=20_000), rng.random(20_000), 100.0 * rng.normal(size=20_000)
    return np.concatenate([1.0 + near_one, 3.0 * small, np.exp(wide)])


def test_logarithms_are_right_to_the_last_digit():
    """The method errs by less than one unit in it; numpy's by half of one."""
    x = positive(np.random.default_rng(1))
    assert units_apart(compiled(logs, x), np.log(x)) <= 1.5
    assert max(abs(log(v) - math.log(v)) / np.spacing(abs(math.log(v))) for v in x[::500]) <= 1.5


def test_logarithms_and_exponentials_beside_one_are_right_to_the_last_digits():
    """Three units in these: of the logarithm, the quotient and the product."""
    rng = np.random.default_rng(5)
    small = rng.normal(size=20_000) * 10.0 ** rng.uniform(-20.0, -0.5, 20_000)
    x = np.concatenate([small[small > -1.0], np.exp(rng.uniform(-40.0, 300.0, 20_000)), rng.uniform(-1.0, 3.0, 20_000)])
    assert units_apart(compiled(logs_beside_one, x), np.log1p(x)) <= 3.0
    assert max(abs(log1p(v) - math.log1p(v)) / np.spacing(abs(math.log1p(v))) for v in x[::500]) <= 3.0
    x = np.concatenate([small, rng.uniform(-3.0, 3.0, 20_000), rng.uniform(-60.0, 709.0, 20_000)])
    assert units_apart(compiled(exps_beside_one, x), np.expm1(x)) <= 2.0
    assert max(abs(expm1(v) - math.expm1(v)) / np.spacing(abs(math.expm1(v))) for v in x[::500]) <= 2.0


def test_logarithms_and_exponentials_beside_one_have_the_limits_of_the_functions():
    x = np.array([0.0, 5e-324, 1e-310, -1.0, -2.0, 1e300, 709.7, 710.0, -39.9, -40.1, -1e300, np.inf, -np.inf, np.nan])
    for function, plain, of_numpy in ((logs_beside_one, log1p, np.log1p), (exps_beside_one, expm1, np.expm1)):
        with np.errstate(all="ignore"):
            exact = of_numpy(x)
        assert compiled(function, x) == pytest.approx(exact, rel=1e-14, abs=0.0, nan_ok=True)
        assert [plain(float(v)) for v in x] == pytest.approx(exact, rel=1e-14, abs=0.0, nan_ok=True)


def test_cube_roots_are_right_to_the_last_digit():
    x = positive(np.random.default_rng(4))
    assert units_apart(compiled(cube_roots, x), np.cbrt(x)) <= 1.5  # numpy's errs by half of one
    assert max(abs(cube_root(v) - np.cbrt(v)) / np.spacing(np.cbrt(v)) for v in x[::500]) <= 1.5


def test_exponentials_are_right_to_the_last_digit():
    rng = np.random.default_rng(2)
    x = np.concatenate([1e-3 * rng.normal(size=20_000), rng.normal(size=20_000), rng.uniform(-700.0, 709.0, 20_000)])
    assert units_apart(compiled(exps, x), np.exp(x)) <= 1.5
    assert max(abs(exp(v) - math.exp(v)) / np.spacing(math.exp(v)) for v in x[::500]) <= 1.5


@pytest.mark.parametrize("y", [-4.0 / 3.0, -2.0 / 3.0, 6.0, 7.0])
def test_powers_are_as_good_as_they_say(y):
    x = np.random.default_rng(3).uniform(0.2, 5.0, 20_000)
    exact = x**y
    roundings = np.abs(compiled(powers, x, y) / exact - 1.0) / np.finfo(float).eps
    assert np.all(roundings <= 1.0 + 1.5 * np.abs(y * np.log(x)) + 1.0), "numpy's and the quotient's are in it too"
    assert power(1.0, y) == 1.0


def test_what_is_no_positive_number_has_the_limits_of_the_functions():
    x = np.array(SPECIAL)
    with np.errstate(all="ignore"):
        exact = np.log(x)
    assert compiled(logs, x) == pytest.approx(exact, rel=1e-15, nan_ok=True)
    assert [log(v) for v in SPECIAL] == pytest.approx(exact, rel=1e-15, nan_ok=True)


def test_exponentials_beyond_all_numbers_are_infinite_or_nothing():
    x = np.array([np.inf, 1e300, 710.0, 709.7, -744.0, -746.0, -1e300, -np.inf, np.nan, 0.0])
    with np.errstate(all="ignore"):
        exact = np.exp(x)
    found = compiled(exps, x)
    assert np.array_equal(np.isfinite(found), np.isfinite(exact))
    assert found == pytest.approx(exact, rel=1e-14, abs=1e-323, nan_ok=True)
    assert [exp(v) for v in x] == pytest.approx(exact, rel=1e-14, abs=1e-323, nan_ok=True)


@pytest.mark.parametrize("function", [logs, exps, logs_beside_one, exps_beside_one, cube_roots])
def test_a_loop_over_them_calls_nothing_and_becomes_vectors(function):
    anew = numba.njit(**{**IN_KERNELS, "no_cpython_wrapper": False})(function.py_func)  # of kept code there is no text
    compiled(anew, np.ones(8))
    (code,) = anew.inspect_llvm().values()
    assert re.search(r"fdiv (contract )?<\d+ x double>", code)
    assert not re.search(r"@(llvm\.)?(log|exp)[.(]", code)
