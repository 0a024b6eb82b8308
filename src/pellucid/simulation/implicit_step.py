"""An implicit time step of a body with its own nodes, as a search for the positions in the middle of the step.

Velocities v and positions x change over a step Δt by the forces f in the step, with a drag of the rate c:

    M (v₁ - v₀)/Δt = f - c M (v₀ + v₁)/2,  (x₁ - x₀)/Δt = (v₀ + v₁)/2 .

The work of the internal forces in the step is exactly the decrease of the stored energy, and they have no torque about the
positions in the middle x_m = (x₀ + x₁)/2 (see `MovingSystem.attempt_step`; Simo & Tarnow 1992, J. Appl. Math. Phys. 43, 757).
Energy, momentum and angular momentum are therefore conserved, also by large rotations in a step, in which the plain midpoint
rule gains energy without limit. The order is 2, and nothing is dissipated. The forces balance at x_m if

    f - (4/Δt²) M (x_m - x₀ - Δt v₀/2) - (2c/Δt) M (x_m - x₀) = 0 .

The search uses the factors of K + (4/Δt² + 2c/Δt) M with the stiffness K at the start of this or an earlier step. They are
turned with the body, and serve as long as few iterations are necessary. The derivatives of the forces are not symmetric: the
strain changes with F₁, while the stress pulls with (F₀ + F₁)/2. If the body rotates, the search therefore runs in positions
that are turned by half of its rotation in the step, in which the stiff part of the derivatives is nearly symmetric.
"""

from collections.abc import Callable

import numpy as np

from pellucid.parts.elastic_system import MovingSystem, Trial

TURNED = 1e-9  # part of a prescribed component that a turn may mix with free ones, as rounding


class ImplicitStep:
    """Implicit steps of a body, one after the other, each as forces for a `Search`.

    system: energy, forces, stiffness and inertia of the body.
    """

    has_potential = is_approximate = False
    rounding = 0.0

    def __init__(self, system: MovingSystem) -> None:
        self.system = system
        self.rest = system.position
        self._velocity, self._half = system.velocity.copy(), 0.0
        self._of_inertia, self._of_drag = 0.0, 0.0  # factors of the masses in the forces [1/s²]
        self._free, self._mass = system.free, system.inertia[:, None]
        self._predicted, self._middle = self.rest, self.rest  # positions in the middle of the step [m]
        self._factored_free, self._is_first = self._free, True
        self._turn: np.ndarray | None = None  # rotation of the body since it was factored
        self._ahead: np.ndarray | None = None  # rotation from the middle of the step to its end
        self.factored_at, self.weight = np.zeros((0, 3)), 0.0
        """Positions of the nodes [m], shape (n, 3), at which the stiffness was factored, and the factor of the masses in the
        factored matrix [1/s²]."""
        self.factorisations = 0
        """Number of factorisations so far."""

    def begin(self, dt: float) -> None:
        """Store the present state as the start of a step dt [s]. Called when the prescribed velocities are set."""
        self.system.begin(dt)
        self._velocity[:] = self.system.velocity
        self._half, self._is_first = 0.5 * dt, True
        self._of_inertia, self._of_drag = 4.0 / dt**2, 2.0 * self.system.drag / dt

    def take_loads(self, renew: Callable[[float], None], follow: bool) -> None:
        """Take the present external forces as those in the step, and predict its middle; renew, follow: as for
        `ElasticSystem`."""
        self.system.take_loads(renew, follow)
        self._free, self._mass = self.system.free, self.system.inertia[:, None]
        ahead = self._half * self._velocity
        if self._free.all():
            ahead = ahead + self._bend_of_rotation()
        self._predicted = self.rest + np.where(self._free, ahead, 0.5 * self.system.increment)
        self._ahead = self._turn_between(self.rest, self._predicted)

    @property
    def fits(self) -> bool:
        """True if the factors have the inertia, drag and free components of this step."""
        return self.weight == self._of_inertia + self._of_drag and bool((self._factored_free == self._free).all())

    def starts(self) -> tuple[np.ndarray, np.ndarray]:
        """Return positions in the middle of the step [m], shape (n, 3), from which the search may start: predicted ones, and
        for motion so fast that these invert the body those of free nodes that do not move."""
        self._turn = self._turn_between(self.factored_at, self._predicted) if len(self.factored_at) else None
        return self._predicted, np.where(self._free, self.rest, self._predicted)

    def attempt(self, position: np.ndarray) -> Trial:
        self._middle = middle = self._turned_ahead(position)
        here, moved = self.system.attempt_step(middle), middle - self.rest
        given = np.where(self._free, self._of_inertia * self._half * self._mass * self._velocity, 0.0)
        push = np.where(self._free, (self._of_inertia + self._of_drag) * self._mass * moved, 0.0) - given
        size = here.size + float(np.sqrt(np.sum(push * push)) + np.sqrt(np.sum(given * given)))
        return here._replace(residual=here.residual - push, size=size)

    def factor(self) -> None:
        """Factor the stiffness at the start of the step; later in the step at the end that the last trial would have."""
        self.factor_at(self.rest.copy() if self._is_first else 2.0 * self._middle - self.rest)
        self._is_first = False
        self._turn = self._turn_between(self.factored_at, self._middle)
        self.factorisations += 1

    def factor_at(self, position: np.ndarray) -> None:
        """Factor the stiffness at positions of the nodes [m], shape (n, 3)."""
        self.factored_at, self.weight, self._factored_free = position, self._of_inertia + self._of_drag, self._free
        self.system.added = self.weight * self.system.inertia
        self.system.factor_at(position)

    def solve(self, force: np.ndarray) -> np.ndarray:
        if self._turn is None:
            return self.system.solve(force)
        return turned(self._turn, self.system.solve(turned(self._turn.T, force)))

    def arrive(self, position: np.ndarray) -> None:
        """Move the body to the end of the step; position: result of the search."""
        self.system.arrive(self._turned_ahead(position), 2.0 * self._half)

    def _turned_ahead(self, position: np.ndarray) -> np.ndarray:
        """Return the positions in the middle of the step for the positions of the search [m], shape (n, 3) both."""
        if self._ahead is None:
            return position
        return self._predicted + turned(self._ahead, position - self._predicted)

    def _turn_between(self, one: np.ndarray, other: np.ndarray) -> np.ndarray | None:
        """Return the rotation of the body between positions [m], shape (n, 3), as a matrix; None if it would mix prescribed
        components of nodes with free ones."""
        turn = rotation(self._mass, one, other)
        free, mixes = self._free, abs(turn) > TURNED
        return None if (free[:, :, None] & ~free[:, None, :] & mixes).any() else turn

    def _bend_of_rotation(self) -> np.ndarray:
        """Return the difference of the displacements to the middle of the step between a rotation and straight motion [m],
        shape (n, 3), for the angular velocity ω at the start: (I - ω× Δt/2)⁻¹ r - (I + ω× Δt/2) r."""
        mass = self._mass
        arm, moving = self.rest - _mean(mass, self.rest), self._velocity - _mean(mass, self._velocity)
        second = np.einsum("ni,nj->ij", mass * arm, arm)
        inertia = np.trace(second) * np.eye(3) - second
        angular = np.linalg.lstsq(inertia, np.sum(mass * np.cross(arm, moving), axis=0), rcond=TURNED)[0]
        spin = self._half * np.cross(angular, np.eye(3)).T
        return turned(np.linalg.inv(np.eye(3) - spin) - np.eye(3) - spin, arm)


def turned(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return the products of a matrix, shape (3, 3), with vectors, shape (n, 3)."""
    return vectors[:, :1] * matrix[:, 0] + vectors[:, 1:2] * matrix[:, 1] + vectors[:, 2:] * matrix[:, 2]


def rotation(mass: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the rotation matrix that takes positions `one` closest to positions `other` [m], shape (n, 3) both, apart from a
    translation: Kabsch 1976, Acta Crystallogr. A 32, 922. mass: weights of the nodes, shape (n, 1)."""
    both = np.einsum("ni,nj->ij", mass * (other - _mean(mass, other)), one - _mean(mass, one))
    left, _, right = np.linalg.svd(both)
    left[:, 2] *= np.sign(np.linalg.det(left) * np.linalg.det(right))
    return np.asarray(left @ right)


def _mean(mass: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.asarray(np.sum(mass * vectors, axis=0) / np.sum(mass))
