"""Membranes of finite elements that move on their own nodes (Lian, Liu & Zhang 2014, section 4)."""

from typing import Any

import numpy as np

from pellucid.bodies.membrane_elements import nodes as element_nodes
from pellucid.bodies.membrane_elements.model import MembraneElementsCase
from pellucid.bodies.membrane_elements.nodes import CONTACTING, EXTRA_ROWS, LOADING, WORKS, NodeForces
from pellucid.bodies.membrane_elements.surface import ElementBody
from pellucid.conditions.driven_points import spread_momentum, sum_motion
from pellucid.contact.subcell_damping import damp_subcell_motion
from pellucid.grid import transfer
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.grid.momentum import StepWork, no_work
from pellucid.grid.points import RATE, Slabs
from pellucid.grid.sorting import MOST_SLABS
from pellucid.grid.velocity_transfer import Flip
from pellucid.jit.bundle import Bundle
from pellucid.reductions import ordered_sum

NO_WALLS = np.zeros((3, 2), np.int64)


class MembraneElements(ElementBody):
    """Elements that have a velocity field to themselves: their nodes move by their own forces, and the grid tells contact.

    A step: `begin`, `press` for each pressure, `particle_to_grid`, `update_velocities` when `grid.nodes.contact` is
    known, `update_stress`.

    gravity: acceleration [m/s²]; top_speed: of what is prescribed [m/s], for the bound on the step; prescribed_velocity, shape
    (rows, 3) [m/s]: read at every step; work: what the nodes did over the step, its `impulses` those of the prescribed rows;
    contact_work [J] and contact_impulse [N s], shape (3,): of contact over the step.
    """

    own_nodes = True

    def __init__(self, case: MembraneElementsCase, grid_case: GridCase, grid: Grid, velocity_transfer: Any) -> None:
        self.gravity, self.top_speed = (0.0, 0.0, 0.0), 0.0
        # along thin axes nothing moves
        self.prescribed_velocity = np.zeros((1, 3))
        self._walls = NO_WALLS
        self._work = np.zeros((MOST_SLABS, WORKS + 3 * (EXTRA_ROWS + 1)))
        self._dt = 0.0
        n = len(case.mesh().vertices)
        self._internal, self._external = np.zeros((n, 3)), np.zeros((n, 3))
        self._sums_within = np.zeros((2, grid.n_nodes))
        prescribed = np.tile(np.array(grid.thin, np.int64), (n, 1))
        # nodes of their own keep their velocity, which is what FLIP does
        super().__init__(case, grid_case, grid, Flip(), {"prescribed": prescribed})
        self._total_mass = float(self.points.mass.sum())
        self.work, self.contact_work, self.contact_impulse = self._no_work(), 0.0, np.zeros(3)

    def _share(self, slabs: Slabs) -> None:
        super()._share(slabs)
        self._bind_forces()

    def _bind_forces(self) -> None:
        prescribed = self.arrays["prescribed"], self.prescribed_velocity, self._walls
        self._acting = Bundle(NodeForces(self._internal, self._external, *prescribed, self._work))

    def set_prescribed(self, numbers: np.ndarray, rows: int, walls: np.ndarray = NO_WALLS) -> None:
        """Which directions of the nodes have a prescribed velocity, each 0 or one more than its row.

        numbers: shape (n, 3), of the nodes in the order of the mesh; rows: their number; walls: the same numbers for the lower
        and upper faces of the grid that no node passes, shape (3, 2). Thin axes that nobody holds are held by the last row. The
        velocities of the rows are zero until `prescribed_velocity` is filled.
        """
        self._walls = walls
        held = np.where((numbers == 0) & np.array(self.grid.thin), rows, numbers)
        self.arrays["prescribed"][:] = held[self.arrays["id"]]
        self.prescribed_velocity = np.zeros((rows, 3))
        self._work = np.zeros((MOST_SLABS, WORKS + 3 * (EXTRA_ROWS + rows)))
        self._bind_forces()
        self.work = self._no_work()

    # the verbs of a step

    def begin(self, dt: float) -> None:
        """Internal forces at the start of a step dt [s]; no external ones yet."""
        self._dt = dt
        self._internal.fill(0.0)
        self._external.fill(0.0)
        self._add_internal_forces(self._internal)

    def press(self, outside_load: np.ndarray, pressure: float) -> None:
        """Add the forces of a pressure [Pa] along the normals; `outside_load`, that of the grid's nodes, stays as it is."""
        self._add_pressure_forces(self._external, pressure)

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Mass and momentum, nodal forces."""
        if inertia:
            transfer.scatter(self.n_slabs, self.mapped, 1, 0)
        if force:
            element_nodes.spread(self.n_slabs, self.mapped, self._internal + self._external, self.grid.nodes.force)

    def update_velocities(self, remap: bool) -> None:
        """New velocities of the nodes; where `remap`, their momentum on the grid anew."""
        element_nodes.update_velocities(self.n_slabs, self.mapped, self._acting, self.gravity, self._dt)
        if self.constraint is not None:
            self.constraint.prescribe_velocities()
        if remap:
            spread_momentum(self.n_slabs, self.mapped)
            if self._pressed():
                nodes = self.grid.nodes
                about = nodes.contact, nodes.momentum, nodes.mass, self._sums_within
                damp_subcell_motion(self.n_slabs, self.mapped, self._acting, *about, self._dt)
        sum_motion(self.n_slabs, self.mapped)
        self._collect_motion_sums()
        self._collect_work()

    def update_positions(self, dt: float) -> None:
        """New positions, and what the elements make of them."""
        element_nodes.update_positions(self.n_slabs, self.mapped, dt)
        self._strain(self.points.velocity, dt)
        crossing = max(float(self.slabs.sums[:, RATE].max()), self.top_speed * self.grid.lattice.inverse_cell)
        self.sums["rate"] = max(self._element_rate, crossing)

    # the books

    def _pressed(self) -> bool:
        """Whether contact gave the nodes any impulse in this step."""
        first = WORKS + 3 * CONTACTING
        return bool(self._work[: self.n_slabs, first : first + 3].any())

    def _collect_work(self) -> None:
        sums = ordered_sum(self._work[: self.n_slabs])
        impulses = sums[WORKS:].reshape(-1, 3)
        self.contact_work, self.contact_impulse = float(sums[element_nodes.CONTACT]), impulses[CONTACTING]
        self.work = self._no_work()._replace(
            internal=float(sums[element_nodes.INTERNAL]),
            gravity=float(sums[element_nodes.GRAVITY]),
            support=float(sums[element_nodes.SUPPORT]),
            load=float(sums[element_nodes.LOAD]),
            impulses=impulses[EXTRA_ROWS:],
            load_impulse=impulses[LOADING],
        )

    def _no_work(self) -> StepWork:
        return no_work(len(self.prescribed_velocity))._replace(mass=self._total_mass)

    def own_work(self, n_supports: int) -> StepWork:
        """What the nodes did over the step without what the rows of motions did, which lie behind those of the supports."""
        impulses = self.work.impulses
        motions = slice(n_supports, len(impulses) - 1)
        moved = float(np.sum(impulses[motions] * self.prescribed_velocity[motions]))
        held = np.concatenate([impulses[:n_supports], impulses[-1:]])
        return self.work._replace(support=self.work.support - moved, impulses=held)

    @property
    def reactions(self) -> np.ndarray:
        """Impulses of the prescribed rows over the step on the nodes [N s], shape (rows, 3)."""
        return self.work.impulses
