"""A bundle of nested tuples and arrays enters kernels, and leaves no references behind."""

import sys
from typing import NamedTuple

import numba
import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_for
from pellucid.jit.sources import sources_of


class Inner(NamedTuple):
    array: np.ndarray
    factor: float


class Outer(NamedTuple):
    inner: Inner
    offsets: tuple[float, float]
    on: bool
    result: np.ndarray


class Empty(NamedTuple):
    pass


@kernel()
def scale(n, bundle):
    parallel_for(_scale_one, n, bundle)


@kernel(inner=True)
def _scale_one(i, bundle):
    inner, offsets = bundle.inner, bundle.offsets
    if bundle.on:
        bundle.result[i] = inner.factor * inner.array[i] + offsets[i % 2]


def test_nested_tuples_pass_through_a_parallel_loop():
    array, result = np.arange(100.0), np.zeros(100)
    scale(100, Bundle(Outer(Inner(array, 3.0), (0.5, -0.5), True, result)))
    assert np.array_equal(result, 3.0 * np.arange(100.0) + np.where(np.arange(100) % 2, -0.5, 0.5))
    scale(100, Bundle(Outer(Inner(array, 1.0), (0.5, -0.5), False, result)))
    assert result[1] == 2.5


def test_the_tuple_itself_does_as_well():
    """Kernels read members by name, and need not know which of the two they have."""
    array, result = np.arange(10.0), np.zeros(10)
    scale(10, Outer(Inner(array, 3.0), (0.5, -0.5), True, result))
    assert result[9] == 26.5


class Around(NamedTuple):
    flag: bool
    within: Bundle
    shift: float


@kernel()
def sum_around(bundle):
    inner, total = bundle.within.inner, bundle.shift
    for value in inner.array:
        total += inner.factor * value
    return total if bundle.flag and bundle.within.on else -1.0


def test_a_bundle_within_a_bundle_is_read_too():
    array = np.arange(4.0)
    around = Bundle(Around(True, Bundle(Outer(Inner(array, 3.0), (0.5, -0.5), True, array)), 0.25))
    assert sum_around(around) == 18.25
    array[0] = 1.0
    assert sum_around(around) == 21.25


def test_members_have_the_same_names_in_python():
    bundle = Bundle(Outer(Inner(np.zeros(1), 3.0), (0.5, -0.5), True, np.zeros(1)))
    assert bundle.offsets == (0.5, -0.5)
    with pytest.raises(AttributeError, match="nothing"):
        bundle.nothing  # noqa: B018


def test_slices_and_lists_of_strides_are_kept():
    whole, result = np.arange(40.0).reshape(20, 2), np.zeros(20)
    scale(20, Bundle(Outer(Inner(whole[:, 1], 1.0), (0.0, 0.0), True, result)))
    assert np.array_equal(result, whole[:, 1])


class Mixed(NamedTuple):
    small: np.int16
    flag: bool
    nothing: Empty
    pairs: tuple[tuple[int, float], tuple[int, float]]
    byte: np.uint8
    flags: np.ndarray
    last: np.float32


@kernel()
def read(bundle):
    pairs = bundle.pairs
    total = 1.0 * bundle.small + bundle.byte + bundle.last + pairs[0][0] + pairs[0][1] + pairs[1][0] + pairs[1][1]
    return bundle.flag, total, bundle.flags[1, 0], bundle.flags.shape, bundle.flags.size


def test_members_of_any_size_are_found():
    flags = np.zeros((2, 3), bool)
    flags[1, 0] = True
    mixed = Mixed(np.int16(-3), True, Empty(), ((1, 0.5), (2, 0.25)), np.uint8(200), flags, np.float32(0.125))
    assert read(Bundle(mixed)) == (True, 200.875, True, (2, 3), 6)


def test_a_kept_bundle_sees_its_arrays_change():
    array, result = np.zeros(4), np.zeros(4)
    bundle = Bundle(Outer(Inner(array, 2.0), (0.0, 0.0), True, result))
    for value in (1.0, 2.0):
        array[:] = value
        scale(4, bundle)
        assert np.all(result == 2.0 * value)


def test_calls_leave_no_references():
    array, result = np.zeros(4), np.zeros(4)
    bundle = Bundle(Outer(Inner(array, 2.0), (0.0, 0.0), True, result))
    scale(4, bundle)
    before = [sys.getrefcount(thing) for thing in (array, result, bundle, bundle.content)]
    for _ in range(100):
        scale(4, bundle)
    assert [sys.getrefcount(thing) for thing in (array, result, bundle, bundle.content)] == before


def test_a_bundle_keeps_its_arrays_alive():
    bundle = Bundle(Outer(Inner(np.full(1000, 7.0), 1.0), (0.0, 0.0), True, np.zeros(1000)))
    for _ in range(3):
        scale(1000, bundle)
        np.full(1000, -1.0)  # takes the memory of what was let go
    assert np.all(bundle.result == 7.0)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_what_cannot_be_kept_is_refused():
    class Named(NamedTuple):
        name: str

    @kernel()
    def nothing(bundle):
        return 0

    with pytest.raises(Exception, match="a bundle cannot contain"):
        nothing(Bundle(Named("text")))


class Rows(NamedTuple):
    table: np.ndarray


@kernel()
def add_up(bundle):
    table, total = bundle.table, 0.0
    for p in range(table.shape[0]):
        for d in range(table.shape[1]):
            total += (1.0 + d) * table[p, d]
    return total


def test_kernels_are_compiled_for_the_length_and_the_strides_of_rows():
    table = np.arange(20.0).reshape(5, 4)
    for rows in (np.ascontiguousarray(table[:, :3]), table[:, :3], table[:, 1:], table, np.ascontiguousarray(table[:, :2])):
        assert add_up(Bundle(Rows(rows))) == np.sum(rows * np.arange(1.0, 1.0 + rows.shape[1]))


def test_arrays_with_and_without_rows_have_one_type():
    """Of transfers without affine fields: kernels are compiled once for both."""
    kinds = {numba.typeof(Bundle(Rows(np.zeros((n, 10))))) for n in (0, 1, 5)}
    assert len(kinds) == 1


def test_code_for_rows_of_one_length_is_not_kept_for_another():
    digests = [sources_of([add_up.py_func], [numba.typeof(Bundle(Rows(np.zeros((2, n)))))]).digest for n in (3, 6, 3)]
    assert digests[0] == digests[2] != digests[1]
