"""Storage of the points of a body on the grid: sorting by grid nodes, distribution among processes, and checkpoints."""

from collections.abc import Callable, Mapping
from math import fsum
from typing import Protocol

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.bodies.point_fields import PointFields
from pellucid.grid.lattice import Grid
from pellucid.grid.points import Slabs
from pellucid.grid.shared_points import SpreadPoints, WholePoints
from pellucid.grid.sorting import ShortRuns, kept_of, restore_slabs, sort_by_nodes
from pellucid.ranks.domain import domain
from pellucid.reductions import exact_parts, ordered_sum
from pellucid.state import FIELDS, of_owner, with_owner


class FollowingSurface(Protocol):
    """A contact surface whose points move with the points of a body on the grid."""

    def find_hosts(self) -> None:
        """Update the data that depend on the order in which the points of the body are stored."""

    def follow(self, dt: float) -> None:
        """Move the surface with the body over a step dt [s]."""

    def state_arrays(self) -> Mapping[str, np.ndarray]: ...
    def restore(self, arrays: Mapping[str, np.ndarray]) -> None: ...


class SortedPoints(PointFields):
    """Base class of bodies of points on the grid: points are sorted by their nodes when one leaves its slab (layer of grid
    cells), or when sorting saves time."""

    sorting_cost = 1.0
    """Cost of sorting per point, in units of the cost of a vector of points with the same nodes (60 to 65 ns): 50 ns, and
    15 ns in the next step."""

    contact_surface: FollowingSurface | None = None
    """Contact surface of the body; None if contact is computed on the grid nodes."""

    grid: Grid
    functions: GridFunctions
    slabs: Slabs
    """Slabs (layers of grid cells) into which the points are divided, with sums over the points of each."""
    _spare: np.ndarray
    _short_runs: ShortRuns
    _goes_on = False
    """True if the body continues from an earlier run."""
    _begun_surface: Mapping[str, np.ndarray] = {}
    """Arrays of the contact surface in that run."""

    def sort(self) -> None:
        """Sort the points by the grid nodes around them and divide them into slabs (layers of grid cells)."""
        self.complete_arrays()
        self._sort()

    def _sort(self) -> None:
        self._orders.clear()
        self._sort_first(self.n_there)
        if domain.is_cut:
            self.shared.after_sorting(self._sort_first)
        self._follow_order()
        self._short_runs = ShortRuns(int(self.shared.first_of_all()[-1]), self.sorting_cost)

    def _sort_first(self, n: int) -> None:
        there = {name: array[:n] for name, array in self.arrays.items()}
        self._spare = sort_by_nodes(there, self._spare, self.grid.lattice, self.functions, self.slabs)

    def sort_if_needed(self) -> None:
        """Sort the points again if one left its slab (layer of grid cells), or if short sequences of points with the same grid
        nodes make the loops slower than sorting is.
        """
        if self._short_runs.sorting_pays or domain.any(bool(np.count_nonzero(self.slabs.left_slab))):
            self.sort()

    def _follow_order(self) -> None:
        """Update the data of the contact surface that depend on the order in which the points are stored, after they were
        sorted.
        """
        if self.contact_surface is not None:
            self.contact_surface.find_hosts()

    # distribution among processes

    def _sharing(self) -> SpreadPoints | WholePoints:
        """Return the initial distribution of the points among processes: all points on each process."""
        return WholePoints(self.slabs)

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
        self.complete_arrays()
        domain.complete(self.slabs.left_slab)
        self._orders.clear()
        return self.shared.hand_over()

    def complete_arrays(self) -> None:
        """Complete all arrays with the rows that other processes computed; required before the state of points of other slabs
        is read."""
        self._complete(*(name for name in self.arrays if name not in ("id", "mass")))

    def sums(self) -> np.ndarray:
        """Return the sums over all points, one for each column of `Slabs.sums`: kinetic energy, momentum, power and others."""
        return ordered_sum(domain.complete(self.slabs.sums))

    @property
    def mass(self) -> float:
        """Return the mass of the body [kg], bitwise equal for any order of points and any number of processes."""
        if not (domain.is_cut and self.shared.is_spread):
            return super().mass
        return fsum(part for parts in domain.group.each(exact_parts(self._there("mass"))) for part in parts)

    def _put_behind(self, left: np.ndarray) -> None:
        """Move points that have left the grid behind the others in all arrays. left: mask of these points, shape (n_there,).
        The points must be sorted.
        """
        order = np.argsort(left, kind="stable")
        for array in self.arrays.values():
            array[: len(order)] = array[order]
        self._orders.clear()
        self.shared.first[-1] = len(order) - np.count_nonzero(left)

    # checkpoints

    def state_arrays(self) -> dict[str, np.ndarray]:
        self.complete_arrays()
        domain.complete(self.slabs.left_slab)
        slabs = with_owner("slabs", kept_of(self.slabs) | {"first": self.shared.first_of_all()})
        elements = {f"elements/{name}": array for name, array in self.element_arrays.items()}
        surface = self.contact_surface.state_arrays() if self.contact_surface is not None else {}
        arrays = self.arrays
        if domain.is_cut and self.shared.is_spread:
            arrays = {name: domain.whole(self._there(name)) for name in arrays}
        return {**arrays, **elements, **slabs, "slabs/short_runs": self._short_runs.counts, **surface}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        restore_slabs(self.slabs, of_owner("slabs", arrays))
        own = self.shared.take_own()
        for name, array in self.arrays.items():
            kept = arrays[name][own]
            array[: len(kept)] = kept
        for name, array in self.element_arrays.items():
            array[...] = arrays[f"elements/{name}"]
        self._orders.clear()
        self._short_runs.counts[:] = arrays["slabs/short_runs"]
        if self.contact_surface is not None:
            self.contact_surface.restore(arrays)
        self._follow_order()

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        """Load the arrays of an earlier run; arrays that this run did not store start at zero if their field allows it."""
        number = self._there("id")
        for name in self.arrays.keys() - {"id"}:
            if name in state or not FIELDS[name].begins:
                self._there(name)[...] = state[name][number]
        for name, array in self.element_arrays.items():
            array[...] = state[f"elements/{name}"]
        left = self.stored_field("mass") == 0.0
        if left.any():
            self.keep_whole()
            self._put_behind(left)
        self.sort()
        self._goes_on = True
        self._begun_surface = {name: array for name, array in state.items() if name.startswith("surface/")}
