"""Lists of numbers of different lengths, one after the other."""

from typing import NamedTuple

import numpy as np


class Lists(NamedTuple):
    """A list of numbers for each of n things: those of thing i are `items[first[i]:first[i + 1]]`."""

    first: np.ndarray
    items: np.ndarray
