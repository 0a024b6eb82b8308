"""Motions of a body as a whole: which of them nothing prevents, and which of these no load resists."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from pellucid.linear.elimination import on_one_thread

HELD = 1e-9  # resistance of prescribed components to a motion, over that of all nodes, above which the motion is prevented
NEUTRAL = 1e-6  # change of the forces along a motion with a motion, relative to the forces, that is rounding
ANGLE = 1e-3  # of the motions whose forces are compared, relative to the size of the body
DEPENDENT = 1e-9  # size of a motion without its part along others, over its size, below which it is one of them
ALIGNMENTS = 5  # iterations, which converge quadratically


@dataclass(frozen=True)
class Twists:
    """Motions of a body as a whole: shifts with turns about a fixed point. Positions and displacements of nodes [m] have the
    shape (n, 3)."""

    values: np.ndarray  # (m, 6) shift of the point, and turn times half the size of the body [m]
    centre: np.ndarray  # (3,) the point [m]
    extent: float  # half the size of the body [m]

    def __len__(self) -> int:
        return len(self.values)

    def displacements(self, position: np.ndarray) -> np.ndarray:
        """Return the displacements of nodes at these positions, to first order in the motions, shape (m, n, 3)."""
        arms = (position - self.centre) / self.extent
        return np.asarray(self.values[:, None, :3] + np.cross(self.values[:, None, 3:], arms[None]))

    def moved(self, amounts: np.ndarray, position: np.ndarray) -> np.ndarray:
        """Return positions after a sum of the motions: a screw motion about one axis, so points that do not move to first order
        stay where they are. amounts: of each motion, shape (m,)."""
        total = amounts @ self.values
        turn = total[3:] / self.extent
        angle = float(np.linalg.norm(turn))
        cross = np.cross(turn, np.eye(3)).T  # whose product with a vector is the cross product
        first, second = 0.5, 1.0 / 6.0
        if angle > 1e-4:
            first, second = (1.0 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3
        shift = (np.eye(3) + first * cross + second * cross @ cross) @ total[:3]
        return np.asarray(self.centre + shift + Rotation.from_rotvec(turn).apply(position - self.centre))

    def aligned(self, position: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Return positions that the motions have brought next to those of a reference."""
        for _ in range(ALIGNMENTS):
            motions = self.displacements(position).reshape(len(self), -1)
            with on_one_thread():
                amounts = np.linalg.lstsq(motions.T, (reference - position).ravel(), rcond=None)[0]
            position = self.moved(amounts, position)
        return position

    def without(self, displacement: np.ndarray, position: np.ndarray) -> np.ndarray:
        """Return displacements of nodes at these positions without their part along the motions."""
        others: list[np.ndarray] = []
        for motion in self.displacements(position):
            size = float(np.sum(motion * motion)) ** 0.5
            for other in (*others, *others):  # twice, so that they are orthogonal up to rounding
                motion = motion - float(np.sum(other * motion)) * other
            left = float(np.sum(motion * motion)) ** 0.5
            if left > DEPENDENT * size:
                others.append(motion / left)
        for motion in others:
            displacement = displacement - float(np.sum(motion * displacement)) * motion
        return displacement


def no_twists() -> Twists:
    """Return no motions."""
    return Twists(np.zeros((0, 6)), np.zeros(3), 1.0)


def loose_twists(position: np.ndarray, free: np.ndarray) -> Twists:
    """Return the motions of a body as a whole that prescribed components do not prevent.

    position: positions of the nodes [m], shape (n, 3); free: mask of the components that are not prescribed, shape (n, 3).
    """
    centre = position.mean(axis=0)
    every = Twists(np.eye(6), centre, float(np.abs(position - centre).max()) or 1.0)
    resisted = np.where(free, 0.0, every.displacements(position))
    products = [[float(np.sum(one * other)) for other in resisted] for one in resisted]
    sizes, directions = np.linalg.eigh(np.array(products))
    return replace(every, values=directions[:, sizes <= HELD * len(position)].T)


def neutral_twists(loose: Twists, position: np.ndarray, forces: Callable[[np.ndarray], np.ndarray]) -> Twists:
    """Return the motions as a whole, of any size, on which the forces do no work: those for which the force along all motions
    is 0 and stays 0.

    loose: motions that are not prevented; position: positions of the nodes [m], shape (n, 3); forces: function that returns the
    external forces [N], shape (n, 3), for positions.
    """
    if not len(loose):
        return loose

    def along(x: np.ndarray) -> np.ndarray:
        force = forces(x)
        return np.array([float(np.sum(motion * force)) for motion in loose.displacements(x)])

    size, changes = float(np.abs(forces(position)).sum()), [along(position)]
    step = ANGLE * loose.extent
    for amount in np.eye(len(loose)):
        ahead, behind = (along(loose.moved(way * amount, position)) for way in (step, -step))
        changes.append((ahead - behind) / (2.0 * ANGLE))
    _, sizes, directions = np.linalg.svd(np.array(changes))
    return replace(loose, values=directions[sizes <= NEUTRAL * size] @ loose.values)
