"""The lid blown up by a gas, with a cube on it, by finite elements of our own that share nothing with the package.

A quarter of the box (x, y from the wall at 0 to the plane of symmetry at 0.1 m). Explicit central differences, lumped masses.
Lid      bilinear quadrilaterals, 2 x 2 Gauss points, any rotation and stretch: Cauchy stress E/(1-ν²) (e₁ + ν e₂) in the
         directions of the principal stretches, e their logarithms (what a strain accumulated in the carried frame comes to
         where the principal directions stay in the material), thickness h (1 - ν/(1-ν) (e₁ + e₂)); no bending stiffness
Cube     eight-node bricks, 2 x 2 x 2 Gauss points, St. Venant-Kirchhoff; its lower nodes are nodes of the lid
Gas      γ = 1.4, adiabatic, without viscosity; two models:
         flowing  trilinear bricks that follow the gas, each with one pressure p₀ (V₀/V)^γ and the gas's mass at its nodes;
                  its upper nodes are the lid's: no slip, as in one velocity field. Waves and inertia of the gas are in it.
         uniform  one pressure p₀ (V₀/V)^γ for the whole box: a gas without inertia

    python reference.py [elements per 0.1 m]

writes the table that the package compares runs with, and prints what half the elements and the other gas change.
"""

import sys
from itertools import product
from pathlib import Path

import numpy as np

HALF, HEIGHT, END = 0.1, 0.1, 0.03
LID_E, LID_NU, LID_DENSITY, THICKNESS = 1e5, 0.45, 1000.0, 0.01
CUBE, CUBE_E, CUBE_NU, CUBE_DENSITY = 0.04, 1e7, 0.2, 1000.0
PRESSURE, GAMMA, GAS_DENSITY = 800.0, 1.4, 1.0
COURANT = 0.35
TABLE = Path(__file__).parents[2] / "src/pellucid/references/membrane_expansion.csv"
GAUSS = (-1.0 / np.sqrt(3.0), 1.0 / np.sqrt(3.0))


def corner_functions(dimensions: int, h: float) -> list[np.ndarray]:
    """Gradients of the corner functions of a cube of edge h at its Gauss points, each (corners, dimensions)."""
    corners = np.array(list(product((-1.0, 1.0), repeat=dimensions)))
    result = []
    for point in product(GAUSS, repeat=dimensions):
        factors = 0.5 * (1.0 + corners * np.array(point))
        gradient = [np.prod(np.delete(factors, d, axis=1), axis=1) * corners[:, d] / h for d in range(dimensions)]
        result.append(np.column_stack(gradient))
    return result


def block(counts: tuple[int, ...]) -> np.ndarray:
    """Corners of the elements of a lattice with so many elements each way, in the order of `corner_functions`."""
    number = np.arange(np.prod([c + 1 for c in counts])).reshape([c + 1 for c in counts])
    shifts = product((0, 1), repeat=len(counts))
    return np.stack([number[tuple(slice(s, s + c) for s, c in zip(t, counts, strict=True))].ravel() for t in shifts], axis=1)


def lattice(counts: tuple[int, int, int], h: float, origin: tuple[float, float, float]) -> np.ndarray:
    axes = [o + h * np.arange(c + 1) for c, o in zip(counts, origin, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


class Model:
    """Gas block first (its top layer is the lid), then what is above the lid of the cube."""

    def __init__(self, per_decimetre: int, flowing: bool) -> None:
        self.h = h = 0.1 / per_decimetre
        self.flowing = flowing
        n, m, up = per_decimetre, round(0.5 * CUBE / h), round(CUBE / h)
        self.box = block((n, n, n))
        gas_nodes = lattice((n, n, n), h, (0.0, 0.0, 0.0))
        number = np.arange(len(gas_nodes)).reshape(n + 1, n + 1, n + 1)
        self.lid = number[:, :, n].ravel()[block((n, n))]
        cube_lattice = lattice((m, m, up), h, (HALF - 0.5 * CUBE, HALF - 0.5 * CUBE, HEIGHT))
        own = np.arange(len(cube_lattice)).reshape(m + 1, m + 1, up + 1)
        nodes = np.empty_like(own)
        nodes[:, :, 0] = number[n - m :, n - m :, n]
        nodes[:, :, 1:] = len(gas_nodes) + np.arange((m + 1) ** 2 * up).reshape(m + 1, m + 1, up)
        self.cube = nodes.ravel()[block((m, m, up))]
        self.X = np.vstack([gas_nodes, cube_lattice[own[:, :, 1:].ravel()]])
        self.centre = nodes[m, m, up // 2]
        self.mass = np.zeros(len(self.X))
        np.add.at(self.mass, self.lid, 0.25 * LID_DENSITY * THICKNESS * h**2)
        np.add.at(self.mass, self.cube, 0.125 * CUBE_DENSITY * h**3)
        if flowing:
            np.add.at(self.mass, self.box, 0.125 * GAS_DENSITY * h**3)
        self.free = self._free(number, n)
        self.lid_gradients, self.brick_gradients = corner_functions(2, h), corner_functions(3, h)
        self.u = np.zeros_like(self.X)
        self.v = np.zeros_like(self.X)

    def _free(self, number: np.ndarray, n: int) -> np.ndarray:
        free = np.ones((len(self.X), 3))
        for d in (0, 1):  # the wall and the plane of symmetry
            free[np.abs(self.X[:, d]) < 1e-9, d] = 0.0
            free[np.abs(self.X[:, d] - HALF) < 1e-9, d] = 0.0
        free[self.X[:, 2] < 1e-9, 2] = 0.0
        free[number[0, :, n]] = free[number[:, 0, n]] = 0.0  # the lid's edge
        if not self.flowing:
            free[number[:, :, :n].ravel()] = 0.0
        return free

    def forces(self) -> np.ndarray:
        force = np.zeros_like(self.X)
        self._stretch_lid(force)
        self._deform_cube(force)
        if self.flowing:
            self._flow(force)
        else:
            self._blow(force)
        return force

    def _stretch_lid(self, force: np.ndarray) -> None:
        x = self.X[self.lid] + self.u[self.lid]
        C = LID_E / (1.0 - LID_NU**2)
        for G in self.lid_gradients:
            F = np.einsum("kai,aj->kij", x, G)  # (k, 3, 2)
            metric = np.einsum("kij,kil->kjl", F, F)
            square, N = np.linalg.eigh(metric)
            e = 0.5 * np.log(square)
            thickness = THICKNESS * (1.0 - LID_NU / (1.0 - LID_NU) * e.sum(axis=1))
            stress = C * (e + LID_NU * e[:, ::-1])
            weight = thickness * np.sqrt(square.prod(axis=1)) * 0.25 * self.h**2
            S = np.einsum("kja,ka,kla->kjl", N, stress / square * weight[:, None], N)
            np.add.at(force, self.lid, -np.einsum("kij,kjl,al->kai", F, S, G))

    def _deform_cube(self, force: np.ndarray) -> None:
        x = self.X[self.cube] + self.u[self.cube]
        lam = CUBE_E * CUBE_NU / ((1.0 + CUBE_NU) * (1.0 - 2.0 * CUBE_NU))
        mu = CUBE_E / (2.0 * (1.0 + CUBE_NU))
        for G in self.brick_gradients:
            F = np.einsum("kai,aj->kij", x, G)
            green = 0.5 * (np.einsum("kji,kjl->kil", F, F) - np.eye(3))
            S = 2.0 * mu * green + lam * np.trace(green, axis1=1, axis2=2)[:, None, None] * np.eye(3)
            np.add.at(force, self.cube, -np.einsum("kij,kjl,al->kai", F, S, G) * (0.125 * self.h**3))

    def _flow(self, force: np.ndarray) -> None:
        x = self.X[self.box] + self.u[self.box]
        volume, growth = np.zeros(len(x)), np.zeros_like(x)
        for G in self.brick_gradients:
            F = np.einsum("kai,aj->kij", x, G)
            a, b, c = F[:, :, 0], F[:, :, 1], F[:, :, 2]
            cofactor = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=2)
            volume += np.einsum("ki,ki->k", a, cofactor[:, :, 0])
            growth += np.einsum("kij,aj->kai", cofactor, G)
        J = 0.125 * volume
        self.pressure = PRESSURE * J**-GAMMA
        np.add.at(force, self.box, self.pressure[:, None, None] * growth * (0.125 * self.h**3))

    def _blow(self, force: np.ndarray) -> None:
        x = self.X[self.lid] + self.u[self.lid]
        volume, pushes = 0.0, []
        for i, j, k in ((0, 2, 3), (0, 3, 1), (0, 2, 1), (1, 2, 3)):  # both ways to cut a quadrilateral, half each
            a, b, c = x[:, i], x[:, j], x[:, k]
            area = 0.25 * np.cross(b - a, c - a)
            volume += float(np.sum(area[:, 2] * (a + b + c)[:, 2]) / 3.0)
            pushes += [(self.lid[:, n], area / 3.0) for n in (i, j, k)]
        self.pressure = np.array([PRESSURE * (HALF**2 * HEIGHT / volume) ** GAMMA])
        for nodes, push in pushes:
            np.add.at(force, nodes, self.pressure[0] * push)

    def step(self, dt: float) -> None:
        self.v += self.free * dt * self.forces() / np.where(self.mass > 0.0, self.mass, 1.0)[:, None]
        self.u += dt * self.v


def run(per_decimetre: int, flowing: bool, shapes: tuple[float, ...] = ()) -> tuple[np.ndarray, list[np.ndarray]]:
    """Columns time, cube_z, mean gas pressure; and the lid's nodes at the instants `shapes`, each (n, n, 3)."""
    model = Model(per_decimetre, flowing)
    dt = COURANT * model.h / np.sqrt(CUBE_E / CUBE_DENSITY * 1.2)
    steps = int(np.ceil(END / dt))
    dt = END / steps
    rows, kept = [(0.0, 0.0, PRESSURE)], []
    for number in range(1, steps + 1):
        model.step(dt)
        rows.append((number * dt, model.u[model.centre, 2], float(model.pressure.mean())))
        if any(abs(number * dt - t) <= 0.5 * dt for t in shapes):
            n = per_decimetre + 1
            x = (model.X + model.u)[: n**3].reshape(n, n, n, 3)
            kept.append(x[:, :, -1].copy())
    return np.array(rows), kept


def main(fine: int) -> None:
    grid = np.linspace(0.0, END, 121)
    curves = {}
    for name, elements, flowing in (
        ("flowing", fine, True),
        ("coarse", fine // 2, True),
        ("uniform", fine, False),
        ("uniform, fine", 2 * fine, False),
    ):
        rows, _ = run(elements, flowing)
        curves[name] = np.column_stack([np.interp(grid, rows[:, 0], column) for column in rows.T[1:]])
        print(f"{name}: cube {curves[name][-1, 0]:.5f} m, gas {curves[name][-1, 1]:.1f} Pa at {END} s", flush=True)
    for one, other in (("flowing", "coarse"), ("flowing", "uniform"), ("uniform", "uniform, fine")):
        change = np.abs(curves[one] - curves[other]).max(axis=0) / np.abs(curves[one] - curves[one][0]).max(axis=0)
        print(f"{one} against {other}: cube {100 * change[0]:.2f} %, pressure {100 * change[1]:.2f} % of the largest change")
    header = (
        "# The lid and its cube by finite elements: validation/gan2011-membrane-expansion/reference.py.\n"
        "time,flowing_cube_z,flowing_gas_pressure,uniform_cube_z,uniform_gas_pressure\n# s,m,Pa,m,Pa"
    )
    table = np.column_stack([grid, curves["flowing"], curves["uniform"]])
    np.savetxt(TABLE, table, fmt="%.7g", delimiter=",", header=header, comments="")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
