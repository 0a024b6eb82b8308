"""Calls of kernels from Python: what is known already goes to the code for the types of the arguments, and to no other."""

from typing import NamedTuple

import numba
import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle

compiled_only = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="plain Python has one code for all types")


class OneArray(NamedTuple):
    values: np.ndarray


class OneNumber(NamedTuple):
    values: float


@kernel()
def _half(n):
    return n / 2 if n > 2 else n * 1.0


@kernel()
def _sum_of(values):
    total = 0.0
    for row in range(values.shape[0]):
        for column in range(values.shape[1]):
            total += values[row, column]
    return total


@kernel()
def _add(bundle, other, number):
    bundle.values[0] += other.values * number


def test_numbers_of_other_types_go_to_other_code():
    for _ in range(3):
        assert [_half(5), _half(5.0), _half(True), _half(np.float64(3.0)), _half(np.int32(7))] == [2.5, 2.5, 1.0, 1.5, 3.5]


def test_arrays_of_other_layouts_and_types_go_to_other_code():
    values = np.arange(12.0).reshape(3, 4)
    for _ in range(3):
        several = values, values.T, values[:, 1:3], values[::2], values.astype(np.float32), values.astype(np.int64)
        assert [_sum_of(array) for array in several] == [array.sum() for array in several]


class Several(NamedTuple):
    number: float
    one: OneArray


@kernel()
def _first_of(bundle, several, factor):
    return several.number * factor + several.one.values[0] + bundle.values


def test_tuples_of_other_members_go_to_other_code():
    values, none = np.arange(1.0, 4.0), Bundle(OneNumber(0.0))
    for _ in range(3):
        for number, array in ((2.0, values), (2, values[::2]), (2, values.astype(int))):
            assert _first_of(none, Several(number, OneArray(array)), 0.5) == 2.0
        assert _first_of(none, Several(np.float32(0.1), OneArray(values)), 1.0) == np.float64(np.float32(0.1)) + 1.0


@compiled_only
def test_calls_with_tuples_are_known_by_their_members():
    none, array = Bundle(OneNumber(0.0)), (np.dtype(float), 1, np.ones(1).flags.num)
    _first_of(none, Several(1.0, OneArray(np.ones(1))), 1.0)
    assert (none.type_name, (Several, (float, (OneArray, (array,)))), float) in _first_of.entries


def test_bundles_of_one_type_share_code_and_keep_their_contents():
    first, second = Bundle(OneArray(np.zeros(1))), Bundle(OneArray(np.zeros(1)))
    for _ in range(3):
        _add(first, Bundle(OneNumber(2.0)), 1.0)
        _add(second, Bundle(OneNumber(3)), 10.0)  # a whole number: another type of bundle
    assert first.values[0] == 6.0
    assert second.values[0] == 90.0


@compiled_only
def test_a_call_that_was_made_before_asks_for_no_types(monkeypatch):
    array = np.ones((2, 2))
    assert _sum_of(array) == 4.0
    monkeypatch.setattr(_sum_of, "typeof_pyval", None)
    assert _sum_of(np.full((5, 5), 2.0)) == 50.0


@kernel()
def _times(factor, values):
    return factor.values * values[0]


@compiled_only
def test_types_that_python_does_not_see_are_left_to_numba_alone(monkeypatch):
    """It finds those of a named tuple in ten microseconds; asked from Python it takes hundreds."""
    assert _times(OneNumber(2.0), np.ones(1)) == 2.0
    monkeypatch.setattr(_times, "typeof_pyval", None)
    assert _times(OneNumber(3.0), np.ones(2)) == 3.0


@compiled_only
def test_wrong_arguments_are_refused_each_time():
    for _ in range(2):
        with pytest.raises(TypeError):
            _half()
        with pytest.raises((TypeError, numba.TypingError)):
            _sum_of("text")
