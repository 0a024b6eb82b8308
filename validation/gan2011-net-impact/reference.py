"""The cuboid on the net by finite elements of our own, independent of the package.

Nothing changes across the width (the net has ν = 0, the cuboid is free at its sides), so the problem is plane: the net a
row of bars with Cauchy stress E ln(l/l₀), the cuboid four-node quadrilaterals in plane stress with 2 x 2 Gauss points, total
Lagrangian, St. Venant-Kirchhoff. The cuboid's lower face lies in the net's mid-surface. Central differences in time.

Two assumptions about the contact:
tied     the cuboid's lower nodes are nodes of the net: no slip, no separation, as one velocity field has it
sliding  they stay on the net but slide along it without friction: a stiff spring across the net at each of them

    python reference.py [elements per 0.1 m]

writes the table that the package compares runs with, and prints what half the elements change.
"""

import sys
from pathlib import Path

import numpy as np

E, SPAN, END = 2e7, 1.0, 0.2
NET_DENSITY, NET_THICKNESS = 2000.0, 0.0125
CUBOID_DENSITY, NU, LENGTH, HEIGHT, SPEED = 4000.0, 0.2, 0.2, 0.1, 1.0
SPRING = 5.0 * E  # N/m per metre of width, across the net at each of the cuboid's lower nodes
TABLE = Path(__file__).parents[2] / "src/pellucid/references/net_impact.csv"


class Mesh:
    """Nodes X (n, 2), the net's first; bars (m, 2), quadrilaterals (k, 4); `lower`: the cuboid's lower nodes."""

    def __init__(self, per_decimetre: int, tied: bool) -> None:
        self.h = h = 0.1 / per_decimetre
        self.net_nodes = n = round(SPAN / h) + 1
        net = np.column_stack([np.linspace(0.0, SPAN, n), np.zeros(n)])
        columns, rows = round(LENGTH / h), round(HEIGHT / h)
        first = round((SPAN - LENGTH) / 2 / h)
        start = 1 if tied else 0
        own = [(first * h + i * h, j * h) for j in range(start, rows + 1) for i in range(columns + 1)]

        def node(i: int, j: int) -> int:
            return first + i if tied and j == 0 else n + (j - start) * (columns + 1) + i

        quads = [(node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)) for j in range(rows) for i in range(columns)]
        self.X = np.vstack([net, own])
        self.bars = np.column_stack([np.arange(n - 1), np.arange(1, n)])
        self.quads = np.array(quads)
        self.lower = np.array([node(i, 0) for i in range(columns + 1)])
        self.below = first + np.arange(columns + 1)  # the net's nodes under the lower ones, at the start
        self.middle = (n - 1) // 2
        self.centre = n + int(np.argmin(np.linalg.norm(self.X[n:] - (SPAN / 2, HEIGHT / 2), axis=1)))


def run(per_decimetre: int, tied: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [s], displacement of the cuboid's centre and of the net's middle along z [m]."""
    mesh = Mesh(per_decimetre, tied)
    X, bars, quads, h = mesh.X, mesh.bars, mesh.quads, mesh.h
    net_mass, cuboid_mass = np.zeros(len(X)), np.zeros(len(X))
    np.add.at(net_mass, bars.ravel(), 0.5 * NET_DENSITY * NET_THICKNESS * h)
    np.add.at(cuboid_mass, quads.ravel(), 0.25 * CUBOID_DENSITY * h * h)
    mass = net_mass + cuboid_mass
    velocity = np.zeros_like(X)
    velocity[:, 1] = np.where(cuboid_mass > 0.0, -SPEED, 0.0)
    # where the bodies touch they take their common momentum
    common = -SPEED * cuboid_mass[mesh.lower] / (cuboid_mass[mesh.lower] + net_mass[mesh.below])
    velocity[mesh.lower, 1] = velocity[mesh.below, 1] = common
    gauss = 0.5 * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))
    gradients = [np.array([[-(1 - t), -(1 - s)], [1 - t, -s], [t, s], [-t, 1 - s]]) / h for s in gauss for t in gauss]
    C = E / (1.0 - NU**2)
    u = np.zeros_like(X)
    held = [0, mesh.net_nodes - 1]
    dt = 0.3 * h / np.sqrt(E / NET_DENSITY)
    steps = int(np.ceil(END / dt))
    dt = END / steps
    times, cuboid_z, net_z = [0.0], [0.0], [0.0]
    for step in range(steps):
        x = X + u
        force = np.zeros_like(X)
        a, b = x[bars[:, 0]], x[bars[:, 1]]
        length = np.linalg.norm(b - a, axis=1)
        pull = (E * NET_THICKNESS * np.log(length / h) / length)[:, None] * (b - a)
        np.add.at(force, bars[:, 0], pull)
        np.add.at(force, bars[:, 1], -pull)
        local = u[quads]
        for G in gradients:
            F = np.eye(2) + np.einsum("kai,aj->kij", local, G)
            green = 0.5 * (np.einsum("kji,kjl->kil", F, F) - np.eye(2))
            trace = green[:, 0, 0] + green[:, 1, 1]
            S = C * ((1.0 - NU) * green + NU * trace[:, None, None] * np.eye(2))
            nodal = -np.einsum("kij,kjl,al->kai", F, S, G) * (0.25 * h * h)
            np.add.at(force, quads, nodal)
        if not tied:
            hold_on_net(x, mesh, force)
        velocity += dt * force / mass[:, None]
        velocity[held] = 0.0
        u += dt * velocity
        times.append((step + 1) * dt)
        cuboid_z.append(u[mesh.centre, 1])
        net_z.append(u[mesh.middle, 1])
    return np.array(times), np.array(cuboid_z), np.array(net_z)


def hold_on_net(x: np.ndarray, mesh: Mesh, force: np.ndarray) -> None:
    """Springs across the net between it and the cuboid's lower nodes; normals change linearly along a bar."""
    net, lower = x[: mesh.net_nodes], x[mesh.lower]
    tangent = np.gradient(net, axis=0)
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    i = np.clip(np.searchsorted(net[:, 0], lower[:, 0]) - 1, 0, mesh.net_nodes - 2)
    s = ((lower[:, 0] - net[i, 0]) / (net[i + 1, 0] - net[i, 0]))[:, None]
    n = (1.0 - s) * normal[i] + s * normal[i + 1]
    n /= np.linalg.norm(n, axis=1)[:, None]
    gap = np.sum((lower - (1.0 - s) * net[i] - s * net[i + 1]) * n, axis=1)[:, None]
    push = SPRING * gap * n
    np.add.at(force, mesh.lower, -push)
    np.add.at(force, i, (1.0 - s) * push)
    np.add.at(force, i + 1, s * push)


def main(fine: int) -> None:
    grid = np.linspace(0.0, END, 201)
    columns = [grid]
    for tied in (True, False):
        name = "tied" if tied else "sliding"
        curves = []
        for elements in (fine // 2, fine):
            times, *found = run(elements, tied)
            curves.append([np.interp(grid, times, curve) for curve in found])
        coarse, finest = (pair[0] for pair in curves)
        lowest = np.argmin(finest)
        change = np.abs(finest - coarse).max() / np.abs(finest).max()
        print(f"{name}: lowest {finest[lowest]:.5f} m at {grid[lowest]:.3f} s; half the elements change {100 * change:.2f} %")
        columns += curves[1]
    header = (
        "# The cuboid on the net by finite elements: validation/gan2011-net-impact/reference.py.\n"
        "time,tied_cuboid_z,tied_net_z,sliding_cuboid_z,sliding_net_z\n# s,m,m,m,m"
    )
    np.savetxt(TABLE, np.column_stack(columns), fmt="%.8g", delimiter=",", header=header, comments="")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
