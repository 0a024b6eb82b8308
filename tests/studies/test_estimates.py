import numpy as np
import pytest

from pellucid.studies.fit import estimated
from pellucid.studies.ranges import Range

FREE = {"a": Range(0.0, 2.0), "b": Range(1.0, 100.0)}
SLOPES = np.column_stack([np.linspace(0, 400, 50), np.full(50, 30.0)])
RESIDUALS = np.tile([1.0, -1.0], 25)


def test_intervals_are_those_of_the_linear_model() -> None:
    found = estimated(FREE, np.array([0.5, 0.5]), RESIDUALS, SLOPES, True)
    deviations = 1.959964 * np.sqrt(np.diag(np.linalg.inv(SLOPES.T @ SLOPES)))
    a, b = found.by_key.values()
    assert (a.low, a.value, a.high) == pytest.approx((1 - 2 * deviations[0], 1.0, 1 + 2 * deviations[0]))
    assert (b.low, b.value, b.high) == pytest.approx((10 * 100 ** -deviations[1], 10.0, 10 * 100 ** deviations[1]))
    covariance = np.linalg.inv(SLOPES.T @ SLOPES)
    assert found.correlations[0, 1] == pytest.approx(covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1]))
    assert found.chi_square == pytest.approx(50 / 48)
    assert found.warnings == []


def test_without_deviations_the_residuals_tell_them() -> None:
    stated = estimated(FREE, np.array([0.5, 0.5]), RESIDUALS, SLOPES, True).by_key["a"]
    told = estimated(FREE, np.array([0.5, 0.5]), 0.1 * RESIDUALS, SLOPES, False).by_key["a"]
    ratio = (told.high - told.value) / (stated.high - stated.value)
    assert ratio == pytest.approx(0.1 * np.sqrt(50 / 48) * 2.0106 / 1.95996, rel=1e-3), "Student's t of 48 degrees"


def test_a_parameter_without_effect_is_named() -> None:
    found = estimated(FREE, np.array([0.5, 0.5]), RESIDUALS, SLOPES * [1, 0], True)
    assert len(found.warnings) == 1
    assert "do not determine b;" in found.warnings[0]


def test_parameters_that_act_alike_are_named_together() -> None:
    found = estimated(FREE, np.array([0.5, 0.5]), RESIDUALS, np.column_stack([SLOPES[:, 0]] * 2), True)
    assert "a and b independently" in found.warnings[0]


def test_an_estimate_at_the_end_of_its_range_is_told() -> None:
    found = estimated(FREE, np.array([0.5, 0.999]), RESIDUALS, SLOPES, True)
    assert found.warnings == ["b is at the upper end of its range, so the best value may be outside; extend the range"]


def test_a_misfit_beyond_the_deviations_is_told() -> None:
    found = estimated(FREE, np.array([0.5, 0.5]), 2 * RESIDUALS, SLOPES, True)
    assert "4.17 times" in found.warnings[0]
