"""Distribution of the points of a body, sorted into slabs (layers of the grid), among processes: all points on each
process, or distributed.

`first` holds the first point of each slab among the points of this process, and the end. Both classes have the same
methods: `after_sorting`, and `hand_over` before rows of slabs are redistributed.
"""

from collections.abc import Callable, Mapping

import numpy as np

from pellucid.grid.points import Slabs
from pellucid.ranks.domain import domain


class WholePoints:
    """Distribution of a body's points with all points on each process. Each process computes the points in its own slabs
    (blocks of grid cells); in its loops all other slabs are empty."""

    is_spread = False

    def __init__(self, slabs: Slabs) -> None:
        self._slabs = slabs
        self.first = slabs.first

    def share_out(self) -> None:
        """Empty all slabs (blocks of grid cells) of other processes in `Slabs.first`, so that loops process the slabs of
        this process only."""
        first = self._slabs.first
        self.first = first.copy()
        first[:] = np.clip(first, *first[[domain.slabs.start, domain.slabs.stop]])

    def after_sorting(self, sort: Callable[[int], None]) -> None:
        """Restrict the loops to the slabs (blocks of grid cells) of this process after the points were sorted into slabs.

        sort: function that sorts the first n points; not used here, as all points are sorted already.
        """
        self.share_out()

    def take_own(self) -> slice:
        """Restrict `Slabs.first` (the first point of each slab), computed for all processes, to the rows of slabs (blocks
        of grid cells) of this process; return the slice of its points in the order of slabs, here all points."""
        if domain.is_cut:
            self.share_out()
        return slice(0, None)

    def hand_over(self) -> Callable[[], None]:
        """Return a function that restricts the loops to the slabs (blocks of grid cells) of this process, to be called
        after the rows of slabs are redistributed among processes."""

        def take_up() -> None:
            self._slabs.first[:] = self.first
            self.share_out()

        return take_up

    def fill(self, values: np.ndarray, order: np.ndarray | None = None) -> np.ndarray:
        """Complete the values of all points, shape (n, ...), in place with those that other processes computed for points
        of their slabs (blocks of grid cells). Return the values.

        order: storage index of each point in the order of slabs; None if the values are stored in the order of slabs.
        """
        if domain.is_cut:
            own = slice(self._slabs.first[0], self._slabs.first[-1])
            joined = domain.group.joined(values[own] if order is None else values[order[own]])
            values[slice(None) if order is None else order] = joined
        return values

    def joined(self, there: np.ndarray) -> np.ndarray:
        """Return `there`, the values of all points, shape (n, ...), unchanged, since each process stores all points."""
        return there

    def first_of_all(self) -> np.ndarray:
        """Return the number of the first point of each slab (a block of grid cells) among the points of all processes, and
        the end, shape (slabs + 1,)."""
        return self.first


class SpreadPoints:
    """Distribution of a body's points in which each process stores the points of its own slabs (blocks of grid cells) only,
    at the start of arrays with room for all points."""

    is_spread = True

    def __init__(self, slabs: Slabs, arrays: Mapping[str, np.ndarray]) -> None:
        self._slabs, self._arrays = slabs, arrays
        self.first = slabs.first

    def after_sorting(self, sort: Callable[[int], None]) -> None:
        """Send points to the processes that compute their slabs, and sort the received points in the receiving process;
        sort: function that sorts the first n points."""
        sort(domain.migrate(self._arrays, self.first))

    def take_own(self) -> slice:
        """Restrict `Slabs.first` (the first point of each slab), computed for all processes, to the rows of slabs (blocks
        of grid cells) of this process; return the slice of its points in the order of slabs."""
        if not domain.is_cut:
            return slice(0, None)
        begin, end = self.first[[domain.slabs.start, domain.slabs.stop]]
        self.first[:] = np.clip(self.first, begin, end) - begin
        return slice(begin, end)

    def hand_over(self) -> Callable[[], None]:
        """Return a function that sends the points to their new processes, to be called after the rows of slabs (blocks of
        grid cells) are redistributed; points arrive in storage order."""
        first = self.first_of_all()

        def take_up() -> None:
            domain.migrate(self._arrays, self.first)
            self.first[:] = first
            self.take_own()

        return take_up

    def fill(self, values: np.ndarray, order: np.ndarray | None = None) -> np.ndarray:
        """Return `values` unchanged: the arrays of this process contain only its own points, whose values this process
        computes itself."""
        return values

    def joined(self, there: np.ndarray) -> np.ndarray:
        """Gather the values of all points, shape (n, ...), from all processes and return them; there: values of the points
        that this process stores."""
        return domain.whole(there)

    def first_of_all(self) -> np.ndarray:
        """Return the number of the first point of each slab (a block of grid cells) among the points of all processes, and
        the end, shape (slabs + 1,)."""
        if not domain.is_cut:
            return self.first
        return np.concatenate([[0], np.cumsum(domain.complete(np.diff(self.first)))])

    def joined_again(self) -> WholePoints:
        """Gather the arrays of all points on each process, and return the matching `WholePoints`."""
        first = self.first_of_all()
        for array in self._arrays.values():
            array[: first[-1]] = domain.whole(array[: self.first[-1]])
        self.first[:] = first
        whole = WholePoints(self._slabs)
        if domain.is_cut:
            whole.share_out()
        return whole
