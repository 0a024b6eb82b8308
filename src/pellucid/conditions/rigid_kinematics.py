"""Centre, angular momentum and inertia of points with masses, shape (n, 1) [kg], and rotations."""

import numpy as np


def centre_of(mass: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Of masses, shape (n, 1) [kg], at places [m]."""
    return np.asarray(np.sum(mass * position, axis=0) / np.sum(mass))


def spin_of(mass: np.ndarray, arm: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Angular momentum [N m s], (3,), of masses at places from the centre [m] with velocities [m/s]."""
    return np.asarray(np.sum(mass * np.cross(arm, velocity), axis=0))


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
