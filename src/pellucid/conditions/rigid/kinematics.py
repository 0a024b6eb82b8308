"""Kinematics of rigid bodies: centre, angular momentum and inertia of points with given masses, and rotations."""

from collections.abc import Callable, Sequence
from math import ceil
from typing import NamedTuple

import numpy as np

from pellucid.jit import kernel

LARGEST_TURN = 0.02  # largest rotation in a substep [rad], see `turn_freely`


def centre_of(mass: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return the mean of positions [m], shape (n, 3), weighted by masses [kg], shape (n, 1): the centre of mass, shape (3,);
    also used for mean velocities."""
    return np.asarray(np.sum(mass * position, axis=0) / np.sum(mass))


def rotation_between(mass: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return the rotation matrix, (3, 3), that turns positions `before` relative to a centre into positions `after`, shape
    (n, 3) each [m], with the smallest mean square error weighted by masses [kg], shape (n, 1) (Kabsch 1976)."""
    rows = np.array([[np.sum(mass[:, 0] * a * b) for b in after.T] for a in before.T])
    left, _, right = np.linalg.svd(rows)
    signs = np.array([1.0, 1.0, np.linalg.det(left) * np.linalg.det(right)])
    return np.asarray((right.T * signs) @ left.T)


def spin_of(mass: np.ndarray, arm: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return the angular momentum [N m s], (3,), of masses [kg], shape (n, 1), at positions `arm` relative to the centre [m]
    with velocities [m/s], shape (n, 3) each."""
    return np.asarray(np.sum(mass * np.cross(arm, velocity), axis=0))


def rates_of(mass: np.ndarray, arm: np.ndarray, velocity: np.ndarray, turns: Sequence[int]) -> np.ndarray:
    """Return the velocity of the centre of mass [m/s] and the angular velocity about the axes in `turns` [rad/s], shape
    (6,), of the rigid motion with the momentum and angular momentum of masses [kg], shape (n, 1), at positions `arm`
    relative to the centre [m] with velocities [m/s], shape (n, 3) each."""
    mean = centre_of(mass, velocity)
    rates = np.concatenate([mean, np.zeros(3)])
    rates[3 + np.array(turns, int)] = spun(inertia_of(mass, arm), spin_of(mass, arm, velocity - mean), turns)
    return rates


def spun(inertia: np.ndarray, spin: np.ndarray, turns: Sequence[int]) -> np.ndarray:
    """Return the angular velocity [rad/s], shape (3,), about the axes in `turns` that belongs to an angular momentum `spin`
    [N m s], for an inertia tensor [kg m²], shape (3, 3); zero about other axes."""
    return np.asarray(_inverse_about(inertia, turns) @ spin[list(turns)])


def resultant(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the total force [N] and torque about the centre [N m], shape (6,), of forces [N] at positions `arm` relative to
    the centre [m], shape (n, 3) each."""
    strength = np.zeros(6)
    _add_resultant(arm, force, strength)
    return strength


@kernel()
def _add_resultant(arm: np.ndarray, force: np.ndarray, strength: np.ndarray) -> None:
    for i in range(len(arm)):
        x, y, z, f, g, h = arm[i, 0], arm[i, 1], arm[i, 2], force[i, 0], force[i, 1], force[i, 2]
        strength[0] += f
        strength[1] += g
        strength[2] += h
        strength[3] += y * h - z * g
        strength[4] += z * f - x * h
        strength[5] += x * g - y * f


def inertia_of(mass: np.ndarray, arm: np.ndarray, own: float = 0.0) -> np.ndarray:
    """Return the inertia tensor [kg m²], (3, 3), of masses [kg], shape (n, 1), at positions `arm` relative to the centre
    [m], shape (n, 3); own: sum of the inertias of the points about their own centres [kg m²]."""
    return np.asarray((np.sum(mass * arm * arm) + own) * np.eye(3) - np.einsum("pi,pj->ij", mass * arm, arm))


def matrix_of(vector: np.ndarray) -> np.ndarray:
    """Return the matrix W, shape (3, 3), with W x = v × x for a vector v, shape (3,)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_by(angle: np.ndarray) -> np.ndarray:
    """Return the rotation matrix, shape (3, 3), of a rotation vector `angle` [rad], shape (3,) (Rodrigues' formula)."""
    size = float(np.linalg.norm(angle))
    if size == 0.0:
        return np.eye(3)
    cross = matrix_of(angle / size)
    return np.eye(3) + np.sin(size) * cross + (1.0 - np.cos(size)) * cross @ cross


class Turned(NamedTuple):
    """Rotation of a body about its centre of mass over a step."""

    rotation: np.ndarray  # (3, 3) rotation matrix from the start to the end of the step
    angle: np.ndarray  # (3,) integral of the angular velocity over the step [rad]
    velocity: np.ndarray  # (3,) angular velocity at the end of the step [rad/s]


def turn_freely(velocity_of: Callable[[np.ndarray], np.ndarray], dt: float) -> Turned:
    """Return the rotation over a step dt [s] of a body that rotates freely; velocity_of: function that returns the angular
    velocity [rad/s], shape (3,), that the body has after it was rotated by a matrix, shape (3, 3).

    A free body conserves its angular momentum; its angular velocity follows from its rotated inertia. The rotation is
    integrated by the Runge-Kutta method of order four on the rotation group (Munthe-Kaas 1998, BIT 38, 92), in substeps in
    which the body rotates by at most LARGEST_TURN. The relative energy error is about 1e-10 per radian; for a constant
    angular velocity it is rounding only.
    """
    rotation, angle = np.eye(3), np.zeros(3)
    first = velocity_of(rotation)
    parts = max(ceil(float(np.linalg.norm(first)) * dt / LARGEST_TURN), 1)
    h = dt / parts
    for _ in range(parts):
        at, rates = [np.zeros(3)], [first]  # rotation vectors from the start of the substep, and angular velocities there
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
    """Return the rate of change [rad/s] of the rotation vector `angle` [rad] for an angular velocity [rad/s], to third order
    in the vector."""
    across = np.cross(angle, velocity)
    return np.asarray(velocity - 0.5 * across + np.cross(angle, across) / 12.0)


def inverse_inertia(inertia: np.ndarray, turns: Sequence[int]) -> np.ndarray:
    """Return the inverse inertia for rotations about the axes in `turns`, (3, 3) [1/(kg m²)], i.e. the angular velocity per
    angular impulse; zero for other axes. inertia: inertia tensor [kg m²], shape (3, 3)."""
    inverse = np.zeros((3, 3))
    inverse[np.ix_(turns, turns)] = _inverse_about(inertia, turns)
    return inverse


def _inverse_about(inertia: np.ndarray, turns: Sequence[int]) -> np.ndarray:
    # points on a line have no inertia about it: the pseudo-inverse leaves that turn out
    return np.linalg.pinv(inertia[np.ix_(turns, turns)], rcond=1e-10, hermitian=True)


class RigidState(NamedTuple):
    """State of a rigid body at the start of a step, from which contact computes velocities and mobilities of its surface."""

    centre: np.ndarray
    """Centre of mass [m], (3,)."""
    spin: np.ndarray
    """Angular velocity [rad/s], (3,)."""
    per_mass: np.ndarray
    """Velocity per impulse along each axis [1/kg], (3,); 0 if a motion prescribes it."""
    per_inertia: np.ndarray
    """Angular velocity per angular impulse [1/(kg m²)], (3, 3); 0 for prescribed rotations."""

    def turning(self, place: np.ndarray) -> np.ndarray:
        """Return the velocities [m/s] due to the rotation of the body at the positions `place` [m], shape (m, 3) each."""
        return np.cross(self.spin, place - self.centre)

    def mobility_along(self, place: np.ndarray, force: np.ndarray) -> float:
        """Return Σ f·a [N²/kg] over forces f [N] at the positions `place` [m], shape (m, 3) each, with the acceleration a
        that they jointly give the body at each position."""
        strength = resultant(place - self.centre, force)
        return float(np.sum(self.per_mass * strength[:3] ** 2) + strength[3:] @ self.per_inertia @ strength[3:])
