"""The indented cylinder by 27-node bricks, on the very region and patch of the gallery case with 6 and 4 cubes (389 nodes).

    python reference.py BRICKS POWER [DEPTH...]
    python reference.py MESH.npz [DEPTH...]

The second way takes the mesh of the case in full, 18 and 11 cubes (7896 nodes), with one brick to a cube and the patch of
the file that ../mountris2019-indentation/reference.py writes.

The cubes of that mesh, between whose corners edges are straight, are divided into BRICKS along each edge, closer together
towards the edge of the patch and the top where POWER is above 1. A quarter, by symmetry. Prints energies and forces at depths
that are shares of the height. Elements, laws and Newton's method: ../mountris2019-cube/statics.py.
"""

import sys
from pathlib import Path

import felupe as fem
import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "mountris2019-cube"))
from statics import LAWS, Bricks, Static, minimize

RADIUS, HEIGHT = 0.015, 0.017
ACROSS, ALONG = (3, 4) if not sys.argv[1].endswith(".npz") else (9, 11)  # cubes from the axis to the side, and along the axis
PATCH = 1  # cubes from the axis to the edge of the patch: the nodes at up to half the radius


def planes(cubes, near, bricks, power):
    """Planes in units of cubes, closer together towards the one at `near`."""
    share = np.linspace(0.0, 1.0, bricks + 1)
    lines = []
    for cube in range(cubes):
        to_end = 1.0 - (1.0 - share) ** power if cube + 1 == near else share**power if cube == near else share
        lines.append(cube + to_end[:-1])
    return np.append(np.concatenate(lines), cubes)


def between_corners(x, y, z):
    """Places [m] of points in units of cubes: bilinear between the corners of these, which the case draws out to a disc."""
    i, j = np.clip(x.astype(int), 0, ACROSS - 1), np.clip(y.astype(int), 0, ACROSS - 1)
    r, s = x - i, y - j

    def corner(i, j):
        a, b = i / ACROSS, j / ACROSS
        return np.stack([RADIUS * a * np.sqrt(1 - b * b / 2), RADIUS * b * np.sqrt(1 - a * a / 2)])

    shares = (((1 - r) * (1 - s), 0, 0), (r * (1 - s), 1, 0), ((1 - r) * s, 0, 1), (r * s, 1, 1))
    return np.vstack([sum(share * corner(i + a, j + b) for share, a, b in shares), HEIGHT / ALONG * z]).T


def within(points, path):
    """Which points lie on the moved faces of a mesh, to a fiftieth of an edge: diagonals of cubes that are drawn out bend."""
    data = np.load(path)
    faces = data["faces"]
    corners = data["nodes"][faces[data["moved"][faces].all(axis=1)]]
    found = np.zeros(len(points), bool)
    for a, b, c in corners:
        shares = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), (points - a).T, rcond=None)[0].T
        found |= (shares.min(axis=1) > -0.02) & (shares.sum(axis=1) < 1.02)
    return found & np.isclose(points[:, 2], HEIGHT)


class Cylinder:
    """A quarter, from rest; `path`: the file with its patch."""

    def __init__(self, bricks, power, path=None):
        across = planes(ACROSS, PATCH, bricks, power)
        lattice = Bricks([across, across, planes(ALONG, ALONG, bricks, power)])
        x, y, z = lattice.points.T
        points = between_corners(x, y, z)
        self.points = points
        self.static = Static(
            fem.RegionTriQuadraticHexahedron(fem.Mesh(points, lattice.cells, "hexahedron27")), LAWS["coupled"], True
        )
        dof = 3 * np.arange(len(x))
        self.patch, bottom = (z == ALONG) & (x <= PATCH) & (y <= PATCH), z == 0
        if path:
            self.patch = within(points, path)
        held = self.patch | bottom
        self.fixed = np.unique(np.concatenate([dof[x == 0], dof[y == 0] + 1, dof[held], dof[held] + 1, dof[held] + 2]))
        self.u, self.depth, self.last = np.zeros(self.static.size), 0.0, None

    def press(self, depth):
        """Go on to a depth [m]: guess along the last step, else move what lies over the middle of the bottom with the patch."""
        if self.last is not None:
            guess = self.u + (self.u - self.last[0]) * (depth - self.depth) / (self.depth - self.last[1])
            if self.static.state(guess) is None:
                guess = self.u.copy()
        else:
            x, y, z = self.points.T
            guess = np.zeros_like(self.points)
            guess[:, 2] = -depth * z / HEIGHT * np.clip(2.0 - np.hypot(x, y) / (RADIUS / 2), 0.0, 1.0)
            guess = guess.ravel()
        guess = guess.reshape(-1, 3)
        guess[self.patch] = (0.0, 0.0, -depth)
        if self.static.state(guess.ravel()) is None:  # the layer below the patch takes part
            raise FloatingPointError("the guess is inverted")
        new, iterations = minimize(self.static, guess.ravel(), self.fixed, 1e-8)
        self.last, self.u, self.depth = (self.u, self.depth), new, depth
        return iterations

    def results(self):
        """Strain energy [J] and force [N] of the whole, least J of the points and least averaged ratio."""
        state = self.static.state(self.u)
        forces = self.static.forces(state).reshape(-1, 3)
        return 4 * self.static.energy(state), 4 * forces[self.patch, 2].sum(), state[1].min(), state[2].min()


if __name__ == "__main__":
    if sys.argv[1].endswith(".npz"):
        sys.argv[1:2] = ["1", "1", sys.argv[1]]
    bricks, power, *rest = sys.argv[1:]
    path = rest.pop(0) if rest and rest[0].endswith(".npz") else None
    bricks, power = int(bricks), float(power)
    cylinder = Cylinder(bricks, power, path)
    step = 0.0
    for depth in map(float, rest or ("0.1", "0.2", "0.3", "0.4", "0.5")):
        while step < depth - 1e-9:
            step = min(step + (0.05 if path else 0.0125), depth)
            iterations = cylinder.press(step * HEIGHT)
        energy, force, least, ratio = cylinder.results()
        print(f"{bricks},{power:g},{depth:g},{energy:.7f},{force:.6f},{least:.3f},{ratio:.3f},{iterations}", flush=True)
