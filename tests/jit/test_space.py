"""Vectors in space, in kernels and in plain Python."""

import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.space import Vector3, add_vector, cross, set_vector, vector_at


def combine(first, second, factors, products, results):
    """Write products and combinations of the rows of two arrays."""
    for i in range(len(first)):
        a, b = vector_at(first, i), vector_at(second, i)
        products[i] = a @ b
        set_vector(results, i, factors[i] * (a - b) + cross(a, -b))
        add_vector(results, i, a / factors[i])


def in_plain_python(*arrays):
    def at(values, i):
        return Vector3(*values[i])

    first, second, factors, products, results = arrays
    for i in range(len(first)):
        a, b = at(first, i), at(second, i)
        products[i] = a @ b
        found = factors[i] * (a - b) + cross(a, -b) + a / factors[i]
        results[i] = found.x, found.y, found.z


@pytest.mark.parametrize("run", [kernel()(combine), in_plain_python], ids=["kernel", "python"])
def test_operators_are_those_of_arrays(run):
    first, second = np.random.default_rng(3).normal(size=(2, 7, 3))
    factors, products, results = np.linspace(0.5, 2.0, 7), np.zeros(7), np.zeros((7, 3))
    run(first, second, factors, products, results)
    assert products == pytest.approx(np.sum(first * second, axis=1), rel=1e-14)
    f = factors[:, None]
    assert results == pytest.approx(f * (first - second) - np.cross(first, second) + first / f, rel=1e-14, abs=1e-14)
