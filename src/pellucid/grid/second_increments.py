"""Velocity increments of nodes by contact after the momentum of the points was mapped to the nodes a second time in a step
(MUSL)."""

from typing import Annotated, NamedTuple

import numpy as np

from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_fields import FOUND, RUN, NodalField, allocate
from pellucid.grid.nodal_momentum import NodalMomentum
from pellucid.ranks.domain import domain


class SecondNodes(NamedTuple):
    """Nodal array of the second increments; without rows until contact acts a second time."""

    second_increment: Annotated[
        np.ndarray, NodalField(3, FOUND, RUN, "m/s", "velocity increments by contact after momentum was mapped a second time")
    ]


class SecondIncrements:
    """Velocity increments of the nodes of a velocity field by the second impulses of contact in a step.

    `increment`: the increments [m/s], shape (nodes, 3); empty without contact.
    """

    def __init__(self, grid: Grid) -> None:
        self._grid, self.increment = grid, allocate(SecondNodes, 0).second_increment
        self._nodes: list[np.ndarray] = []

    def clear(self) -> None:
        """Reset the increments to zero, before contact acts a second time in the step."""
        if not len(self.increment):
            self.increment = allocate(SecondNodes, self._grid.n_nodes).second_increment
        for node in self._nodes:
            self.increment[node] = 0.0
        self._nodes = []

    def add(self, node: np.ndarray, increment: np.ndarray) -> None:
        """Add velocity increments [m/s], shape (n, 3), at the nodes with the indices `node`, shape (n,)."""
        self.increment[node] += increment
        self._nodes.append(node.copy())  # detection writes into its own

    def layers(self) -> tuple[int, int]:
        """Return the first and last layer of nodes, along the axis of the slabs (blocks of grid cells), in which the increment
        of any process is not zero.

        All processes return the same layers: the choice of the slabs that are summed again must not depend on where the
        rows of slabs are divided among processes.
        """
        lattice = self._grid.lattice
        layers = np.concatenate(self._nodes) // lattice.strides[lattice.slab_axis]
        nowhere = self._grid.n_nodes
        first, last = (int(layers.min()), int(layers.max())) if len(layers) else (nowhere, -1)
        if self._grid.periodic[lattice.slab_axis] and len(layers):  # points at either end reach them
            first, last = 0, nowhere
        return -int(domain.largest(-first)), int(domain.largest(last))

    def work(self, momentum: NodalMomentum, dt: float) -> float:
        """Return the work [J], in half a step dt [s], of the internal forces of bodies whose points store no internal energy
        along the increments; momentum: momentum of the nodes of the field."""
        if not self._nodes:
            return 0.0
        nodes = np.unique(np.concatenate(self._nodes))
        return momentum.half_work(nodes, self.increment[nodes], dt)
