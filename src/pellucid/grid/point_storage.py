"""Storage of the points of a body on the grid: arrays sorted by grid nodes, and their distribution among processes."""

from collections.abc import Callable, Mapping

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.grid.lattice import Lattice
from pellucid.grid.shared_points import SpreadPoints, WholePoints
from pellucid.grid.sorting import ShortRuns, kept_of, restore_slabs, slabs_of, sort_by_nodes
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum
from pellucid.state import FIELDS, of_owner, with_owner


class PointStorage:
    """Arrays of the points of a body on the grid, sorted by grid nodes and divided into slabs (layers of grid cells).

    The points are sorted again when one leaves its slab, or when sorting saves time. The first `n_present` rows are the
    points that have not left the grid; the points after them have no mass and belong to no slab.
    """

    def __init__(
        self,
        arrays: dict[str, np.ndarray],
        lattice: Lattice,
        functions: GridFunctions,
        there: int | None,
        sorting_cost: float,
        follow_order: Callable[[], None],
    ) -> None:
        """arrays: arrays of the points by name; lattice: cells of the grid; functions: shape functions along x, y, z; there:
        number of rows that are points of this process, None if each process stores all points; sorting_cost: cost of sorting
        per point, see `ShortRuns`; follow_order: function that updates data that depend on the order of the points.
        """
        self.arrays = arrays
        self.slabs = slabs_of(lattice, functions)
        """Slabs (layers of grid cells) into which the points are divided, with sums over the points of each."""
        self.slabs.first[-1] = len(arrays["mass"]) if there is None else there
        self.shared: SpreadPoints | WholePoints
        """Distribution of the points among processes."""
        self.shared = WholePoints(self.slabs) if there is None else SpreadPoints(self.slabs, arrays)
        self.short_runs: ShortRuns
        self._lattice, self._functions = lattice, functions
        self._sorting_cost, self._follow_order = sorting_cost, follow_order
        self._spare = np.zeros(0, np.int64)
        self._orders = dict[str, np.ndarray]()

    @property
    def n_present(self) -> int:
        """Number of points that have not left the grid; if the points are distributed among processes, on this process."""
        return int(self.shared.first[-1])

    @property
    def is_spread(self) -> bool:
        """True if this process stores only some of the points."""
        return domain.is_cut and self.shared.is_spread

    def present(self, name: str) -> np.ndarray:
        """Return the rows of an array that belong to the points present on this process."""
        return self.arrays[name][: self.n_present]

    def joined(self, name: str) -> np.ndarray:
        """Return an array of the points present, of all processes, in storage order."""
        self.complete(name)
        return self.shared.joined(self.present(name))

    def order(self) -> np.ndarray:
        """Return the storage rows of the points present, of all processes, sorted by point number, shape (n,); computed once
        between sortings.
        """
        if domain.joins not in self._orders:
            self._orders[domain.joins] = np.argsort(self.shared.joined(self.present("id")))
        return self._orders[domain.joins]

    def complete(self, *names: str) -> None:
        """Fill, in the arrays with these names, the rows of points that other processes computed; nothing to do in a run with
        one process.
        """
        for name in names if domain.is_cut else ():
            self.shared.fill(self.present(name))

    def complete_all(self) -> None:
        """Complete all arrays with the rows that other processes computed; required before the state of points of other slabs
        is read."""
        self.complete(*(name for name in self.arrays if name not in ("id", "mass")))

    def sums(self) -> np.ndarray:
        """Return the sums over all points, one for each column of `Slabs.sums`: kinetic energy, momentum, power and others."""
        return ordered_sum(domain.complete(self.slabs.sums))

    # order

    def sort_if_needed(self) -> None:
        """Sort the points again if one left its slab (layer of grid cells), or if short sequences of points with the same grid
        nodes make the loops slower than sorting is.
        """
        if self.short_runs.sorting_pays or domain.any(bool(np.count_nonzero(self.slabs.left_slab))):
            self.complete_all()
            self.sort()

    def sort(self) -> None:
        """Sort the points by the grid nodes around them and divide them into slabs (layers of grid cells). The arrays must be
        complete, see `complete_all`.
        """
        self._orders.clear()
        self._sort_first(self.n_present)
        if domain.is_cut:
            self.shared.after_sorting(self._sort_first)
        self._follow_order()
        self.short_runs = ShortRuns(int(self.shared.first_of_all()[-1]), self._sorting_cost)

    def _sort_first(self, n: int) -> None:
        first = {name: array[:n] for name, array in self.arrays.items()}
        self._spare = sort_by_nodes(first, self._spare, self._lattice, self._functions, self.slabs)

    def put_behind(self, left: np.ndarray) -> None:
        """Move points that have left the grid behind the others in all arrays, and sort the others. left: mask of these points,
        shape (n_present,).
        """
        order = np.argsort(left, kind="stable")
        for array in self.arrays.values():
            array[: len(order)] = array[order]
        self.shared.first[-1] = len(order) - np.count_nonzero(left)
        self.sort()

    # distribution among processes

    def keep_whole(self) -> None:
        """Keep all points on every process from now on, for conditions that need all points of the body."""
        if isinstance(self.shared, SpreadPoints):
            self.shared = self.shared.joined_again()
            self._orders.clear()
            self._follow_order()

    def hand_over(self) -> Callable[[], None]:
        """Prepare a new distribution of slabs (layers of grid cells) among processes: complete the data that other processes
        need. Returns the function that applies the new distribution.
        """
        self.complete_all()
        domain.complete(self.slabs.left_slab)
        self._orders.clear()
        return self.shared.hand_over()

    # checkpoints

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays of the points and their division into slabs (layers of grid cells), by name, for a checkpoint."""
        self.complete_all()
        domain.complete(self.slabs.left_slab)
        slabs = with_owner("slabs", kept_of(self.slabs) | {"first": self.shared.first_of_all()})
        arrays = {name: domain.whole(self.present(name)) for name in self.arrays} if self.is_spread else self.arrays
        return {**arrays, **slabs, "slabs/short_runs": self.short_runs.counts}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the state from arrays of `state_arrays`, bit for bit."""
        restore_slabs(self.slabs, of_owner("slabs", arrays))
        own = self.shared.take_own()
        for name, array in self.arrays.items():
            kept = arrays[name][own]
            array[: len(kept)] = kept
        self._orders.clear()
        self.short_runs.counts[:] = arrays["slabs/short_runs"]
        self._follow_order()

    def load(self, state: Mapping[str, np.ndarray]) -> None:
        """Load arrays of an earlier run, in the order of point numbers; arrays that this run did not store start at zero if
        their field allows it."""
        number = self.present("id")
        for name in self.arrays.keys() - {"id"}:
            if name in state or not FIELDS[name].begins:
                self.present(name)[...] = state[name][number]
        left = self.joined("mass") == 0.0
        if left.any():
            self.keep_whole()
            self.put_behind(left)
        else:
            self.sort()
