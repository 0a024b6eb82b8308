"""Distribution of the points of a body, sorted into slabs, among processes: all points on each process, or distributed.

`first` holds the first point of each slab among the points of this process, and the end. Both classes have the same
methods: `after_sorting`, and `hand_over` before rows are redistributed.
"""

from collections.abc import Callable, Mapping

import numpy as np

from pellucid.grid.points import Slabs
from pellucid.ranks.domain import domain


class WholePoints:
    """Each process has all points, and does those of its slabs: loops over slabs find no points in others."""

    is_spread = False

    def __init__(self, slabs: Slabs) -> None:
        self._slabs = slabs
        self.first = slabs.first

    def share_out(self) -> None:
        """Do the slabs of this process from now on."""
        first = self._slabs.first
        self.first = first.copy()
        first[:] = np.clip(first, *first[[domain.slabs.start, domain.slabs.stop]])

    def after_sorting(self, sort: Callable[[int], None]) -> None:
        """The same again; sort: sorts the first of the points, so many."""
        self.share_out()

    def take_own(self) -> slice:
        """`first` says where those of all processes begin: take up the rows of this process; which of all points it has."""
        if domain.is_cut:
            self.share_out()
        return slice(0, None)

    def hand_over(self) -> Callable[[], None]:
        """Return the function that adopts the new rows."""

        def take_up() -> None:
            self._slabs.first[:] = self.first
            self.share_out()

        return take_up

    def fill(self, values: np.ndarray, order: np.ndarray | None = None) -> np.ndarray:
        """Fill what points of its slabs have, shape (n, ...), with what other processes found. Returns it.

        order: where the values stand, in the order in which slabs count the points; None where they stand in it.
        """
        if domain.is_cut:
            own = slice(self._slabs.first[0], self._slabs.first[-1])
            joined = domain.group.joined(values[own] if order is None else values[order[own]])
            values[slice(None) if order is None else order] = joined
        return values

    def joined(self, there: np.ndarray) -> np.ndarray:
        """Gather point data, shape (n, ...), from all processes."""
        return there

    def first_of_all(self) -> np.ndarray:
        """Return the first point of each slab among the points of all processes, and the end."""
        return self.first


class SpreadPoints:
    """Each process has the points of its slabs, in front in arrays that have room for all."""

    is_spread = True

    def __init__(self, slabs: Slabs, arrays: Mapping[str, np.ndarray]) -> None:
        self._slabs, self._arrays = slabs, arrays
        self.first = slabs.first

    def after_sorting(self, sort: Callable[[int], None]) -> None:
        """Points go to the processes that have their slabs, and are sorted there; sort: sorts the first of them, so many."""
        sort(domain.migrate(self._arrays, self.first))

    def take_own(self) -> slice:
        """`first` says where those of all processes begin: take up the rows of this process; which of all points it has."""
        if not domain.is_cut:
            return slice(0, None)
        begin, end = self.first[[domain.slabs.start, domain.slabs.stop]]
        self.first[:] = np.clip(self.first, begin, end) - begin
        return slice(begin, end)

    def hand_over(self) -> Callable[[], None]:
        """Return the function that adopts the new rows; points arrive in storage order."""
        first = self.first_of_all()

        def take_up() -> None:
            domain.migrate(self._arrays, self.first)
            self.first[:] = first
            self.take_own()

        return take_up

    def fill(self, values: np.ndarray, order: np.ndarray | None = None) -> np.ndarray:
        """The values: this process has no others."""
        return values

    def joined(self, there: np.ndarray) -> np.ndarray:
        """Gather point data, shape (n, ...), from all processes."""
        return domain.whole(there)

    def first_of_all(self) -> np.ndarray:
        """Return the first point of each slab among the points of all processes, and the end."""
        if not domain.is_cut:
            return self.first
        return np.concatenate([[0], np.cumsum(domain.complete(np.diff(self.first)))])

    def joined_again(self) -> WholePoints:
        """Each process has all points from now on."""
        first = self.first_of_all()
        for array in self._arrays.values():
            array[: first[-1]] = domain.whole(array[: self.first[-1]])
        self.first[:] = first
        whole = WholePoints(self._slabs)
        if domain.is_cut:
            whole.share_out()
        return whole
