"""A velocity field: grid nodes shared by some bodies, and their momentum."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, NamedTuple, Protocol

import numpy as np

from pellucid.energy import StepWork
from pellucid.grid.clearing import Clearing
from pellucid.grid.lattice import Grid, Nodes
from pellucid.grid.nodal_conditions import ExternalAction, Supports, free_axes
from pellucid.grid.nodal_fields import STEP, SUM, allocate, rows, with_memory
from pellucid.grid.nodal_momentum import NodalMomentum
from pellucid.grid.second_increments import SecondIncrements
from pellucid.grid.viscous_rows import ViscousRows
from pellucid.jit import kernel
from pellucid.ranks.domain import domain


class FieldNodes(NamedTuple):
    """Optional nodal arrays of a velocity field, in addition to `Nodes`; without rows if not requested."""

    separate_forces: Annotated[
        np.ndarray, rows(SUM, STEP, "N", "internal forces of bodies that keep heat, until momentum is advanced")
    ]


class ShapedWall(Protocol):
    """Interface of a wall that acts on the nodes near the surface of a shape, and that implicit viscosity must take into
    account."""

    @property
    def stands(self) -> bool:
        """True if the shape does not move."""

    def fills(self, place: np.ndarray) -> np.ndarray:
        """Return a mask of the positions [m], shape (n, 3), that the shape contains, shape (n,)."""

    def constrain(self, rows: ViscousRows) -> None:
        """Change the masses and velocities of the nodes in the equations of implicit viscosity, for the step at hand."""


class PressedContents(Protocol):
    """Interface of a gas or liquid in membranes whose pressure is solved for together with an implicit pressure of the liquids
    around it."""

    def linearise(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Return -dp/dV, the decrease of the pressure per increase of the volume [Pa/m³], at least 0; the sorted indices of the
        nodes that change the volume, shape (n,); and the derivative of the volume with respect to their positions [m²],
        shape (n, 3), for the present step."""

    def add_force(self, node: np.ndarray, force: np.ndarray) -> None:
        """Add the forces of a change of the pressure [N], shape (n, 3), on the nodes with the indices `node` to those of the
        pressure."""


class VelocityField:
    """Grid nodes shared by some bodies, which therefore move together: nodal arrays and the actions on them. The nodes move the
    points of the bodies.

    The nodes of a velocity field move independently of other fields; `pellucid.contact.pairs` then adds contact between
    fields. See `pellucid.grid.own_nodes_field` for a body with its own nodes.
    """

    moves_points = True
    """True if the nodes move the points of the field."""
    momentum: NodalMomentum
    """Object that updates the momentum of the nodes and computes their works; available when all actions are known."""

    def __init__(self, name: str, grid: Grid) -> None:
        self.name, self.grid = name, grid
        self.walls: Sequence[ShapedWall] = ()
        """Walls that act on the nodes near the surface of a shape."""
        self.contents: list[PressedContents] = []
        """Contents of membranes whose pressure is solved for with implicit pressure."""
        self._own = allocate(FieldNodes, 0)
        self._clear_nodes = Clearing(STEP, grid.rows, grid.nodes)
        self.pressed = False
        """True if contact applied impulses to nodes of this field in this step."""
        self.second = SecondIncrements(grid)
        """Velocity increments by contact after the momentum of the points was mapped a second time in the step (MUSL)."""

    @property
    def reached(self) -> np.ndarray | None:
        """Sorted indices of the nodes that may have mass, shape (m,); None if any node may have mass."""
        return None

    def separate_forces(self) -> np.ndarray:
        """Allocate and return nodal rows for the internal forces of bodies whose points store internal energy, if other bodies
        of the field store none; see `FieldNodes`."""
        self._own = with_memory(self._own, self.grid.n_nodes, "separate_forces")
        self._clear_nodes = Clearing(STEP, self.grid.rows, self.grid.nodes, self._own)
        return self._own.separate_forces

    def set_actions(
        self,
        supports: Supports,
        external: ExternalAction,
        gravity: tuple[float, float, float],
        small_mass: float,
        flip: float,
    ) -> None:
        """Set the actions on the nodes and their constraints; arguments: see `NodalMomentum`."""
        self._act(external)
        self._walls = supports.walls
        forces = self._own.separate_forces
        self.momentum = NodalMomentum(self.grid.nodes, self.grid.rows, supports, gravity, small_mass, flip, external, forces)

    def _act(self, external: ExternalAction) -> None:
        self.external, self._clear_external = external, Clearing(STEP, self.grid.rows, external)

    @property
    def gravity(self) -> np.ndarray:
        """Gravity that acts on the nodes [m/s²], shape (3,)."""
        return self.momentum.gravity

    @property
    def gravity_share(self) -> float:
        """Fraction of gravity that acts on the nodes."""
        return self.momentum.gravity_share

    def share_gravity(self, share: float) -> None:
        """Set gravity on the nodes to a fraction, 0 to 1, of its full value."""
        self.momentum.share_gravity(share)

    def clear(self) -> None:
        """Reset mass, momentum and forces of the nodes before P2G."""
        self._clear_nodes()

    def clear_external(self) -> None:
        """Reset external loads, driven masses and drag momentum to zero before the conditions of a step."""
        self._clear_external()

    def add_drag(self, momentum: np.ndarray) -> None:
        """Record the momentum that a drag (a force against the velocity) has removed from points, mapped to the nodes [kg m/s],
        shape (nodes, 3), for `drag_work`. Called before a step."""
        if not len(self.external.drag_momentum):
            self._act(with_memory(self.external, self.grid.n_nodes, "drag_momentum"))
        self.external.drag_momentum[:] += momentum

    def drag_work(self, dt: float) -> float:
        """Return the work [J] of internal forces along the decrease in nodal velocity that a drag caused at the start of a
        step, over half the step dt [s]; see `NodalMomentum.half_work`."""
        taken = self.external.drag_momentum
        return self.momentum.half_work(slice(None), self.momentum.find_lost_velocity(taken), dt) if len(taken) else 0.0

    def drag_work_of_load(self, row: int, dt: float) -> float:
        """Return the work [J] of the external forces in a row of `load_row` along the decrease in nodal velocity that a drag
        caused at the start of a step, over half the step dt [s]."""
        taken = self.external.drag_momentum
        if not len(taken):
            return 0.0
        at = np.flatnonzero(self.load_row(row).any(axis=1))
        powers = self.load_row(row)[at] * self.momentum.find_lost_velocity(taken, at)
        return 0.5 * dt * float(np.sum(domain.of_nodes(powers, at)))

    @property
    def may_be_let_go(self) -> bool:
        """True if a wall that opens (releases bodies that move away) may release nodes of this velocity field during the
        momentum update."""
        return bool(self._walls.opens.any())

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays for a checkpoint, by name: states of nodes at walls that have friction or open (release bodies
        that move away), on which the next step may depend."""
        if not len(self._walls.held):
            return {}
        nodes, walls = self.grid.nodes, self._walls
        kept = {"constrained": nodes.constrained, "has_mass": nodes.has_mass, "held": walls.held, "stuck": walls.stuck}
        return {name: domain.of_nodes(array) for name, array in kept.items()}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays of `state_arrays` from a checkpoint."""
        for name, array in self.state_arrays().items():
            array[:] = arrays[name]

    def await_impulses(self, nodes: Iterable[np.ndarray]) -> None:
        """Set the nodes that may receive contact impulses in this step; nodes: arrays of their indices."""
        self.momentum.await_impulses(nodes)

    def advance(self, dt: float, counted: bool = False) -> None:
        """Advance the momentum of the nodes by a step dt [s], before contact and impulses of conditions; counted: True if
        conditions apply no impulses, so that works can be computed at once."""
        self._given: list[tuple[np.ndarray, int, float, np.ndarray | None]] = []
        self._moved: list[np.ndarray] = []
        self.pressed = False
        self.momentum.advance(dt, counted)

    def add_impulses(self, impulse: np.ndarray, column: int, sign: float = 1.0, node: np.ndarray | None = None) -> np.ndarray:
        """Apply impulses [N s], shape (n, 3), to the nodes after the momentum update and before contact. Return the impulses
        that were applied.

        node: sorted indices of the nodes; default: all nodes. column, sign: entry of the energy balance to which the work of
        the impulses is added, and its sign. See `pellucid.grid.nodal_conditions`. Raises ValueError if the works of the step
        are already counted.
        """
        if self.momentum.is_counted:
            raise ValueError("impulses were added after the work of the step was computed; add them in `act_on_nodes`")
        given = add_impulses(self.grid.nodes, self.external, impulse, node)
        self._given.append((given, column, sign, node))
        return given

    def strain_as_moved(self, node: np.ndarray) -> None:
        """At the nodes with the indices `node`, set the velocity that strains points (`strain_velocity`) to the velocity
        that moved points in this step."""
        self._moved.append(node)

    def works(self, dt: float) -> StepWork | None:
        """Return the works of the forces in the step dt [s], and the impulses on the nodes, after the last impulse, without
        contact; None if the body computes these works itself. Resets the nodal momentum to zero, so that momentum can be
        mapped to the nodes again."""
        done = self.momentum.works(dt)
        works = np.zeros(max([len(done.works), *(column + 1 for _, column, _, _ in self._given)]))
        works[: len(done.works)] = done.works
        for impulse, column, sign, node in self._given:
            velocity = self.momentum.impulse_velocity(slice(None) if node is None else node)
            works[column] += sign * float(np.sum(domain.of_nodes(impulse * velocity, node)))
            done.impulse[:] += domain.of_nodes(impulse, node).sum(axis=0)
        return done._replace(works=works)

    def begin_second(self) -> None:
        """Reset the second velocity increments and the impulses of prescribed motions to zero, before contact acts a second
        time in the step."""
        self.external.impulse.fill(0.0)
        self.second.clear()

    def project(self, dt: float | None = None, counted: bool = False) -> None:
        """Compute the velocities that strain points from the nodal momentum mapped last; arguments as in
        `NodalMomentum.project`."""
        if dt is not None:
            nodes = self.grid.nodes
            for node in self._moved:
                nodes.momentum[node] = nodes.mass[node, None] * nodes.velocity[node]
        self.momentum.project(dt, counted)

    def load_row(self, row: int) -> np.ndarray:
        """Return the external forces of one channel (an entry of the energy balance for a load, with the number `row`) on
        the nodes [N], shape (nodes, 3). Raises ValueError if no condition requested arrays for external forces."""
        load = np.asarray(self.external.loads[row])
        if not len(load):
            raise ValueError(f"no condition has requested external forces in the velocity field {self.name}")
        return load


def add_impulses(nodes: Nodes, external: ExternalAction, impulse: np.ndarray, node: np.ndarray | None = None) -> np.ndarray:
    """Change the velocities of all nodes, or of the nodes with the indices `node`, by impulses [N s], shape (n, 3), after the
    momentum update. Return the impulses that were applied, same shape: no impulse is applied where `free_axes` is False.

    nodes, external: nodal arrays and actions, see `ConditionedNodes`.
    """
    listed = np.arange(len(nodes.mass)) if node is None else node
    given = np.where(free_axes(nodes, external, slice(None) if node is None else node), impulse, 0.0)
    _add_impulses(listed, given, nodes.mass, nodes.velocity, nodes.velocity_increment, nodes.strain_velocity)
    return given


@kernel()
def _add_impulses(listed, given, mass, velocity, velocity_increment, strain_velocity):
    for e in range(len(listed)):
        I = listed[e]
        for d in range(3):
            if given[e, d] == 0.0:
                continue
            change = given[e, d] / mass[I]
            if strain_velocity[I, d] == velocity[I, d]:  # else a light node, which must not strain points
                strain_velocity[I, d] += change
            velocity[I, d] += change
            velocity_increment[I, d] += change
