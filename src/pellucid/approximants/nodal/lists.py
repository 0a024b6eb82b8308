"""Lists of indices of different lengths in two arrays."""

from typing import NamedTuple

import numpy as np


class Lists(NamedTuple):
    """A list of indices for each of n objects: the list of object i is `items[first[i]:first[i + 1]]`."""

    first: np.ndarray  # (n + 1,) start of each list, and the end of the last
    items: np.ndarray  # entries of all lists, one list after the other

    def of(self, things: np.ndarray) -> "Lists":
        """Return the lists of the objects with the numbers `things`, shape (m,), in the order of `things`."""
        count = np.diff(self.first)[things]
        first = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
        return Lists(
            first, np.asarray(self.items[np.repeat(self.first[things] - first[:-1], count) + np.arange(int(first[-1]))])
        )
