"""Motions of a body as a whole: which of them nothing prevents, and which of these no load resists."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

HELD = 1e-9  # resistance of prescribed components to a motion, over that of all nodes, above which the motion is prevented
NEUTRAL = 1e-9  # change of the forces along a motion with the motion, relative to forces times arms, that is rounding
ANGLE = 1e-3  # of the turns whose forces are compared


def displacements_of(twists: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return the displacements of the nodes in motions as a whole, shape (m, n, 3).

    twists: velocity of the centre and angular velocity times half the size of the body, shape (m, 6); position: positions of
    the nodes [m], shape (n, 3).
    """
    arms = _arms(position)
    return np.asarray(twists[:, None, :3] + np.cross(twists[:, None, 3:], arms[None]))


def loose_twists(position: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return the motions of a body as a whole that prescribed components do not prevent, as twists (see `displacements_of`),
    shape (m, 6).

    position: positions of the nodes [m], shape (n, 3); free: mask of the components that are not prescribed, shape (n, 3).
    """
    resisted = np.where(free, 0.0, displacements_of(np.eye(6), position)).reshape(6, -1)
    sizes, directions = np.linalg.eigh(_products(resisted))
    return np.asarray(directions[:, sizes <= HELD * len(position)].T)


def neutral_twists(loose: np.ndarray, position: np.ndarray, forces: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Return the motions as a whole on which the forces do no work, however far they go: those for which the force along all
    motions is 0 and stays 0.

    loose: motions that are not prevented, as twists, shape (m, 6); position: positions of the nodes [m], shape (n, 3); forces:
    function that returns the external forces [N], shape (n, 3), for positions.
    """
    if not len(loose):
        return loose
    here = forces(position)
    size = float(np.abs(here).sum())

    def along(x: np.ndarray, force: np.ndarray) -> np.ndarray:
        return np.array([float(np.sum(motion * force)) for motion in displacements_of(loose, x)])

    changes = [along(position, here)]
    extent = float(np.abs(position - position.mean(axis=0)).max())
    for twist in loose:
        there = [moved_by(way * ANGLE * twist, position, extent) for way in (1.0, -1.0)]
        one, other = (along(x, forces(x)) for x in there)
        changes.append((one - other) / (2.0 * ANGLE))
    _, sizes, directions = np.linalg.svd(np.array(changes))
    sizes = np.concatenate([sizes, np.zeros(len(loose) - len(sizes))])
    return np.asarray(directions[sizes <= NEUTRAL / ANGLE * size] @ loose)


def moved_by(twist: np.ndarray, position: np.ndarray, extent: float) -> np.ndarray:
    """Return positions after a motion as a whole [m], shape (n, 3). twist: shift over `extent` and turn, shape (6,); extent: half
    the size of the body [m]."""
    centre = position.mean(axis=0)
    return np.asarray(centre + extent * twist[:3] + Rotation.from_rotvec(twist[3:]).apply(position - centre))


def without(motions: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Return displacements without their part along motions, shape (n, 3). motions: displacements, shape (m, n, 3)."""
    for motion in np.linalg.qr(motions.reshape(len(motions), -1).T)[0].T.reshape(motions.shape):
        displacement = displacement - float(np.sum(motion * displacement)) * motion
    return displacement


def _arms(position: np.ndarray) -> np.ndarray:
    arms = position - position.mean(axis=0)
    return np.asarray(arms / (np.abs(arms).max() or 1.0))


def _products(rows: np.ndarray) -> np.ndarray:
    return np.array([[float(np.sum(one * other)) for other in rows] for one in rows])
