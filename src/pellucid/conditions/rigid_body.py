"""Rigid bodies: points with the rigid motion of their momentum and angular momentum."""

import numpy as np

from pellucid.conditions import driven_points
from pellucid.energy import IMPACT, StepWork
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.assembly import AssembledBody, Assembly


class RigidBody(ActiveCondition):
    """A body that moves as a rigid one: its points get the rigid motion with their momentum and angular momentum."""

    strains = False
    top_speed = 0.0  # of what is prescribed [m/s]

    def __init__(self, member: AssembledBody, assembly: Assembly) -> None:
        self.body, self._thin, self._layout = member.body, member.thin, assembly.layout
        member.body.constrain(self)
        self._dt = self._loss = 0.0
        self._centre, self._velocity, self._spin = np.zeros(3), np.zeros(3), np.zeros(3)
        self._arm = np.zeros((0, 3))  # of the points, from the centre, before they move [m]

    def act_on_nodes(self, dt: float) -> None:
        """Keep the length of the step."""
        self._dt = dt

    def prescribe_velocities(self) -> None:
        """The rigid velocity field V + ω × (x - c) of the points' momentum."""
        points = self.body.arrays
        m, x, v = points["mass"][:, None], points["position"], points["velocity"]
        self._centre, self._velocity = np.sum(m * x, axis=0) / np.sum(m), np.sum(m * v, axis=0) / np.sum(m)
        self._arm = r = x - self._centre
        self._spin = np.sum(m * np.cross(r, v - self._velocity), axis=0)
        rigid = self._velocity + np.cross(self._turn(r), r)
        self._loss = float(0.5 * np.sum(m * (v * v - rigid * rigid)))
        v[...] = rigid

    def prescribe_positions(self) -> None:
        """Positions of the rigid motion. The velocities turn with the body, which keeps its angular momentum."""
        r = self._arm @ _rotation(self._dt * self._turn(self._arm)).T
        target = self._centre + self._dt * self._velocity + r
        points = self.body.on_grid
        if points is None:
            self.body.arrays["position"][...] = target
        else:
            driven_points.move_points_to(points.n_slabs, points.mapped, target)
        self.body.arrays["velocity"][...] = self._velocity + np.cross(self._turn(r), r)

    def _turn(self, r: np.ndarray) -> np.ndarray:
        """Angular velocity [rad/s] of the spin for points at r from the centre [m]."""
        m = self.body.arrays["mass"][:, None]
        inertia = np.sum(m * r * r) * np.eye(3) - np.einsum("pi,pj->ij", m * r, r)
        thin = self._thin  # across a thin axis nothing moves, so that only the turn about it is left
        turns = [axis for axis in range(3) if not any(thin[other] for other in range(3) if other != axis)]
        omega = np.zeros(3)  # points on a line have no inertia about it: the pseudo-inverse leaves that turn out
        omega[turns] = np.linalg.pinv(inertia[np.ix_(turns, turns)], rcond=1e-10, hermitian=True) @ self._spin[turns]
        return omega

    def work(self) -> StepWork:
        """The kinetic energy of the part of the velocities that is not rigid is lost."""
        done = self._layout.no_work()
        done.works[IMPACT] = self._loss
        return done


def _rotation(angle: np.ndarray) -> np.ndarray:
    """Rotation by a vector of angles [rad] (Rodrigues), shape (3, 3)."""
    size = float(np.linalg.norm(angle))
    if size == 0.0:
        return np.eye(3)
    x, y, z = angle / size
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(size) * cross + (1.0 - np.cos(size)) * cross @ cross
