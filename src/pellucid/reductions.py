"""Sums in a fixed order: the same bits on any number of threads."""

from math import fsum

import numpy as np


def ordered_sum(partials: np.ndarray) -> np.ndarray:
    """Sum over the first axis, partial by partial, shape (chunks, k) -> (k,)."""
    return np.asarray(np.add.accumulate(partials, axis=0)[-1])


def exact_parts(values: np.ndarray) -> list[float]:
    """A few numbers whose sum is that of the values, shape (n,), without rounding: `math.fsum` of those of several arrays is
    that of all their values."""
    parts, numbers = list[float](), values.tolist()
    while (part := fsum([*numbers, *(-known for known in parts)])) != 0.0:
        parts.append(part)
    return parts
