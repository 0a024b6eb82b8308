"""Momentum update of the nodes of a velocity field, and the works of the step."""

from collections.abc import Iterable

import numpy as np

from pellucid.energy import FIRST_LOAD, StepWork, row_length, step_work
from pellucid.grid.chunks import ALL, ChunkedNodes, by_row
from pellucid.grid.lattice import NodeFlags, Nodes
from pellucid.grid.momentum import NOWHERE, AdvancedNodes, advance, count_works, project, sum_strain_lag
from pellucid.grid.nodal_conditions import ExternalAction, Supports, free_axes
from pellucid.grid.nodal_fields import ROW, VECTOR, fields_of
from pellucid.jit.bundle import Bundle
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum


class NodalMomentum:
    """Momentum update of the nodes of one velocity field, and its works.

    nodes: nodal arrays. rows: first node of each row of slabs, see `pellucid.grid.chunks.by_row`. supports, external:
    constraints and external actions, read in every step. gravity [m/s²]. small_mass [kg]: for nodes with less mass,
    internal forces are left out of the velocity that strains the points. flip: fraction of FLIP in the transfer to the
    points. separate_forces: see `FieldNodes`.
    """

    def __init__(
        self,
        nodes: Nodes,
        rows: np.ndarray,
        supports: Supports,
        gravity: tuple[float, float, float],
        small_mass: float,
        flip: float,
        external: ExternalAction,
        separate_forces: np.ndarray | None = None,
    ) -> None:
        self.small_mass = small_mass
        self.flip = flip
        self.is_counted = False
        """True if the works of this step are already computed. Then only the velocities of nodes that await impulses may
        still change."""
        self._rows, self._all = rows, by_row(rows)
        self._chunks = self._all.chunks.n
        self._columns = FIRST_LOAD + len(external.loads)
        self._awaiting, self._lag_is_counted = NOWHERE, False
        self._listed, self._waits = by_row(rows, ALL[:0]), False
        n = 2 * self._chunks  # of all nodes, and of those that are listed
        self._sums = np.zeros((n, row_length(self._columns, len(supports.velocity) + 1)))
        self._lags = np.zeros((n, 1))
        load = fields_of(AdvancedNodes)["load"].allocate(external.loads.shape[1] if len(external.loads) else 0)
        self._full_gravity, self.gravity_share = np.array(gravity, float), 1.0
        self._gravity = self._full_gravity.copy()
        separate = np.zeros(0) if separate_forces is None else separate_forces
        self._bundle = Bundle(
            AdvancedNodes(nodes, supports, self._gravity, external, load, separate, self._sums, self._all.chunks.edges.copy())
        )
        self._cut = -1
        self._find_near()

    def _find_near(self) -> None:
        """Find the chunks of the nodes to which points of this process may contribute; all other nodes have no mass in the
        arrays of this process. The chunks change only when the grid is divided among processes again."""
        if self._cut == domain.cuts_made:
            return
        self._cut = domain.cuts_made
        self._first, end = domain.near(self._all.of_row)
        self._n, edges = end - self._first, self._all.chunks.edges[self._first : end + 1]
        self._near = ChunkedNodes(ALL, edges)
        self._bundle.edges[: len(edges)] = edges

    @property
    def advanced(self) -> Bundle:
        """Nodes of the velocity field with the actions on them and their constraints, a bundle of `AdvancedNodes` for
        kernels."""
        return self._bundle

    @property
    def n_chunks(self) -> int:
        """Number of chunks (ranges of grid nodes, each processed by one thread) into which all nodes are divided."""
        return self._chunks

    def near(self) -> int:
        """Return the number of chunks (ranges of grid nodes) that points of this process reach; these are the first chunks
        in `AdvancedNodes.edges`."""
        self._find_near()
        return self._n

    def sum_of_near(self, sums: np.ndarray) -> np.ndarray:
        """Return the sum of values of chunks (ranges of grid nodes) over the chunks of all processes. sums: values of
        chunks, shape (chunks, ...), of which this process uses the first rows, for the chunks that its points reach (see
        `near`)."""
        return ordered_sum(domain.of_chunks(sums[: self._n], self._all.of_row, self._first))

    @property
    def gravity(self) -> np.ndarray:
        """Gravity that acts on the nodes [m/s²], shape (3,)."""
        return self._gravity.copy()

    def share_gravity(self, share: float) -> None:
        """Set gravity to a fraction, 0 to 1, of its full value."""
        self.gravity_share, self._gravity[:] = share, share * self._full_gravity

    def await_impulses(self, nodes: Iterable[np.ndarray]) -> None:
        """Set the nodes that may receive impulses in this step after the momentum update; nodes: arrays of their indices."""
        if not len(self._awaiting):
            self._awaiting = fields_of(NodeFlags)["awaiting"].allocate(len(self._bundle.nodes.mass))
        self._awaiting[self._listed.chunks.node] = 0
        lists = [ALL]
        for node in nodes:
            lists.append(node[self._awaiting[node] == 0])
            self._awaiting[node] = 1
        self._listed = by_row(self._rows, np.sort(np.concatenate(lists)))
        self._waits = domain.any(self._listed.chunks.n > 0)

    def advance(self, dt: float, counted: bool = False) -> None:
        """Advance the momentum p of every node over a step dt [s] to p + dt (f + m g), with the forces f, the mass m and
        the acceleration of gravity g, and apply the supports. Fills the nodal arrays velocity, velocity_increment and
        strain_velocity.

        counted: True if only the velocities of nodes that await impulses can still change in this step; the works of all
        other nodes are then computed at once.
        """
        self._sums.fill(0.0)
        self._find_near()
        how = self._bundle, dt, self.small_mass, self.flip, int(counted)
        advance(self._n, *how, self._near, self._awaiting)
        self.is_counted, self._lag_is_counted = counted, False

    def works(self, dt: float) -> StepWork:
        """Return the works of the step dt [s] and the impulses of the supports, once the nodal velocities of the step are
        final.

        Forces do work along the mean of the velocities before and after the step. The sum of all works is then the change
        in kinetic energy of points that receive the nodal increments, except for the loss by mass lumping
        (`transfer_heat`). At a node constrained by a support or driven points (points with a prescribed motion), forces
        work along the prescribed velocity, and the impact of arriving mass is heat. At nodes of very small mass, forces and
        increments are large and opposite. There, forces other than gravity work along the velocity before the step, and
        only the increment by gravity is squared. Fills mean_velocity and increment_energy, and resets the momentum to zero.
        """
        how = self._bundle, dt, self.small_mass
        if not self.is_counted:
            count_works(self._n, 0, self._near, NOWHERE, *how)
        elif self._waits:
            count_works(self._listed.chunks.n, self._chunks, self._listed.chunks, NOWHERE, *how)
        done = step_work(self._summed(self._sums), self._columns)
        return done._replace(gravity_mass=self.gravity_share * done.gravity_mass)

    def strain_lag_work(self, dt: float) -> float:
        """Return the difference [J] in a step dt [s] between the work of nodal forces along the mean velocity and the work
        of the stress along `strain_velocity`, for bodies whose points store no internal energy. The difference is part of
        the energy lost by mass lumping."""
        how = self._bundle, dt, self.small_mass, self._lags
        if not self._lag_is_counted:
            self._lags.fill(0.0)
            sum_strain_lag(self._n, 0, self._near, NOWHERE, *how)
        elif self._waits:
            sum_strain_lag(self._listed.chunks.n, self._chunks, self._listed.chunks, NOWHERE, *how)
        return float(self._summed(self._lags)[0])

    def _summed(self, sums: np.ndarray) -> np.ndarray:
        """Return the sum of values of chunks over the chunks of all processes; sums: rows for the chunks of all nodes, followed
        by rows for the chunks of nodes that await impulses."""
        found = domain.of_chunks(sums[: self._chunks], self._all.of_row, self._first)
        if self._waits:
            listed = sums[self._chunks : self._chunks + self._listed.chunks.n]
            found = np.concatenate([found, domain.of_chunks(listed, self._listed.of_row)])
        return ordered_sum(found)

    def find_lost_velocity(self, momentum: np.ndarray, node: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Return the decrease in velocity [m/s], shape (n, 3), that a drag caused at the start of a step, of all nodes or those
        with the indices `node`; zero along axes whose velocity supports or driven points determine.

        momentum: nodal momentum removed by the drag [kg m/s], shape (nodes, 3).
        """
        nodes, taken = self._bundle.nodes, momentum[node]
        moves = free_axes(nodes, self._bundle.external, node)
        return np.divide(taken, nodes.mass[node, None], out=np.zeros_like(taken), where=moves)

    def half_work(self, node: np.ndarray | slice, increment: np.ndarray, dt: float) -> float:
        """Return the work [J] of internal forces along velocity increments [m/s], shape (n, 3), of the nodes with the
        indices `node`, over half a step dt [s]; only forces of bodies whose points store no internal energy are counted."""
        nodes, separate = self._bundle.nodes, self._bundle.separate_forces.reshape(-1, ROW)[:, VECTOR]
        force = nodes.force[node] - separate[node] if len(separate) else nodes.force[node]
        return 0.5 * dt * float(np.sum(domain.of_nodes(force * increment, None if isinstance(node, slice) else node)))

    def impulse_velocity(self, node: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Return the mean velocity [m/s] of nodes, shape (n, 3), for the work of impulses applied after the momentum
        update.

        This is `mean_velocity`, along which forces do work, except at nodes that driven points (points with a prescribed
        motion) partly constrain, since impulses are applied after this constraint. node: indices of the nodes; default: all
        nodes.
        """
        nodes, driven = self._bundle.nodes, self._bundle.external.driven_mass
        if not len(driven):
            return np.asarray(nodes.mean_velocity[node])
        moved = (driven[node] > 0.0) & (nodes.constrained[node] == 0)
        return np.where(moved, nodes.velocity[node] - 0.5 * nodes.velocity_increment[node], nodes.mean_velocity[node])

    def project(self, dt: float | None = None, counted: bool = False) -> None:
        """Compute `strain_velocity`: the velocities p/m from the momentum p mapped to the nodes and their mass m, with
        constraints.

        dt: the step [s] if the momentum has been advanced, else None. counted: True if `strain_lag_work` will be called in
        this step; its work is then computed now, except for nodes that await impulses.
        """
        self._lag_is_counted = counted
        self._lags.fill(0.0)
        self._find_near()
        how = self._near, self._awaiting, dt or 0.0, self.small_mass, self._lags
        project(self._n, self._bundle, int(dt is not None), int(counted), *how)
