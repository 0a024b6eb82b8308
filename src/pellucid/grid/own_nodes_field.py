"""Velocity field of a body with its own nodes, which has its own equation of motion, and the grid nodes that it reaches.

Contact needs the momentum equation only at nodes to which other bodies contribute too. A membrane contributes to few nodes;
processing the rest of the grid would take most of the time of its step. The field therefore lists the nodes to which the body
contributes, and its loops process only these.
"""

from collections.abc import Iterable

import numpy as np

from pellucid.energy import StepWork
from pellucid.grid.chunks import CHUNK, chunks_of
from pellucid.grid.clearing import Clearing
from pellucid.grid.lattice import Grid, NodeFlags
from pellucid.grid.momentum import project_node
from pellucid.grid.nodal_conditions import (
    MASS_EPS,
    ConditionedNodes,
    ExternalAction,
    Supports,
    apply_rule,
    find_rule,
    is_unconstrained,
)
from pellucid.grid.nodal_fields import REMAP, STEP, fields_of
from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, stencil
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import joint_region, parallel_by_colour, parallel_loop
from pellucid.jit.vector import load, row, splat, store

WORD = 8  # flags that are read at once as one integer
NONE = np.zeros((0, 3))


@kernel(inner=True)
def _scatter_slab(s, mapped, force, counted, flags):
    functions, lattice, nodes, points, slabs = mapped.functions, mapped.lattice, mapped.nodes, mapped.points, mapped.slabs
    v, forced, last = points.velocity, len(force) > 0, -1
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(mapped.index, q)
        about = stencil(functions, lattice, points.position, p)
        wx, wy, wz = about.wx, about.wy, about.wz
        inertia = points.mass[p] * row(v[p, 0], v[p, 1], v[p, 2], counted)
        forces = row(force[p, 0], force[p, 1], force[p, 2], 0.0) if forced else splat(0.0)
        for a in range(len(wx)):
            for b in range(len(wy)):
                line, line_forces = wx[a] * wy[b] * inertia, wx[a] * wy[b] * forces
                for c in range(len(wz)):
                    I = node_at(about, lattice, a, b, c)
                    store(nodes.inertia, 4 * I, load(nodes.inertia, 4 * I) + wz[c] * line)
                    if forced:
                        store(nodes.forces, 4 * I, load(nodes.forces, 4 * I) + wz[c] * line_forces)
                    if about.start != last:
                        flags[I] = 1
        last = about.start


@kernel()
def _scatter_by_colour(n, mapped, force, counted, flags):
    parallel_by_colour(_scatter_slab, n, mapped.slabs.across, mapped, force, counted, flags)


def _scatter(n: int, mapped: Bundle, force: np.ndarray, counted: float, flags: np.ndarray) -> None:
    nodes = mapped.nodes
    joint_region.give_at_once(
        lambda: _scatter_by_colour(n, mapped, force, counted, flags),
        lambda: [nodes.inertia, flags[: len(nodes.mass)], *([nodes.forces] if len(force) else [])],
    )


@kernel()
def _list_flagged(words, flags, node):
    n = 0
    for k in range(len(words)):
        if words[k] != 0:
            for I in range(WORD * k, WORD * (k + 1)):
                if flags[I]:
                    node[n] = I
                    n += 1
    return n


@parallel_loop()
def _advance(chunk, node, field, dt):
    nodes, absorbing = field.nodes, len(field.external.absorption) > 0
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(node))):
        I = node[e]
        m = nodes.mass[I]
        over_m = 1.0 / m if m >= MASS_EPS else 0.0
        store(nodes.increments, 4 * I, splat(0.0))
        if not absorbing and is_unconstrained(field, I):
            store(nodes.velocities, 4 * I, over_m * load(nodes.inertia, 4 * I) + (dt * over_m) * load(nodes.forces, 4 * I))
            continue
        for d in range(3):
            old, rule = nodes.momentum[I, d] * over_m, find_rule(field, nodes.constrained[I, d], I, d, m, dt)
            nodes.velocity[I, d] = apply_rule(rule, old, old + dt * nodes.force[I, d] * over_m)


@parallel_loop()
def _project(chunk, node, field):
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(node))):
        project_node(field, node[e])


class ReachedNodes:
    """Sorted indices `node`, shape (n,), of the nodes to which points of the body contribute; no other node has mass. The
    methods compute momentum and velocities of these nodes."""

    def __init__(self, grid: Grid) -> None:
        nodes = grid.nodes
        words = len(nodes.mass) // WORD + 1
        self._flags = fields_of(NodeFlags)["reached"].allocate(WORD * words)
        self._words, self._room = self._flags.view(np.uint64), np.empty(WORD * words, np.int64)
        self._all = nodes
        self._clear, self._clear_momentum = (Clearing(when, grid.rows, nodes) for when in (STEP, REMAP))
        self.node = self._room[:0]

    def constrain(self, supports: Supports, external: ExternalAction) -> None:
        """Set the constraints of the nodes: supports with walls, and external actions with driven points (points with a
        prescribed motion) and absorbing faces."""
        self._field = Bundle(ConditionedNodes(self._all, supports, external))

    @property
    def _chunks(self) -> int:
        return chunks_of(len(self.node))

    def scatter(self, n: int, mapped: Bundle, force: np.ndarray | None) -> None:
        """Map mass and momentum of the body's points, divided into n slabs, and forces on them [N], shape (points, 3), to the
        nodes, and list the nodes. Replaces the previous values.

        mapped: bundle of `MappedPoints`; force: None if only mass and momentum are needed.
        """
        self._clear(self.node)
        self._words.fill(0)
        _scatter(n, mapped, NONE if force is None else force, 1.0, self._flags)
        self.node = self._room[: _list_flagged(self._words, self._flags, self._room)]

    def scatter_momentum(self, n: int, mapped: Bundle) -> None:
        """Map the momentum of the points to the grid nodes again, after their velocities changed but not their positions.
        Replaces the previous momentum; arguments as in `scatter`."""
        self._clear_momentum(self.node)
        _scatter(n, mapped, NONE, 0.0, self._flags)

    def advance(self, dt: float) -> None:
        """Compute the nodal velocities after a step dt [s] from the mapped momentum, internal forces and constraints, before
        contact."""
        _advance(self._chunks, self.node, self._field, dt)

    def project(self) -> None:
        """Compute `strain_velocity`: the velocities p/m from the momentum p mapped to the nodes and their mass m, with
        constraints."""
        _project(self._chunks, self.node, self._field)


class OwnNodesField(VelocityField):
    """Velocity field of one body with its own nodes; from the grid, the body receives only velocity increments by contact."""

    moves_points = False
    touches_on_nodes = True
    """True if the body may contact other fields on the nodes. Otherwise it contributes nothing to the nodes."""

    def __init__(self, name: str, grid: Grid) -> None:
        super().__init__(name, grid)
        self._reached = ReachedNodes(grid)
        self.awaiting = np.zeros(0, np.int64)
        """Sorted nodes at which contact may apply impulses in this step, shape (k,)."""

    may_be_let_go = False

    @property
    def reached(self) -> np.ndarray:
        return self._reached.node

    def set_actions(
        self,
        supports: Supports,
        external: ExternalAction,
        gravity: tuple[float, float, float],
        small_mass: float,
        flip: float,
    ) -> None:
        self._act(external)
        self._reached.constrain(supports, external)

    def share_gravity(self, share: float) -> None:
        """Do nothing: gravity acts on the body's own nodes, not on the nodes of the grid."""

    def clear(self) -> None:
        """Do nothing: the method `scatter` of this class resets the mass, momentum and forces of the grid nodes."""

    def scatter(self, n: int, mapped: Bundle, force: np.ndarray | None) -> None:
        """Map mass and momentum of the body's points, divided into n slabs, and the forces that act on them until the end of
        the step [N], shape (points, 3), to the nodes of the grid. Replaces the values of the previous step.

        mapped: bundle of `MappedPoints`; force: None if only mass and momentum are needed.
        """
        self._reached.scatter(n, mapped, force)

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {}

    def scatter_momentum(self, n: int, mapped: Bundle) -> None:
        """Map the momentum of the body's points, divided into n slabs, to the nodes again, after their velocities changed;
        mapped: bundle of `MappedPoints`."""
        self._reached.scatter_momentum(n, mapped)

    def await_impulses(self, nodes: Iterable[np.ndarray]) -> None:
        """Record the nodes at which contact may apply impulses, given as arrays of their indices; the body computes the work of
        contact itself."""
        self.awaiting = np.unique(np.concatenate([self.awaiting[:0], *nodes]))

    def advance(self, dt: float, counted: bool = False) -> None:
        self.pressed = False
        self._reached.advance(dt)
        self.external.impulse.fill(0.0)  # the work of prescribed motions is the body's, but for contact

    def add_impulses(self, impulse: np.ndarray, column: int, sign: float = 1.0, node: np.ndarray | None = None) -> np.ndarray:
        """Raise ValueError: conditions can apply impulses only to velocity fields whose nodes move points."""
        raise ValueError(f"the velocity field {self.name} does not move its body, which has nodes of its own")

    def works(self, dt: float) -> StepWork | None:
        """Return None: a body with its own nodes computes its works itself."""
        return None

    def project(self, dt: float | None = None, counted: bool = False) -> None:
        self._reached.project()
