"""Centre, angular momentum and inertia of points with masses, shape (n, 1) [kg], and rotations."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


def centre_of(mass: np.ndarray, position: np.ndarray) -> np.ndarray:
    """The centre of masses, shape (n, 1) [kg], at places [m]."""
    return np.asarray(np.sum(mass * position, axis=0) / np.sum(mass))


def spin_of(mass: np.ndarray, arm: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Angular momentum [N m s], (3,), of masses at places from the centre [m] with velocities [m/s]."""
    return np.asarray(np.sum(mass * np.cross(arm, velocity), axis=0))


def rates_of(mass: np.ndarray, arm: np.ndarray, velocity: np.ndarray, turns: Sequence[int]) -> np.ndarray:
    """Velocity of the centre [m/s] and angular velocity about the axes about which they turn [rad/s], together (6,)."""
    mean = centre_of(mass, velocity)
    rates = np.concatenate([mean, np.zeros(3)])
    rates[3 + np.array(turns, int)] = spun(inertia_of(mass, arm), spin_of(mass, arm, velocity - mean), turns)
    return rates


def spun(inertia: np.ndarray, spin: np.ndarray, turns: Sequence[int]) -> np.ndarray:
    """Angular velocity [rad/s] of an angular momentum [N m s] about some of the axes, whose others have none."""
    return np.asarray(_inverse_about(inertia, turns) @ spin[list(turns)])


def resultant(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Force [N] and torque about the centre [N m], together (6,), of forces at places from it [m], shape (n, 3) each."""
    return np.concatenate([force.sum(axis=0), np.cross(arm, force).sum(axis=0)])


def inertia_of(mass: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Inertia [kg m²], (3, 3), of masses at places from the centre [m]."""
    return np.asarray(np.sum(mass * arm * arm) * np.eye(3) - np.einsum("pi,pj->ij", mass * arm, arm))


def rotation_by(angle: np.ndarray) -> np.ndarray:
    """Rotation by a vector of angles [rad] (Rodrigues), shape (3, 3)."""
    size = float(np.linalg.norm(angle))
    if size == 0.0:
        return np.eye(3)
    x, y, z = angle / size
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(size) * cross + (1.0 - np.cos(size)) * cross @ cross


def inverse_inertia(mass: np.ndarray, arm: np.ndarray, turns: Sequence[int]) -> np.ndarray:
    """Angular velocities that angular impulses give about some of the axes, (3, 3) [1/(kg m²)]; none about the others."""
    inverse = np.zeros((3, 3))
    inverse[np.ix_(turns, turns)] = _inverse_about(inertia_of(mass, arm), turns)
    return inverse


def _inverse_about(inertia: np.ndarray, turns: Sequence[int]) -> np.ndarray:
    # points on a line have no inertia about it: the pseudo-inverse leaves that turn out
    return np.linalg.pinv(inertia[np.ix_(turns, turns)], rcond=1e-10, hermitian=True)


class RigidState(NamedTuple):
    """A rigid body as a step begins."""

    centre: np.ndarray
    """Of mass [m], (3,)."""
    spin: np.ndarray
    """Angular velocity [rad/s], (3,)."""
    per_mass: np.ndarray
    """What impulses change of its velocity along the axes [1/kg], (3,): nothing where a motion prescribes it."""
    per_inertia: np.ndarray
    """What angular impulses change of its angular velocity [1/(kg m²)], (3, 3): the same."""

    def turning(self, place: np.ndarray) -> np.ndarray:
        """Velocities [m/s] that the rotation of the body alone gives places [m], shape (m, 3) each."""
        return np.cross(self.spin, place - self.centre)

    def mobility_along(self, place: np.ndarray, force: np.ndarray) -> float:
        """Σ f·a for the accelerations a at places [m] that forces f there give it, shape (m, 3) each [N²/kg]."""
        strength = resultant(place - self.centre, force)
        return float(np.sum(self.per_mass * strength[:3] ** 2) + strength[3:] @ self.per_inertia @ strength[3:])


class Push(NamedTuple):
    """A force at the centre of mass [N] and a torque [N m], together of shape (6,), over a step."""

    strength: np.ndarray
    column: int  # of its work
    carried: np.ndarray | None = None  # of a damper: velocity and angular velocity of what it is fixed to, shape (6,)
    heat: int = 0  # of a damper: column of what it takes

    def book(self, works: np.ndarray, dt: float, rates: np.ndarray) -> float:
        """Add the work of force and torque over a step dt [s], on a body with a velocity and an angular velocity, shape (6,),
        to a row of works; returns the work."""
        work = dt * float(self.strength @ rates)
        if self.carried is None:
            works[self.column] += work
        else:
            given = dt * float(self.strength @ self.carried)
            works[self.column] += given
            works[self.heat] += given - work
        return work
