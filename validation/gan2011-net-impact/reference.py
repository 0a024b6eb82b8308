"""The cuboid on the net by finite elements of our own, independent of the package: writes reference.csv.

Nothing changes across the width (the net has ν = 0, the cuboid is free at its sides), so the problem is plane: the net a
row of bars with Cauchy stress E ln(l/l₀), the cuboid four-node quadrilaterals in plane stress with 2 x 2 Gauss points, total
Lagrangian, St. Venant-Kirchhoff. The cuboid's lower nodes are nodes of the net from the start (no slip, no separation): the
assumption that one velocity field makes. Central differences in time. Run: python reference.py [elements per 0.1 m]
"""

import sys
from pathlib import Path

import numpy as np

E, SPAN, END = 2e7, 1.0, 0.2
NET_DENSITY, NET_THICKNESS = 2000.0, 0.0125
CUBOID_DENSITY, NU, LENGTH, HEIGHT, SPEED = 4000.0, 0.2, 0.2, 0.1, 1.0


def mesh(per_decimetre: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes (n, 2), bars (m, 2), quadrilaterals (k, 4); the net's nodes come first."""
    h = 0.1 / per_decimetre
    n = round(SPAN / h) + 1
    net = np.column_stack([np.linspace(0.0, SPAN, n), np.zeros(n)])
    columns, rows = round(LENGTH / h), round(HEIGHT / h)
    first = round((SPAN - LENGTH) / 2 / h)
    above = [(first * h + i * h, j * h) for j in range(1, rows + 1) for i in range(columns + 1)]

    def node(i: int, j: int) -> int:
        return first + i if j == 0 else n + (j - 1) * (columns + 1) + i

    quads = [(node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)) for j in range(rows) for i in range(columns)]
    bars = np.column_stack([np.arange(n - 1), np.arange(1, n)])
    return np.vstack([net, above]), bars, np.array(quads)


def run(per_decimetre: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [s], displacement of the cuboid's centre and of the net's middle along z [m]."""
    X, bars, quads = mesh(per_decimetre)
    h = 0.1 / per_decimetre
    net_nodes = round(SPAN / h) + 1
    mass, cuboid_mass = np.zeros(len(X)), np.zeros(len(X))
    np.add.at(mass, bars.ravel(), 0.5 * NET_DENSITY * NET_THICKNESS * h)
    np.add.at(cuboid_mass, quads.ravel(), 0.25 * CUBOID_DENSITY * h * h)
    mass += cuboid_mass
    velocity = np.zeros_like(X)
    velocity[:, 1] = -SPEED * cuboid_mass / mass  # nodes that the bodies share take their common momentum
    gauss = 0.5 * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))
    gradients = [np.array([[-(1 - t), -(1 - s)], [1 - t, -s], [t, s], [-t, 1 - s]]) / h for s in gauss for t in gauss]
    C = E / (1.0 - NU**2)
    u = np.zeros_like(X)
    held = [0, net_nodes - 1]
    dt = 0.3 * h / np.sqrt(E / NET_DENSITY)
    steps = int(np.ceil(END / dt))
    dt = END / steps
    centre, middle = centre_node(X, net_nodes), (net_nodes - 1) // 2
    times, cuboid_z, net_z = [0.0], [0.0], [0.0]
    for step in range(steps):
        force = np.zeros_like(X)
        a, b = X[bars[:, 0]] + u[bars[:, 0]], X[bars[:, 1]] + u[bars[:, 1]]
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
        velocity += dt * force / mass[:, None]
        velocity[held] = 0.0
        u += dt * velocity
        times.append((step + 1) * dt)
        cuboid_z.append(u[centre, 1])
        net_z.append(u[middle, 1])
    return np.array(times), np.array(cuboid_z), np.array(net_z)


def centre_node(X: np.ndarray, net_nodes: int) -> int:
    """The node in the middle of the cuboid."""
    return net_nodes + int(np.argmin(np.linalg.norm(X[net_nodes:] - (SPAN / 2, HEIGHT / 2), axis=1)))


if __name__ == "__main__":
    fine = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    grid = np.linspace(0.0, END, 201)
    results = {n: [np.interp(grid, run(n)[0], curve) for curve in run(n)[1:]] for n in (fine // 2, fine)}
    change = np.abs(results[fine][0] - results[fine // 2][0]).max() / np.abs(results[fine][0]).max()
    lowest = np.argmin(results[fine][0])
    print(f"lowest {results[fine][0][lowest]:.5f} m at {grid[lowest]:.3f} s; twice as fine changes {100 * change:.2f} %")
    table = np.column_stack([grid, *results[fine]])
    header = "time,cuboid_z,net_z\n#s,m,m"
    np.savetxt(Path(__file__).parent / "reference.csv", table, fmt="%.8g", delimiter=",", header=header, comments="")
