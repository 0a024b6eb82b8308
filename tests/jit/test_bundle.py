"""A bundle of nested tuples and arrays enters a parallel loop, and leaves no references behind."""

import sys
from typing import NamedTuple

import numpy as np
from numba import prange

from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle


class Inner(NamedTuple):
    array: np.ndarray
    factor: float


class Outer(NamedTuple):
    inner: Inner
    offsets: tuple[float, float]


@kernel(parallel=True)
def scale(n, bundle):
    for i in prange(n):
        scale_one(bundle, i)


@kernel()
def scale_one(bundle, i):
    outer, result = bundle.content
    result[i] = outer.inner.factor * outer.inner.array[i] + outer.offsets[i % 2]


def test_nested_tuples_pass_through_a_parallel_loop():
    array, result = np.arange(100.0), np.zeros(100)
    scale(100, Bundle(Outer(Inner(array, 3.0), (0.5, -0.5)), result))
    assert np.array_equal(result, 3.0 * np.arange(100.0) + np.where(np.arange(100) % 2, -0.5, 0.5))


def test_a_kept_bundle_sees_its_arrays_change():
    array, result = np.zeros(4), np.zeros(4)
    bundle = Bundle(Outer(Inner(array, 2.0), (0.0, 0.0)), result)
    for value in (1.0, 2.0):
        array[:] = value
        scale(4, bundle)
        assert np.all(result == 2.0 * value)


def test_calls_leave_no_references():
    array, result = np.zeros(4), np.zeros(4)
    bundle = Bundle(Outer(Inner(array, 2.0), (0.0, 0.0)), result)
    scale(4, bundle)
    before = [sys.getrefcount(thing) for thing in (array, result, bundle, bundle.content)]
    for _ in range(100):
        scale(4, bundle)
    assert [sys.getrefcount(thing) for thing in (array, result, bundle, bundle.content)] == before
