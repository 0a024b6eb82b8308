"""The cube between two plates to which it sticks: one eighth of it, by symmetry about three planes."""

import numpy as np
from statics import Bricks, Static, minimize

SIDE = 0.1
HALF = SIDE / 2


def graded(n, power):
    """Planes from 0 to half the side [m], closer together towards the end."""
    return HALF * (1 - (1 - np.linspace(0, 1, n + 1)) ** power)


class Cube:
    """The eighth between the middle (x = y = 0), a lower plate (z = 0) and the plane half-way up; free at x, y = HALF."""

    def __init__(self, n, law, mixed=True, power=2.0):
        line = graded(n, power)
        self.bricks = Bricks([line, line, HALF - line[::-1]])
        self.static = Static(self.bricks.region, law, mixed)
        x, y, z = self.bricks.points.T
        dof = 3 * np.arange(len(x))
        self.plate, middle = z == 0, z == z.max()
        self.fixed = np.unique(np.concatenate([
            dof[x == 0], dof[y == 0] + 1, dof[middle] + 2, dof[self.plate], dof[self.plate] + 1, dof[self.plate] + 2
        ]))  # fmt: skip
        self.u = np.zeros(self.static.size)
        self.moved = 0.0

    def move(self, to):
        """Go on to a distance [m] that the plates have moved apart in all. The guess stretches what is as a whole."""
        height, new = HALF + self.moved / 2, HALF + to / 2
        u = self.u.reshape(-1, 3).copy()
        z = self.bricks.points[:, 2]
        u[:, 2] = HALF + (z + u[:, 2] - HALF) * new / height - z
        u, iterations = minimize(self.static, u.ravel(), self.fixed)
        self.u, self.moved = u, to
        return iterations

    def start(self, other):
        """Take the solution of another mesh as a guess, and solve."""
        self.moved = other.moved
        u = self.bricks.interpolate(other.bricks, other.u)
        u[self.plate] = [0.0, 0.0, -other.moved / 2]
        u, iterations = minimize(self.static, u.ravel(), self.fixed)
        self.u = u
        return iterations

    def energy(self):
        """Strain energy of the whole cube [J]."""
        return 8 * self.static.energy(self.static.state(self.u))

    def reaction(self):
        """Force along z on the upper face of the whole cube [N]."""
        state = self.static.state(self.u)
        forces = self.static.forces(state).reshape(-1, 3)
        return -4 * float(forces[self.plate, 2].sum())

    def lowest(self):
        """How far the free sides reach above the lower plate's plane [m]; below zero: they pass it."""
        z = self.bricks.points[:, 2] + self.u.reshape(-1, 3)[:, 2]
        return float(z[~self.plate].min()) + self.moved / 2

    def bulge(self, heights):
        """Displacements [m] across and along z of the middle of a free face and of a free edge, at heights up to HALF [m].

        The lower plate is taken to be at rest. Quadratic between the nodes, as the elements are.
        """
        line = self.bricks.lines[2]
        x, y, _ = self.bricks.points.T
        u = self.u.reshape(-1, 3) + np.array([0.0, 0.0, self.moved / 2])
        first = 2 * np.clip(np.searchsorted(line[::2], heights, side="right") - 1, 0, len(line) // 2 - 1)
        r = (heights - line[first]) / (line[first + 2] - line[first])
        shares = np.stack([(1 - r) * (1 - 2 * r), 4 * r * (1 - r), r * (2 * r - 1)])
        columns = []
        for where in ((x == HALF) & (y == 0), (x == HALF) & (y == HALF)):
            along = u[where]
            columns += [sum(shares[i] * along[first + i, axis] for i in range(3)) for axis in (0, 2)]
        return np.stack(columns, axis=1)
