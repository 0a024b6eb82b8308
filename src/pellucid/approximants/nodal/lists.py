"""Lists of numbers of different lengths, one after the other."""

from typing import NamedTuple

import numpy as np


class Lists(NamedTuple):
    """A list of numbers for each of n things: those of thing i are `items[first[i]:first[i + 1]]`."""

    first: np.ndarray
    items: np.ndarray

    def of(self, things: np.ndarray) -> "Lists":
        """Those of some things, shape (m,), in their order."""
        count = np.diff(self.first)[things]
        first = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
        return Lists(
            first, np.asarray(self.items[np.repeat(self.first[things] - first[:-1], count) + np.arange(int(first[-1]))])
        )
