"""Sums in a fixed order: bitwise identical results for any number of threads."""

from math import fsum

import numpy as np


def ordered_sum(partials: np.ndarray) -> np.ndarray:
    """Return the sum of partial sums, shape (chunks, k), over the chunks in their order, shape (k,)."""
    return np.asarray(np.add.accumulate(partials, axis=0)[-1])


def exact_parts(values: np.ndarray) -> list[float]:
    """Return a few numbers whose exact sum equals the exact sum of the values, shape (n,).

    `math.fsum` of the parts of several arrays is the correctly rounded sum of all their values.
    """
    parts, numbers = list[float](), values.tolist()
    while (part := fsum([*numbers, *(-known for known in parts)])) != 0.0:
        parts.append(part)
    return parts
