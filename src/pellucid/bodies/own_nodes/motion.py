"""Equation of motion of the nodes of a body: advances them under forces, supports, prescribed motions, contact and walls of
the grid, and records the works.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from pellucid.bodies.own_nodes import kernels
from pellucid.bodies.own_nodes.kernels import CHUNK, FASTEST, NODE_SUMS, UNDAMPED, Drag, NodeForces, power
from pellucid.energy import DAMPING, FIRST_LOAD, GRAVITY, INTERNAL, MOTION, SUPPORT, StepWork, Totals, row_length, step_work
from pellucid.grid.lattice import Grid
from pellucid.grid.points import KINETIC, MOMENTUM_X, SPEED
from pellucid.jit.bundle import Bundle
from pellucid.parts.capabilities import NodalSupport
from pellucid.parts.support_precedence import find_owners, in_order
from pellucid.reductions import ordered_sum

BEYOND = 1e-9  # distance behind a wall, relative to the size of a body, that is rounding


class FieldCondition(Protocol):
    """Conditions that prescribe the interpolated displacement of a body at its nodes, if this displacement differs from the
    nodal coefficients.
    """

    def impulses(self, velocity: np.ndarray, inertia: np.ndarray, rows: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the impulses that enforce the prescribed velocities [N s]: on the nodes, shape (2, n, 3), for supports and
        for motions; and the sum for each support and motion, shape (rows, 3).

        velocity: velocities of the nodes at the end of the step dt [s] without these conditions [m/s], shape (n, 3); inertia:
        nodal inertia [kg], shape (n,); rows: prescribed velocities of each support and motion [m/s], shape (rows, 3).
        """


class ForceParts(NamedTuple):
    """Forces on the nodes of a body in parts."""

    internal: np.ndarray  # (n, 3) internal forces [N]
    loads: np.ndarray  # (channels, n, 3) external forces [N]
    gravity: np.ndarray  # (3,) applied gravity [m/s²]


class ForcesOnTheWay(NamedTuple):
    """Forces on the nodes of a body in a step of the loads, at its start, middle and end."""

    before: ForceParts
    middle: ForceParts
    after: ForceParts


class Tangent(NamedTuple):
    """The way on which an equilibrium changes in a step of the loads, linearised at the equilibrium."""

    moved: np.ndarray  # (n, 3) displacements of the nodes in the step [m]
    resisted: np.ndarray  # (n, 3) forces with which the body resists them [N]


class Moved(NamedTuple):
    """A step from one equilibrium to the next."""

    displacement: np.ndarray  # (n, 3) displacements of the nodes [m]
    leaving: Tangent  # at the first equilibrium
    arriving: Tangent  # at the second equilibrium
    rates: np.ndarray  # (rows, 3) prescribed velocities in the time of the loads [m/s]


class NodalMotion:
    """Advances the nodes of a body by their equation of motion.

    The body computes internal forces; contact provides velocity increments. arrays: arrays of the body, `position`,
    `velocity`, `mass`, and `prescribed` (numbers of the constraints of each node), which this class fills; grid: None
    without a grid; thin: axes without motion; gravity: [m/s²]; n_loads: number of channels (entries of the energy balance)
    of external forces; increment: velocity increments from contact [m/s], shape (n, 3).
    """

    def __init__(
        self,
        arrays: Mapping[str, np.ndarray],
        grid: Grid | None,
        thin: tuple[bool, bool, bool],
        gravity: tuple[float, float, float],
        n_loads: int,
        increment: np.ndarray,
    ) -> None:
        n = len(arrays["mass"])
        self._arrays, self._grid, self._thin, self._full_gravity = arrays, grid, thin, np.array(gravity, float)
        self.gravity = self._full_gravity.copy()
        """Gravity that is applied in this step [m/s²], shape (3,)."""
        self.gravity_share = 1.0
        self._increment, self._columns = increment, FIRST_LOAD + n_loads
        self.internal, self.loads = np.zeros((n, 3)), np.zeros((n_loads, n, 3))
        self.chunks = (n + CHUNK - 1) // CHUNK
        self._sums, self._fault = np.zeros((self.chunks, NODE_SUMS)), np.zeros((self.chunks, 2), np.int64)
        self.supports: Sequence[NodalSupport] = ()
        self._gone: Collection[int] = ()  # numbers of the released supports
        self.motions: list[str] = []
        self._motion_of_node, self._axes = np.zeros(n, np.int64), np.zeros((0, 3), np.int64)
        self._condition: FieldCondition | None = None
        self._lead = np.zeros((0, 0, 0))
        self.inertia: np.ndarray = arrays["mass"]
        """Inertia of the nodes [kg], shape (n,): their masses, unless a relaxation scales them (`scale_inertia`)."""
        self.drag = UNDAMPED
        self.load_rate = 1.0
        """Ratio of load time to simulated time in this step; prescribed velocities are multiplied by it."""
        self.top_speed = 0.0
        """Largest speed that a condition prescribes for a node [m/s]."""
        self.crossing = 0.0
        """Largest rate at which nodes cross cells of the grid [1/s]; no node may cross more than a cell in a step."""
        self._constrain()

    # supports and prescribed motions

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """Set the supports of the nodes; nodes cannot pass faces of the grid that are walls."""
        self.supports = supports
        self._constrain()

    def let_go(self, supports: Collection[int]) -> None:
        """Release the nodes from the supports with these numbers (indices in the sequence of supports of the body)."""
        self._gone, prescribed = frozenset(supports), self._prescribed
        self._constrain()
        self._prescribed[:] = prescribed

    def on_walls(self) -> list[np.ndarray]:
        """Return the masks of nodes that supports constrain to walls of the grid at rest, one per support, each of shape
        (n,).
        """
        walls = [(support, support.wall[0]) for support in self.supports if support.wall is not None]
        return [support.nodes for support, axis in walls if support.axes[axis] and support.velocity[axis] == 0.0]

    def on_symmetry_planes(self) -> np.ndarray:
        """Return a mask of the nodes that lie on a face of the grid on which a support constrains only the normal direction,
        shape (n, 3): one column for each axis normal to such faces."""
        found = np.zeros(self._arrays["position"].shape, bool)
        for row, support in enumerate(self.supports):
            if row not in self._gone and support.wall is not None and sum(support.axes) == 1:
                found[support.nodes, support.wall[0]] = True
        return found

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Set the prescribed motions of nodes.

        names: names of the motions; numbers: 1 + the number of the motion that each node follows, 0 for none, shape (n,); axes:
        1 if a motion prescribes the velocity along the axis, shape (motions, 3).
        """
        self.motions, self._motion_of_node, self._axes = list(names), numbers, axes
        self._constrain()

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """Set the velocities of the prescribed motions in this step [m/s], shape (motions, 3)."""
        first = len(self.supports)
        self._prescribed[first : first + len(velocity)] = velocity

    def impose_on_field(self, condition: FieldCondition | None) -> None:
        """Prescribe the interpolated displacement field by a condition instead of prescribing nodal values; None for no such
        condition.
        """
        self._condition, self._lead = condition, np.zeros((2 if condition else 0, *self.internal.shape))
        self._constrain()

    @property
    def motion_rows(self) -> tuple[int, int]:
        """Index in `rows` of the first prescribed motion, and the index after the last."""
        return len(self.supports), len(self.supports) + len(self.motions)

    @property
    def free(self) -> np.ndarray:
        """Mask of the velocity components that are not prescribed at the node itself, shape (n, 3)."""
        prescribed = self._arrays["prescribed"]
        return np.asarray(prescribed == 0) if self._condition is None else np.ones(prescribed.shape, bool)

    def groups(self) -> np.ndarray:
        """Return the number of the constraint of each node and axis, shape (n, 3), as in the array `prescribed`, but with one
        common number for all supports that have the same velocity along an axis.
        """
        first = np.zeros((len(self.rows) + 1, 3), np.int64)
        motions = range(*self.motion_rows)
        for axis in range(3):
            seen: dict[float, int] = {}
            for row, velocity in enumerate(self._prescribed[:, axis].tolist()):
                first[row + 1, axis] = row + 1 if row in motions else seen.setdefault(velocity, row + 1)
        return np.asarray(np.take_along_axis(first, self._arrays["prescribed"], axis=0))

    def _constrain(self) -> None:
        """Assign to each node and axis the number of a constraint (a support, a prescribed motion, or an axis without motion),
        and build the data for kernels.
        """
        a = self._arrays
        position, prescribed = a["position"], a["prescribed"]
        n_supports, n_rows = len(self.supports), len(self.supports) + len(self.motions) + 1
        walls, friction = np.zeros((3, 2), np.int64), np.zeros((3, 2))
        prescribed[:] = find_owners(self.supports, len(prescribed), self._gone, may_leave=True)
        for end in {support.wall for support in self.supports if support.wall is not None}:
            there = [row for row, support in enumerate(self.supports) if support.wall == end and row not in self._gone]
            for row in in_order(self.supports, there, end[0]):
                walls[end], friction[end] = row + 1, self.supports[row].friction
        for number, axes in enumerate(self._axes, start=1):
            prescribed[np.ix_(self._motion_of_node == number, np.flatnonzero(axes))] = n_supports + number
        prescribed[(prescribed == 0) & np.array(self._thin)] = n_rows
        self._prescribed, self.rows = np.zeros((n_rows, 3)), np.zeros((n_rows, 3))
        """Prescribed velocities in this step [m/s], shape (rows, 3): one row for each support and each motion, and one for the
        axes without motion."""
        self._prescribed[:n_supports] = [support.velocity for support in self.supports] or np.zeros((0, 3))
        self._work = np.zeros((self.chunks, row_length(self._columns, n_rows + 1)))
        faces = np.tile((-np.inf, np.inf), (3, 1))
        if self._grid:
            lattice = self._grid.lattice
            ends = zip(lattice.lower, lattice.counts, strict=True)
            faces = np.array([(low, low + n / lattice.inverse_cell) for low, n in ends])
        forces = NodeForces(
            position=position,
            velocity=a["velocity"],
            mass=a["mass"],
            inertia=self.inertia,
            internal=self.internal,
            loads=self.loads,
            gravity=self.gravity,
            increment=self._increment,
            lead=self._lead,
            prescribed=np.where(self.free, 0, prescribed),
            rows=self.rows,
            motions=self.motion_rows,
            faces=faces,
            walls=walls,
            friction=friction if friction.any() else friction[:0],
            work=self._work,
        )
        self._forces = Bundle(forces)

    # the step

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces that act on the nodes in this step [N], shape (n, 3). column: index of their work in
        `StepWork.works`.
        """
        self.loads[column - FIRST_LOAD] += force

    def share_gravity(self, share: float) -> None:
        """Set the fraction of gravity that is applied: 0 to 1."""
        self.gravity_share, self.gravity[:] = share, share * self._full_gravity

    def scale_external(self, factor: float) -> None:
        """Multiply loads and gravity of this step by a factor."""
        self.loads *= factor
        self.share_gravity(factor * self.gravity_share)

    def scale_inertia(self, inertia: np.ndarray) -> None:
        """Set an inertia [kg], shape (n,), that replaces the nodal masses in the response to forces."""
        self.inertia = inertia
        self._constrain()

    def slow(self, rate: float, dt: float) -> None:
        """Set the drag of the coming step dt [s]: a force proportional to mass and velocity, with the rate [1/s]."""
        half = 0.5 * rate * dt
        self.drag = Drag((1.0 - half) / (1.0 + half), 1.0 / (1.0 + half))

    def forces(self) -> np.ndarray:
        """Return the forces on the nodes, without contact and constraints [N], shape (n, 3)."""
        force = self.internal + self.loads.sum(axis=0) if len(self.loads) else self.internal
        if self.gravity.any():
            force = force + self._arrays["mass"][:, None] * self.gravity
        return np.asarray(force)

    def free_velocities(self, dt: float) -> np.ndarray:
        """Return the nodal velocities at the end of a step dt [s] without contact [m/s], shape (n, 3). Constrained components
        keep their present values.
        """
        velocity = self._arrays["velocity"]
        keep, gain = self.drag
        return np.where(self.free, keep * velocity + dt * gain * self.forces() / self.inertia[:, None], velocity)

    def answers(self, dt: float) -> np.ndarray:
        """Return the velocity change of each node over a step dt [s] per unit force on the node [m/(s N)], shape (n, 3)."""
        return np.where(self.free, dt * self.drag.gain / self.inertia[:, None], 0.0)

    def drag_forces(self, dt: float) -> np.ndarray:
        """Return the drag forces on the nodes, as means over a step dt [s] [N], shape (n, 3)."""
        keep, gain = self.drag
        momentum = self.inertia[:, None] * self._arrays["velocity"]
        return np.asarray((keep - 1.0) / dt * momentum + (gain - 1.0) * self.forces())

    def advance_velocities(self, dt: float) -> None:
        """Update the nodal velocities over a step dt [s] with all forces, constraints and the increments from contact."""
        np.multiply(self._prescribed, self.load_rate, out=self.rows)
        of_rows = self._find_lead(self._condition, dt) if self._condition is not None else np.zeros(0)
        kernels.advance_velocities(self.chunks, self._forces, self.drag, dt)
        self._work[0, self._columns + 1 :][: of_rows.size] += of_rows.ravel()

    def _find_lead(self, condition: FieldCondition, dt: float) -> np.ndarray:
        """Compute, by a trial step, the velocity changes of the nodes that enforce the condition on the interpolated field, so
        that works can be computed with the mean of old and new velocities. Returns the impulses of supports and motions [N s],
        shape (rows, 3). dt: time step [s].
        """
        velocity = self._arrays["velocity"]
        old = velocity.copy()
        self._lead.fill(0.0)
        kernels.advance_velocities(self.chunks, self._forces, self.drag, dt)
        impulses, of_rows = condition.impulses(velocity, self.inertia, self.rows, dt)
        self._lead[:] = impulses / (self.drag.gain * self.inertia[:, None])
        velocity[:] = old
        return of_rows / self.drag.gain

    def leading_forces(self, dt: float) -> np.ndarray:
        """Return the forces [N], shape (n, 3), that supports and motions exerted on the interpolated field in a completed step
        dt [s]."""
        return (
            np.asarray(self.inertia[:, None] * self._lead.sum(axis=0) / dt) if len(self._lead) else np.zeros_like(self.internal)
        )

    def add_velocities(self, change: np.ndarray, dt: float) -> None:
        """Add velocity increments from second impulses of contact, `change` [m/s], shape (n, 3), to velocities that were
        already advanced over a step dt [s].
        """
        kernels.add_velocities(self.chunks, self._forces, change, dt)

    def advance_positions(self, dt: float) -> None:
        """Update the nodal positions with the velocities over a step dt [s]."""
        kernels.advance_positions(self.chunks, self._arrays["position"], self._arrays["velocity"], dt, self._fault)

    # equilibria without motion between them

    def beyond_wall(self, position: np.ndarray) -> tuple[int, int] | None:
        """Return a node that would be beyond a face of the grid that no node can pass, and the axis of the face, for nodes at
        these positions [m], shape (n, 3); None if there is none."""
        walls = self._forces.walls > 0
        for axis, end in np.argwhere(walls):
            face, size = self._forces.faces[axis, end], float(np.ptp(position[:, axis]))
            past = (position[:, axis] - face) * (1.0 if end else -1.0)
            past[self._arrays["prescribed"][:, axis] > 0] = 0.0
            if past.max() > BEYOND * size:
                return int(past.argmax()), int(axis)
        return None

    def prescribed_rates(self) -> np.ndarray:
        """Return a copy of the prescribed velocities of supports and motions [m/s], shape (rows, 3)."""
        return self._prescribed.copy()

    def at_nodes(self, rates: np.ndarray) -> np.ndarray:
        """Return the prescribed velocities of the nodes [m/s], shape (n, 3), 0 for free components; rates: as returned by
        `prescribed_rates`."""
        rows = np.concatenate([np.zeros((1, 3)), rates])
        return np.asarray(np.take_along_axis(rows, self._arrays["prescribed"], axis=0))

    def force_parts(self) -> ForceParts:
        """Return copies of the present internal forces, loads and gravity."""
        return ForceParts(self.internal.copy(), self.loads.copy(), self.gravity.copy())

    def external_forces(self, parts: ForceParts) -> np.ndarray:
        """Return the sum of loads and gravity on the nodes [N], shape (n, 3)."""
        return np.asarray(parts.loads.sum(axis=0) + self._arrays["mass"][:, None] * parts.gravity)

    def record_equilibrium(self, moved: Moved, forces: ForcesOnTheWay, dt: float) -> None:
        """Compute works and impulses of a step dt [s] of the time of the loads from one equilibrium to the next, after which
        the nodes are at rest. forces: forces in the step; those at its end are the present ones.

        Reactions are those of the second equilibrium. Displacements u and reactions r are cubic in the share s of the step,
        with the values and derivatives at both ends, loads f quadratic: f_½ is the mean of the loads of both ends at the middle
        of the way. Prescribed displacements grow in proportion. A load does the work (f₀ + f₁)·(u₁ - u₀)/2 +
        (f₁ - f₀)·(u₁' - u₀')/12 + (4 f_½ - 2 f₀ - 2 f₁)·((u₁ - u₀)/5 - (u₀' + u₁')/60), and reactions to displacements that
        grow by w the work w·((r₀ + r₁)/2 + (r₀' - r₁')/12). The error is of fourth order in the step.
        """
        self._prescribed[:] = moved.rates
        np.multiply(self._prescribed, self.load_rate, out=self.rows)
        velocity, present = self._arrays["velocity"], (self.internal, self.loads, self.gravity)
        for now, end, start in zip(present, forces.after, forces.before, strict=True):
            now[...] = 0.5 * (start + end)
        # also where supports released nodes, which they held at the first equilibrium
        self.internal[...] = np.where(self.free, self.internal - self.forces(), self.internal)
        velocity[:] = moved.displacement / dt
        kernels.advance_velocities(self.chunks, self._forces, UNDAMPED, dt)
        works = self._work[:, : self._columns].copy()
        for now, end in zip(present, forces.after, strict=True):
            now[...] = end
        velocity[:] = moved.displacement / dt
        kernels.advance_velocities(self.chunks, self._forces, UNDAMPED, dt)
        self._work[:, : self._columns] = works
        velocity.fill(0.0)
        self._add_curvature(moved, forces, dt)

    # implicit time steps

    @property
    def velocity(self) -> np.ndarray:
        """Velocities of the nodes [m/s], shape (n, 3)."""
        return self._arrays["velocity"]

    def drag_rate(self, dt: float) -> float:
        """Return the rate [1/s] of the drag in a step dt [s], see `slow`."""
        return 2.0 * (1.0 - self.drag.keep) / ((1.0 + self.drag.keep) * dt)

    def record_step(self, displacement: np.ndarray, rates: np.ndarray, drag: float, dt: float) -> None:
        """Compute velocities, works and impulses of a step dt [s] by the midpoint rule, in which the nodes move by a
        displacement [m], shape (n, 3). The present forces are those in the middle of the step.

        The mean of the velocities before and after is the displacement over dt. Prescribed components have the prescribed
        velocity during the step; the impulse that changes it at the start of the step does work at the mean of both
        velocities. Forces on free components that are not balanced, by the tolerance of the step, count as internal forces.

        rates: prescribed velocities [m/s], shape (rows, 3); drag: rate of the drag [1/s].
        """
        self.slow(drag, dt)
        self._prescribed[:] = rates
        self.rows[:] = rates
        velocity, free, keep, gain = self.velocity, self.free, self.drag.keep, self.drag.gain
        given = np.where(free, velocity, self.at_nodes(rates))
        jump = given - velocity
        at_jump = self.inertia[:, None] * jump * (velocity + 0.5 * jump)
        after = 2.0 * displacement / dt - given
        needed = self.inertia[:, None] * (after - keep * given) / (gain * dt)
        self.internal[...] = np.where(free, self.internal + needed - self.forces(), self.internal)
        velocity[:] = given
        kernels.advance_velocities(self.chunks, self._forces, self.drag, dt)
        self._add_jump(jump, at_jump)

    def _add_jump(self, jump: np.ndarray, work: np.ndarray) -> None:
        """Add impulses and works [J], shape (n, 3), of changes of the prescribed velocities [m/s], shape (n, 3)."""
        prescribed, works = self._arrays["prescribed"], self._work[0]
        impulse = self.inertia[:, None] * jump
        for row in np.flatnonzero(np.bincount(prescribed[jump != 0.0], minlength=1)):
            there = prescribed == row
            cause = MOTION if self.motion_rows[0] < row <= self.motion_rows[1] else SUPPORT
            works[cause] += float(np.sum(work[there]))
            first = self._columns + 1 + 3 * (row - 1)
            works[first : first + 3] += np.where(there, impulse, 0.0).sum(axis=0)

    def work_of_load(self, row: int) -> float:
        """Return the work in the last step of the loads with an index [J]."""
        return float(self._work[:, FIRST_LOAD + row].sum())

    def lose_rest(self, stored: float) -> None:
        """Add to the heat of damping the part of the works of the last step that did not increase the stored energy by
        `stored` [J]."""
        works = self._work[0]
        internal = float(self._work[:, INTERNAL].sum())
        works[DAMPING] -= internal + stored
        works[INTERNAL] -= internal + stored

    def _add_curvature(self, moved: Moved, forces: ForcesOnTheWay, dt: float) -> None:
        """Add to the works of a step the parts beyond those of the mean forces, see `record_equilibrium`."""
        before, middle, after = forces
        first, last = moved.leaving.moved, moved.arriving.moved
        works, bend, reach = self._work[0], (last - first) / 12.0, moved.displacement / 5.0 - (first + last) / 60.0
        bow_of_gravity = 4.0 * middle.gravity - 2.0 * (before.gravity + after.gravity)
        along = bend @ (after.gravity - before.gravity) + reach @ bow_of_gravity
        of_gravity = float(np.sum(self._arrays["mass"] * along))
        bow = 4.0 * middle.loads - 2.0 * (before.loads + after.loads)
        of_loads = np.sum((after.loads - before.loads) * bend + bow * reach, axis=(1, 2))
        pulled = (moved.leaving.resisted - moved.arriving.resisted) / 12.0  # loads cancel
        by_row = np.where(self.free, 0.0, pulled * dt * self.at_nodes(moved.rates))
        start, end = self.motion_rows
        prescribed = self._arrays["prescribed"]
        led = (prescribed > start) & (prescribed <= end)
        of_motions, of_supports = float(np.sum(by_row[led])), float(np.sum(by_row[~led]))
        works[GRAVITY] += of_gravity
        works[FIRST_LOAD : self._columns] += of_loads
        works[MOTION] += of_motions
        works[SUPPORT] += of_supports
        works[INTERNAL] -= of_gravity + float(of_loads.sum()) + of_motions + of_supports

    def sum_momentum(self, totals: Totals) -> None:
        """Write the kinetic energy and the momentum of the nodes to `totals`."""
        kernels.sum_momentum(self.chunks, self._arrays["velocity"], self.inertia, self._sums)
        sums = ordered_sum(self._sums)
        totals.kinetic, totals.momentum_size = float(sums[KINETIC]), float(sums[SPEED])
        totals.momentum = sums[MOMENTUM_X : MOMENTUM_X + 3].copy()
        if self._grid:
            fastest = max(float(self._sums[:, FASTEST].max()), self.top_speed)
            self.crossing = fastest * self._grid.lattice.inverse_cell

    def sum_at_rest(self, totals: Totals, dt: float) -> None:
        """Write the kinetic energy and the momentum of nodes at rest to `totals`: 0, but errors of momentum compare with the
        impulses of the loads in a step dt [s] of the time of the loads, which may cancel."""
        totals.kinetic, totals.momentum = 0.0, np.zeros(3)
        forces = self.forces() - self.internal
        totals.momentum_size = dt * float(np.sqrt(np.sum(forces * forces, axis=1)).sum())

    def power(self) -> float:
        """Return the power of the present internal forces at the present nodal velocities [W]."""
        return power(self.internal, self._arrays["velocity"])

    def fault(self) -> tuple[int, int] | None:
        """Return the fault code and the number of the first node whose position is not finite; None if there is none."""
        found = np.flatnonzero(self._fault[:, 0])
        return (int(self._fault[found[0], 0]), int(self._fault[found[0], 1])) if len(found) else None

    # works and impulses

    def work(self) -> StepWork:
        """Return the work and impulses of this step. Reactions to prescribed motions count as work of the motions, not of
        the supports."""
        sums = ordered_sum(self._work)
        impulses = sums[self._columns + 1 :].reshape(-1, 3)
        n_supports, rows = len(self.supports), len(self.rows)
        motions = slice(n_supports, rows - 1)
        reactions = np.concatenate([impulses[:n_supports], impulses[rows - 1 :]])  # thin axes, others
        whole = step_work(np.concatenate([sums[: self._columns + 1], reactions.ravel()]), self._columns)
        named = dict(zip(self.motions, impulses[motions], strict=True))
        return whole._replace(gravity_mass=self.gravity_share * whole.gravity_mass, motions=named)
