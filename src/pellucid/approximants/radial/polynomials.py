"""Monomials of several variables with their derivatives."""

from itertools import product
from typing import NamedTuple

import numpy as np


class Monomials(NamedTuple):
    """Values (..., p), gradients (..., d, p) and second derivatives (..., d, d, p) of monomials at places."""

    value: np.ndarray
    first: np.ndarray
    second: np.ndarray


def exponents(degree: int, dimension: int) -> np.ndarray:
    """The exponents of all monomials up to a degree, by degree, shape (p, dimension)."""
    every = [powers for powers in product(range(degree + 1), repeat=dimension) if sum(powers) <= degree]
    return np.array(sorted(every, key=lambda powers: (sum(powers), powers[::-1])), dtype=np.int64).reshape(-1, dimension)


def monomials(places: np.ndarray, degree: int) -> Monomials:
    """Monomials up to a degree at places, shape (..., d)."""
    dimension = places.shape[-1]
    powers = exponents(degree, dimension)
    # x^k, k x^(k-1) and k (k-1) x^(k-2) of each coordinate, shape (..., d, degree + 1)
    k = np.arange(degree + 1)
    whole = places[..., None] ** k
    once = np.concatenate([np.zeros_like(whole[..., :1]), k[1:] * whole[..., :-1]], axis=-1)
    twice = np.concatenate([np.zeros_like(whole[..., :1]), k[1:] * once[..., :-1]], axis=-1)
    factors = [whole, once, twice]

    def term(orders: list[int]) -> np.ndarray:
        result = np.ones((*places.shape[:-1], len(powers)))
        for axis, order in enumerate(orders):
            result = result * factors[order][..., axis, :][..., powers[:, axis]]
        return result

    unit = np.eye(dimension, dtype=int)
    axes = range(dimension)
    first = np.stack([term(unit[a].tolist()) for a in axes], axis=-2)
    second = np.stack([np.stack([term((unit[a] + unit[b]).tolist()) for b in axes], axis=-2) for a in axes], axis=-3)
    return Monomials(term([0] * dimension), first, second)
