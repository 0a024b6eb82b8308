"""Rigid motions as vectors of six components, prescribed ones among them, and walls that stop rigid bodies."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import nnls

from pellucid.conditions.signals.displacements import Displacement
from pellucid.grid.actions import NodalActions

if TYPE_CHECKING:
    from pellucid.conditions.prescribed_motion import Motion


class Leads:
    """Prescribed motions of one rigid body, by component: 0 to 2 are displacements along the axes, 3 to 5 rotations about
    the axes.

    motions: data models; along, about: axes along and about which the body can move. Attribute `led`: mask of the
    prescribed components, shape (6,).
    """

    def __init__(self, motions: "Sequence[Motion]", along: Sequence[int], about: Sequence[int]) -> None:
        self._names = [motion.name for motion in motions]
        self._functions: dict[int, Displacement] = {}
        self._owners = np.zeros((len(motions), 6), bool)
        for owner, motion in enumerate(motions):
            moves = {axis: function for axis, function in motion.functions().items() if axis in along}
            turns = {3 + axis: function for axis, function in motion.turn_functions().items() if axis in about}
            self._functions |= moves | turns
            self._owners[owner, [*moves, *turns]] = True
        self.led = np.asarray(self._owners.any(axis=0))
        self.is_whole = bool(self.led[[*along, *(3 + axis for axis in about)]].all())
        """True if all components of the motion are prescribed."""
        self.top_speed = max((motion.top_speed() for motion in motions), default=0.0)
        self.top_turn = max((motion.top_turn() for motion in motions), default=0.0)
        self.rates, self.reached = np.zeros(6), np.zeros(6)
        """Velocities over the step [m/s, rad/s], and displacements and angles at its end [m, rad]; 0 for free components."""
        self.sought = np.zeros(6, bool)
        """Mask of the components that a search for equilibria finds; they do not change in a step."""
        self._may = np.zeros(6, bool)
        self._may[[*along, *(3 + axis for axis in about)]] = True

    def seek(self) -> None:
        """Prescribe also the free components, by a search for equilibria: `keep_sought` sets them."""
        self.sought = self._may & ~self.led
        self.led |= self._may
        self.is_whole = True

    def keep_sought(self, moved: np.ndarray) -> None:
        """Take the displacements and angles that the search found, among those of all components, shape (6,) [m, rad]."""
        self.reached[self.sought] = moved[self.sought]

    def begin(self, time: float, dt: float) -> None:
        """Set the mean velocities over a step dt [s] from `time` [s], so that the body ends at the prescribed displacements
        and angles; 0 if dt = 0."""
        for number, function in self._functions.items():
            reached = function(time + dt)
            self.reached[number] = reached
            self.rates[number] = (reached - function(time)) / dt if dt > 0.0 else 0.0

    def shares(self, impulse: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Divide the impulses of all components, shape (6,) [N s, N m s], among the motions that prescribe these components;
        return the impulses and the angular impulses of each motion by name, shape (3,) each."""
        given = np.where(self._owners, impulse, 0.0)
        along = dict(zip(self._names, given[:, :3], strict=True))
        return along, dict(zip(self._names, given[:, 3:], strict=True))


SMALL = 1e-9  # fraction of the mass below which inertia is negligible, e.g. about the line of all points
MOST_ROWS = 16  # points of a body that walls hold at once; three would do on each


class RigidMotions:
    """Rigid motions V + ω × s at positions s relative to the centre of a body. The six components of a motion are V and the
    angular velocity ω times a length of the body [m/s].

    thin: mask of the axes along which the body cannot move; turns: axes about which the body can rotate; leads:
    prescribed motions of the body.
    """

    def __init__(self, thin: Sequence[bool], turns: Sequence[int], leads: Leads, arm: np.ndarray) -> None:
        """thin: mask of the axes along which the body cannot move; turns: axes about which the body can rotate; leads:
        prescribed motions of the body; arm: positions of the points relative to the centre [m], shape (n, 3)."""
        self._may_move = ~np.array([*thin, *(axis not in turns for axis in range(3))])
        self._free = np.flatnonzero(~leads.led)
        self.length = float(np.sqrt(np.mean(np.sum(arm * arm, axis=1)))) or 1.0
        self.sizes = np.array([1.0, 1.0, 1.0, self.length, self.length, self.length])
        """Factors, shape (6,), by which velocities and angular velocities are multiplied to get the components of a
        motion; forces, torques and their impulses are divided by them to get components of the momentum."""
        self.given = leads.rates * self.sizes
        """The prescribed components of the motion; 0 for free components."""
        self._led = leads.led

    def of_body(self, mass: float, inertia: np.ndarray) -> np.ndarray:
        """Return the inertia matrix, shape (6, 6), for the six components of a motion, of a body with a mass [kg] and an
        inertia tensor [kg m²], shape (3, 3); 0 for components that cannot change."""
        matrix = np.zeros((6, 6))
        matrix[:3, :3] = mass * np.eye(3)
        matrix[3:, 3:] = inertia / self.length**2
        return np.asarray(np.where(np.outer(self._may_move, self._may_move), matrix, 0.0))

    def natural(self, inertia: np.ndarray, momentum: np.ndarray) -> np.ndarray:
        """Return the motion that a body with the given momentum would have if no component were prescribed, shape (6,), in
        the components of the class; inertia: inertia matrix in these components, shape (6, 6); momentum: shape (6,)."""
        return _solved(inertia, momentum, np.flatnonzero(self._may_move))

    def prescribed(self, inertia: np.ndarray, momentum: np.ndarray) -> np.ndarray:
        """Return the motion whose prescribed components have their given values and whose free components follow from the
        momentum, shape (6,), in the components of the class; inertia: inertia matrix in these components, shape (6, 6);
        momentum: shape (6,)."""
        return self.given + _solved(inertia, momentum - inertia @ self.given, np.flatnonzero(self._may_move & ~self._led))

    def at(self, s: np.ndarray) -> np.ndarray:
        """Return the velocities that unit components of a motion cause at positions s relative to the centre [m], shape
        (n, 3, 6)."""
        turning = np.cross(np.eye(3)[None], s[:, None, :]) / self.length  # (n, about, along)
        along = np.broadcast_to(np.eye(3), (len(s), 3, 3))
        return np.concatenate([along, turning.transpose(0, 2, 1)], axis=2) * self._may_move

    def momentum_of(self, strength: np.ndarray) -> np.ndarray:
        """Return the rate of change of the six components of the momentum due to a force at the centre [N] and a torque [N
        m], given as `strength`, shape (6,)."""
        return np.asarray(strength / self.sizes * self._may_move)

    def roots(self, inertia: np.ndarray, mass: float) -> np.ndarray:
        """Return a matrix R, shape (6, k), with R Rᵀ = K⁻¹ for an inertia matrix K in motion components (see the class),
        shape (6, 6). Directions in which the inertia is negligible compared with `mass` [kg], which sets its scale, are
        omitted.

        R has only components that are not prescribed, since impulses do not change prescribed components.

        """
        sizes, axes = np.linalg.eigh(inertia[np.ix_(self._free, self._free)])
        real = sizes > SMALL * mass
        roots = np.zeros((6, np.count_nonzero(real)))
        roots[self._free] = axes[:, real] / np.sqrt(sizes[real])
        return roots


def _solved(inertia: np.ndarray, momentum: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    # points on a line have no inertia about it: the pseudo-inverse leaves that turn out
    numbers = np.zeros(6)
    numbers[chosen] = np.linalg.pinv(inertia[np.ix_(chosen, chosen)], rcond=1e-10, hermitian=True) @ momentum[chosen]
    return numbers


def inertia_at(weight: np.ndarray, motions: np.ndarray) -> np.ndarray:
    """Return the inertia matrix, shape (6, 6), of n masses for the six components of a rigid motion. weight: each mass for
    motion along x, y and z, shape (n, 3) [kg]; motions: velocities of the masses for unit components of the motion, shape
    (n, 3, 6)."""
    return np.einsum("kd,kdi,kdj->ij", weight, motions, motions)


class Wall(NamedTuple):
    """A face of the grid that a support constrains along its normal, so that it stops rigid bodies."""

    row: int  # index of the support
    axis: int  # normal axis of the face
    sign: float  # sign of the direction into the grid, 1 or -1
    place: float  # position of the face along the axis [m]
    velocity: float  # prescribed velocity along the axis [m/s]


class Kept(NamedTuple):
    """Result of `RigidWalls.keep_inside`: a motion of a rigid body with which no point passes a wall, and the impulses of
    the walls."""

    motion: np.ndarray  # (6,) the motion, in the components of `RigidMotions` [m/s]
    given: np.ndarray  # (6,) total impulse of the walls on the body, in the same components [N s]
    impulses: list[tuple[Wall, float]]  # each wall that pushes the body, and its impulse along its axis [N s]


class RigidWalls:
    """Constrained faces of a grid that act as walls on one rigid body: no point of the body passes a wall in a step, and
    walls only push."""

    def __init__(self, actions: NodalActions) -> None:
        self._actions, self._faces = actions, _faces(actions)
        self._rows, self._limits, self._of_row = np.zeros((0, 6)), np.zeros(0), list[Wall]()

    def find(self, position: np.ndarray, width: np.ndarray, motions: np.ndarray, dt: float) -> None:
        """Compute the limits that walls impose on the motion over a step dt [s], and store them for `keep_inside`.
        position: positions of the points [m], shape (n, 3); width: half the extent of the points [m]; motions: velocities
        of the points for unit components of a rigid motion, shape (n, 3, 6)."""
        rows, limits, self._of_row = [np.zeros((0, 6))], [np.zeros(0)], []
        cell = self._actions.field.grid.lattice.cell
        for wall in self._walls():
            gap = np.maximum(wall.sign * (position[:, wall.axis] - wall.place) - width, 0.0)
            near = np.flatnonzero(gap < cell)
            rows.append(wall.sign * motions[near, wall.axis])
            limits.append(wall.sign * wall.velocity - gap[near] / dt)
            self._of_row += [wall] * len(near)
        self._rows, self._limits = np.concatenate(rows), np.concatenate(limits)

    def keep_inside(self, motion: np.ndarray, roots: np.ndarray) -> "Kept":
        """Return the motion nearest to `motion`, shape (6,), with which no point passes a wall, except by its prescribed
        components, and the impulses of the walls.

        roots: matrix R with R Rᵀ = K⁻¹ that `RigidMotions.roots` returns; the inertia matrix K defines the distance of
        motions. Least distance programming by non-negative least squares (Lawson & Hanson 1974, Solving Least Squares
        Problems, chapter 23); constraints are added one by one until none is violated.
        """
        rows, limits, kept, pushes = self._rows, self._limits, motion, np.zeros(0)
        chosen: list[int] = []
        tolerance = 1e-9 * (np.abs(limits).max(initial=0.0) + np.abs(rows @ motion).max(initial=0.0))
        reach = rows @ roots
        movable = np.abs(reach).max(axis=1, initial=0.0) > SMALL * np.abs(roots).max(initial=0.0)
        while movable.any() and len(chosen) < MOST_ROWS:
            lacking = np.where(movable, limits - rows @ kept, -np.inf)
            worst = int(lacking.argmax())
            if lacking[worst] <= tolerance or worst in chosen:
                break
            G, h = reach[[*chosen, worst]], limits[[*chosen, worst]] - rows[[*chosen, worst]] @ motion
            size = float(np.abs(h).max() / np.abs(G).max())  # equal sizes, since otherwise 1 - h u is only rounding
            u, _ = nnls(np.vstack([G.T, h / size]), np.append(np.zeros(G.shape[1]), 1.0))
            if (left := 1.0 - h @ u / size) <= SMALL:
                return Kept(motion, np.zeros(6), [])  # no free motion satisfies all: the prescribed part passes walls
            chosen.append(worst)
            pushes = size * u / left
            kept = motion + roots @ (G.T @ pushes)
        walls = [self._of_row[number] for number in chosen]
        impulses = [(wall, wall.sign * float(push)) for wall, push in zip(walls, pushes, strict=True)]
        return Kept(kept, rows[chosen].T @ pushes, impulses)

    def _walls(self) -> list[Wall]:
        found, supports, constrained = [], self._actions.supports, self._actions.field.grid.nodes.constrained
        for node, axis, sign, place in self._faces:
            row = int(constrained[node, axis]) - 1
            if row >= 0:
                found.append(Wall(row, axis, sign, place, float(supports.velocity[row, axis])))
        return found


def _faces(actions: NodalActions) -> list[tuple[int, int, float, float]]:
    """Return for each face of the grid of a velocity field the number of the node in its middle, its normal axis, the
    direction into the grid (1 or -1) and its position [m]; actions: actions on the nodes of the field."""
    grid, found = actions.field.grid, []
    index, position = grid.where()
    for axis in (axis for axis in range(3) if not grid.thin[axis]):
        for sign, place in ((1.0, position[:, axis].min()), (-1.0, position[:, axis].max())):
            on_face = np.flatnonzero(position[:, axis] == place)
            middle = on_face[np.square(position[on_face] - position[on_face].mean(axis=0)).sum(axis=1).argmin()]
            found.append((int(index[middle]), axis, sign, float(place)))
    return found
