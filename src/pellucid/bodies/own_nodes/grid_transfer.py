"""Transfers between a body with its own nodes and the grid, for contact; the nodes are indexed by grid cell."""

from collections.abc import Callable, Mapping

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.passes.moving import Stay, move_points, moving
from pellucid.grid.points import ByIndex, MappedPoints, PointArrays
from pellucid.grid.shared_points import WholePoints
from pellucid.grid.sorting import kept_of, restore_slabs, slabs_of, sort_by_nodes
from pellucid.grid.transfer import gather_vectors
from pellucid.jit.bundle import Bundle
from pellucid.ranks.domain import domain


class GridCoupling:
    """Transfers mass, momentum and contact velocities between the nodes of a body and the grid, for contact with other bodies.

    Uses the arrays of the body and keeps an index of its nodes by cell, so that the nodes stay in mesh order. functions: shape
    functions of the grid; position, velocity: shape (n, 3) [m], [m/s]; mass: shape (n,) [kg]; volume: shape (n,) [m³], None
    for membranes.
    """

    def __init__(
        self,
        velocity_field: OwnNodesField,
        functions: GridFunctions,
        position: np.ndarray,
        velocity: np.ndarray,
        mass: np.ndarray,
        volume: np.ndarray | None = None,
        whole: bool = False,
    ) -> None:
        """velocity_field: velocity field of the body; functions: shape functions of the grid; position, velocity: [m], [m/s],
        shape (n, 3); mass: nodal masses [kg], shape (n,); volume: nodal volumes [m³], shape (n,), None for membranes; whole:
        True if each process handles the nodes of all slabs (layers of grid cells), not only of its own slabs.
        """
        self._whole = whole
        self.velocity_field, self.functions = velocity_field, functions
        self._points = PointArrays(position, velocity, mass)
        if volume is not None:
            self._points = self._points._replace(volume=volume)
        self._order = np.arange(len(mass))
        self._spare = np.zeros(0, np.int64)
        self.increment = np.zeros((len(mass), 3))
        """Velocity increments of the nodes from contact in this step [m/s], shape (n, 3)."""
        grid, index = velocity_field.grid, ByIndex(self._order)
        self.slabs = slabs_of(grid.lattice, functions)
        self._shared = WholePoints(self.slabs)
        self.n_slabs = len(self.slabs.layers)
        mapped = MappedPoints(functions, grid.lattice, grid.nodes, self._points, self.slabs, index)
        self.mapped, self._staying = Bundle(mapped), moving(mapped, Stay())
        self.sort()

    def sort(self) -> None:
        """Sort the index of the nodes by grid cell; the nodes themselves keep their order."""
        ordered = {"order": self._order, "position": self._points.position[self._order]}
        self._spare = sort_by_nodes(ordered, self._spare, self.velocity_field.grid.lattice, self.functions, self.slabs)
        if domain.is_cut and not self._whole:
            self._shared.share_out()

    def hand_over(self) -> Callable[[], None]:
        """Prepare a new distribution of the nodes among processes: complete the data that other processes need. Returns the
        function that applies the new distribution.
        """
        domain.complete(self.slabs.left_slab)
        return self._shared.hand_over()

    def sort_if_needed(self) -> None:
        """Sort the index again if a node left its slab (layer of grid cells); call this before the first scatter of a step."""
        if domain.any(bool(self.slabs.left_slab.any())):
            self.sort()

    def scatter(self, force: np.ndarray | None = None) -> None:
        """Scatter mass and momentum of the nodes to the grid, and the forces on the nodes that act until the end of the step
        [N], shape (n, 3); None for no forces.
        """
        self.velocity_field.scatter(self.n_slabs, self.mapped, force)

    def scatter_momentum(self) -> None:
        """Scatter only the momentum of the nodes to the grid, after the nodal velocities changed."""
        self.velocity_field.scatter_momentum(self.n_slabs, self.mapped)

    def gather(self) -> np.ndarray:
        """Return the velocity increments of the nodes from contact in this step [m/s], shape (n, 3)."""
        if self.velocity_field.pressed:
            gather_vectors(self.n_slabs, self.mapped, self.velocity_field.grid.nodes.velocity_increment, self.increment)
            self._shared.fill(self.increment, self._order)
        else:
            self.increment.fill(0.0)
        return self.increment

    def gather_second(self) -> np.ndarray:
        """Return the velocity increments of the nodes [m/s], shape (n, 3), from the second impulses of contact, which act
        after momentum was mapped to the grid a second time (MUSL).
        """
        second = np.empty_like(self.increment)
        gather_vectors(self.n_slabs, self.mapped, self.velocity_field.second.increment, second)
        return self._shared.fill(second, self._order)

    def check_positions(self) -> tuple[int, int] | None:
        """Check the positions of the nodes after a step, and mark the slabs (layers of grid cells) that a node has left.
        Returns a fault code (of `pellucid.grid.points`) and the number of the node with the fault, such as a node outside
        the grid; None without a fault."""
        move_points(self._staying, 0.0)
        found = np.flatnonzero(domain.complete(self.slabs.fault)[:, 0])
        return (int(self.slabs.fault[found[0], 0]), int(self.slabs.fault[found[0], 1])) if len(found) else None

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays for a checkpoint: the order of the nodes by grid cell, and the slabs (layers of grid cells)."""
        domain.complete(self.slabs.left_slab)
        return {"order": self._order} | kept_of(self.slabs) | {"first": self._shared.first}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the order of the nodes and the slabs (layers of grid cells) from the arrays of a checkpoint (see
        `state_arrays`).
        """
        self._order[:] = arrays["order"]
        restore_slabs(self.slabs, arrays)
        if not self._whole:
            self._shared.take_own()
