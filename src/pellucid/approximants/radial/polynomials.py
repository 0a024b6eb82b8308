"""Monomials of several variables and their derivatives."""

from itertools import product

import numpy as np


def exponents(degree: int, dimension: int) -> np.ndarray:
    """Return the exponents of all p monomials up to a degree in d variables (`dimension`), ordered by degree, shape (p, d)."""
    every = [powers for powers in product(range(degree + 1), repeat=dimension) if sum(powers) <= degree]
    return np.array(sorted(every, key=lambda powers: (sum(powers), powers[::-1])), dtype=np.int64).reshape(-1, dimension)


class Monomials:
    """All monomials up to a degree at positions, shape (..., d); derivatives are computed on access."""

    def __init__(self, places: np.ndarray, degree: int) -> None:
        self._dimension = places.shape[-1]
        self._powers = exponents(degree, self._dimension)
        # x^k, k x^(k-1) and k (k-1) x^(k-2) of each coordinate, shape (..., d, degree + 1)
        k = np.arange(degree + 1)
        whole = places[..., None] ** k
        once = np.concatenate([np.zeros_like(whole[..., :1]), k[1:] * whole[..., :-1]], axis=-1)
        twice = np.concatenate([np.zeros_like(whole[..., :1]), k[1:] * once[..., :-1]], axis=-1)
        self._factors = whole, once, twice

    @property
    def value(self) -> np.ndarray:
        """Values of the p monomials at the positions, shape (..., p)."""
        return self._derivative()

    @property
    def first(self) -> np.ndarray:
        """Gradients of the p monomials at the positions, shape (..., d, p)."""
        return np.stack([self._derivative(a) for a in range(self._dimension)], axis=-2)

    @property
    def second(self) -> np.ndarray:
        """Second derivatives of the p monomials at the positions, shape (..., d, d, p)."""
        axes = range(self._dimension)
        return np.stack([np.stack([self._derivative(a, b) for b in axes], axis=-2) for a in axes], axis=-3)

    def _derivative(self, *axes: int) -> np.ndarray:
        result = np.ones(1)
        for axis in range(self._dimension):
            result = result * self._factors[axes.count(axis)][..., axis, self._powers[:, axis]]
        return result
