"""Centre, angular momentum and inertia of points with masses, shape (n, 1) [kg], and rotations."""

from collections.abc import Callable, Sequence
from math import ceil
from typing import NamedTuple

import numpy as np

LARGEST_TURN = 0.02  # rad by which a body turns in a part of a step, see `turn_freely`


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


def inertia_of(mass: np.ndarray, arm: np.ndarray, own: float = 0.0) -> np.ndarray:
    """Inertia [kg m²], (3, 3), of masses at places from the centre [m]; own: sum of their inertias about themselves [kg m²]."""
    return np.asarray((np.sum(mass * arm * arm) + own) * np.eye(3) - np.einsum("pi,pj->ij", mass * arm, arm))


def matrix_of(vector: np.ndarray) -> np.ndarray:
    """The matrix whose product with another vector is the cross product with it, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_by(angle: np.ndarray) -> np.ndarray:
    """Rotation by a vector of angles [rad] (Rodrigues), shape (3, 3)."""
    size = float(np.linalg.norm(angle))
    if size == 0.0:
        return np.eye(3)
    cross = matrix_of(angle / size)
    return np.eye(3) + np.sin(size) * cross + (1.0 - np.cos(size)) * cross @ cross


class Turned(NamedTuple):
    """Rotation of a body over a step."""

    rotation: np.ndarray  # (3, 3)
    angle: np.ndarray  # (3,) the angular velocity, integrated over the step [rad]
    velocity: np.ndarray  # (3,) the angular velocity at its end [rad/s]


def turn_freely(velocity_of: Callable[[np.ndarray], np.ndarray], dt: float) -> Turned:
    """Turn a body over a step dt [s]; velocity_of: its angular velocity [rad/s] when it has turned by a rotation, shape (3, 3).

    A free body keeps its angular momentum, from which its inertia as it is turned gives the angular velocity. The rotation
    follows by the method of Runge and Kutta of order four on the rotation group, in parts of the step in which the body turns
    by no more than LARGEST_TURN: its energy then changes by some 1e-10 of itself for each radian, and by rounding where the
    angular velocity is constant (Munthe-Kaas 1998, BIT 38, 92).
    """
    rotation, angle = np.eye(3), np.zeros(3)
    first = velocity_of(rotation)
    parts = max(ceil(float(np.linalg.norm(first)) * dt / LARGEST_TURN), 1)
    h = dt / parts
    for _ in range(parts):
        at, rates = [np.zeros(3)], [first]  # the way from where the part begins, and the angular velocity there
        slopes = [first]
        for share in (0.5, 0.5, 1.0):
            at.append(share * h * slopes[-1])
            rates.append(velocity_of(rotation_by(at[-1]) @ rotation))
            slopes.append(_pulled_back(at[-1], rates[-1]))
        rotation = rotation_by(h * _simpson(slopes)) @ rotation
        angle += h * _simpson(rates)
        first = velocity_of(rotation)
    return Turned(rotation, angle, first)


def _simpson(rates: Sequence[np.ndarray]) -> np.ndarray:
    first, second, third, fourth = rates
    return np.asarray((first + 2.0 * second + 2.0 * third + fourth) / 6.0)


def _pulled_back(angle: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return the rate of the rotation vector for an angular velocity, to third order in the vector [rad/s]."""
    across = np.cross(angle, velocity)
    return np.asarray(velocity - 0.5 * across + np.cross(angle, across) / 12.0)


def inverse_inertia(mass: np.ndarray, arm: np.ndarray, turns: Sequence[int], own: float = 0.0) -> np.ndarray:
    """Angular velocities that angular impulses give about some of the axes, (3, 3) [1/(kg m²)]; none about the others."""
    inverse = np.zeros((3, 3))
    inverse[np.ix_(turns, turns)] = _inverse_about(inertia_of(mass, arm, own), turns)
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
