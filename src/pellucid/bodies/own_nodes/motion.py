"""The motion of a body's own nodes: external forces, supports and prescribed motions, works, and the faces of the grid."""

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from pellucid.bodies.own_nodes import kernels
from pellucid.bodies.own_nodes.kernels import CHUNK, CONTACT_IMPULSE, EXTRA_ROWS, FASTEST, NODE_SUMS, OTHER_IMPULSE, NodeForces
from pellucid.energy import FIRST_LOAD, MOTION, SUPPORT, StepWork, Totals, row_length, step_work
from pellucid.grid.lattice import Grid
from pellucid.grid.points import KINETIC, MOMENTUM_X, SPEED
from pellucid.jit.bundle import Bundle
from pellucid.parts.body import NodalSupport
from pellucid.reductions import ordered_sum


class FieldCondition(Protocol):
    """Conditions on the field that the nodes span, where it does not take the nodes' values."""

    def correct(self, velocity: np.ndarray, rows: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Changes of the nodes' free velocities [m/s], shape (n, 3), and the impulses that the supports and motions give them
        by these [N s], shape (rows, 3); rows: their velocities over the step dt [s], of the same shape."""


class NodalMotion:
    """Advances nodes with what acts on them; the body finds its internal forces, and contact the velocity increments.

    arrays: of the body, `position`, `velocity`, `mass`, and `prescribed`, which is filled here. grid: None where there is none;
    thin: axes along which nothing moves. gravity [m/s²]; n_loads: channels of external forces; increment: by contact [m/s],
    shape (n, 3).
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
        self._arrays, self._grid, self._thin, self.gravity = arrays, grid, thin, gravity
        self._increment, self._columns = increment, FIRST_LOAD + n_loads
        self.internal, self.loads = np.zeros((n, 3)), np.zeros((n_loads, n, 3))
        self.chunks = (n + CHUNK - 1) // CHUNK
        self._sums, self._fault = np.zeros((self.chunks, NODE_SUMS)), np.zeros((self.chunks, 2), np.int64)
        self._supports: Sequence[NodalSupport] = ()
        self._motions: list[str] = []
        self._motion_of_node, self._axes = np.zeros(n, np.int64), np.zeros((0, 3), np.int64)
        self._condition: FieldCondition | None = None
        self._lead = np.zeros((0, 3))
        self.top_speed = 0.0
        """The largest speed that a condition prescribes [m/s]."""
        self.crossing = 0.0
        """How fast the nodes cross the cells of the grid [1/s]; none passes one in a step."""
        self._constrain()

    # supports and prescribed motions

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """A support constrains the nodes that it selects at the start; none passes a face of the grid that is a wall."""
        self._supports = supports
        self._constrain()

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Let nodes follow prescribed motions; see `Body.add_motions`."""
        self._motions, self._motion_of_node, self._axes = list(names), numbers, axes
        self._constrain()

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """The velocities of the prescribed motions over this step [m/s], shape (motions, 3)."""
        first = len(self._supports)
        self._rows[first : first + len(velocity)] = velocity

    def impose_on_field(self, condition: FieldCondition) -> None:
        """Let the nodes go free, and lead them so that the field between them does what is prescribed."""
        self._condition, self._lead = condition, np.zeros_like(self._arrays["velocity"])
        self._bind(np.zeros_like(self._arrays["prescribed"]))

    @property
    def prescribed_velocities(self) -> np.ndarray:
        """Of the supports, the motions and the thin axes over this step [m/s], shape (rows, 3)."""
        return self._rows

    def groups(self) -> np.ndarray:
        """The numbers in `prescribed`, shape (n, 3), with one number for all supports of one velocity along an axis."""
        prescribed, n_rows = self._arrays["prescribed"], len(self._rows)
        first = np.zeros((n_rows + 1, 3), np.int64)
        motions = range(len(self._supports), n_rows - 1)
        for axis in range(3):
            seen: dict[float, int] = {}
            for row, velocity in enumerate(self._rows[:, axis].tolist()):
                first[row + 1, axis] = row + 1 if row in motions else seen.setdefault(velocity, row + 1)
        return np.asarray(np.take_along_axis(first, prescribed, axis=0))

    def _constrain(self) -> None:
        """Number the constraints of the nodes: supports, prescribed motions, and last the thin axes."""
        position, prescribed = self._arrays["position"], self._arrays["prescribed"]
        n_supports, n_rows = len(self._supports), len(self._supports) + len(self._motions) + 1
        prescribed.fill(0)
        self._walls = np.zeros((3, 2), np.int64)
        for row, support in enumerate(self._supports, start=1):
            prescribed[np.ix_(support.selects(position), np.flatnonzero(support.axes))] = row
            if support.wall is not None:
                self._walls[support.wall] = row
        for number, axes in enumerate(self._axes, start=1):
            prescribed[np.ix_(self._motion_of_node == number, np.flatnonzero(axes))] = n_supports + number
        prescribed[(prescribed == 0) & np.array(self._thin)] = n_rows
        self._rows = np.zeros((n_rows, 3))
        self._rows[:n_supports] = [support.velocity for support in self._supports] or np.zeros((0, 3))
        self._work = np.zeros((self.chunks, row_length(self._columns, n_rows + EXTRA_ROWS)))
        self._bind(prescribed)

    def _bind(self, prescribed: np.ndarray) -> None:
        """What acts on the nodes, as kernels take it; prescribed: the numbers of the nodes that follow a row themselves."""
        a = self._arrays
        faces = np.tile((-np.inf, np.inf), (3, 1))
        if self._grid:
            lattice = self._grid.lattice
            ends = zip(lattice.lower, lattice.counts, strict=True)
            faces = np.array([(low, low + n / lattice.inverse_cell) for low, n in ends])
        acting = (self.internal, self.loads, self.gravity, self._increment, self._lead)
        constraints = prescribed, self._rows, faces, self._walls
        self._forces = Bundle(NodeForces(a["position"], a["velocity"], a["mass"], *acting, *constraints, self._work))

    # the step

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces on the nodes [N], shape (n, 3), over this step."""
        self.loads[column - FIRST_LOAD] += force

    def forces(self) -> np.ndarray:
        """All forces on the nodes but those of contact and constraints [N], shape (n, 3)."""
        force = self.internal + self.loads.sum(axis=0) if len(self.loads) else self.internal
        if any(self.gravity):
            force = force + self._arrays["mass"][:, None] * np.array(self.gravity)
        return np.asarray(force)

    def advance_velocities(self, dt: float) -> None:
        """New velocities from all forces and the increments by contact."""
        if self._condition is None:
            kernels.advance_velocities(self.chunks, self._forces, dt)
        else:
            self._lead_velocities(self._condition, dt)

    def _lead_velocities(self, condition: FieldCondition, dt: float) -> None:
        """The free velocities first, then once more with what they lack: works are along the mean of old and new ones."""
        velocity, rows = self._arrays["velocity"], len(self._rows)
        old = velocity.copy()
        self._lead.fill(0.0)
        kernels.advance_velocities(self.chunks, self._forces, dt)
        self._lead[:], impulses = condition.correct(velocity, self._rows, dt)
        velocity[:] = old
        kernels.advance_velocities(self.chunks, self._forces, dt)
        self._work[0, self._columns + 1 :][: 3 * rows] += impulses.ravel()

    def subtract_velocities(self, loss: np.ndarray, dt: float) -> None:
        """Subtract velocities [m/s], shape (n, 3), that contact took from motion within a cell."""
        kernels.subtract_velocities(self.chunks, self._forces, loss, dt)

    def advance_positions(self, dt: float) -> None:
        """New positions."""
        kernels.advance_positions(self.chunks, self._arrays["position"], self._arrays["velocity"], dt, self._fault)

    def sum_momentum(self, totals: Totals) -> None:
        """Kinetic energy and momentum."""
        kernels.sum_momentum(self.chunks, self._arrays["velocity"], self._arrays["mass"], self._sums)
        sums = ordered_sum(self._sums)
        totals.kinetic, totals.momentum_size = float(sums[KINETIC]), float(sums[SPEED])
        totals.momentum = sums[MOMENTUM_X : MOMENTUM_X + 3].copy()
        if self._grid:
            fastest = max(float(self._sums[:, FASTEST].max()), self.top_speed)
            self.crossing = fastest * self._grid.lattice.inverse_cell

    def fault(self) -> tuple[int, int] | None:
        """The fault of the first node whose position is no number, and the node."""
        found = np.flatnonzero(self._fault[:, 0])
        return (int(self._fault[found[0], 0]), int(self._fault[found[0], 1])) if len(found) else None

    # works and impulses

    def work(self) -> StepWork:
        """Work and impulses of this step; reactions to prescribed motions count as work of the motions, not of the supports."""
        sums = ordered_sum(self._work)
        impulses = sums[self._columns + 1 :].reshape(-1, 3)
        n_supports, rows = len(self._supports), len(self._rows)
        motions = slice(n_supports, rows - 1)
        motion_work = float(np.sum(impulses[motions] * self._rows[motions]))
        reactions = np.concatenate([impulses[:n_supports], impulses[rows - 1 : rows], impulses[rows + OTHER_IMPULSE :][:1]])
        whole = step_work(np.concatenate([sums[: self._columns + 1], reactions.ravel()]), self._columns)
        whole.works[SUPPORT] -= motion_work
        whole.works[MOTION] += motion_work
        return whole._replace(motions=dict(zip(self._motions, impulses[motions], strict=True)))

    @property
    def contact_impulse(self) -> np.ndarray:
        """Of contact over this step on the nodes [N s], shape (3,)."""
        impulses = ordered_sum(self._work)[self._columns + 1 :].reshape(-1, 3)
        return np.asarray(impulses[len(self._rows) + CONTACT_IMPULSE])
