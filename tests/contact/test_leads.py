"""Contact leads: extrapolation of the iteration that finds them."""

import numpy as np

from pellucid.contact.leads import Extrapolation


def iterate(step, start, count, extrapolated):
    values, extrapolation = start, Extrapolation()
    for _ in range(count):
        result = step(values)
        values = extrapolation.next(values, result) if extrapolated else result
    return values


def test_extrapolation_finds_the_fixed_point_of_a_slow_iteration():
    """A linear iteration of three modes is exact after four steps; without extrapolation 0.9⁵ of the error is left."""
    factors, target = np.array([0.9, 0.6, 0.2]), np.array([1.0, -2.0, 3.0])

    def step(values):
        return target + factors * (values - target)

    assert abs(iterate(step, np.zeros(3), 6, True) - target).max() < 1e-4
    assert abs(iterate(step, np.zeros(3), 6, False) - target).max() > 0.5


def test_it_starts_again_where_steps_grow():
    extrapolation = Extrapolation()
    extrapolation.next(np.zeros(2), np.array([1.0, 0.0]))
    assert (extrapolation.next(np.array([1.0, 0.0]), np.array([5.0, 0.0])) == [5.0, 0.0]).all()


def test_equal_steps_have_no_extrapolation():
    extrapolation = Extrapolation()
    extrapolation.next(np.zeros(2), np.ones(2))
    assert (extrapolation.next(np.ones(2), 2.0 * np.ones(2)) == 2.0).all()
