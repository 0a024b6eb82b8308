"""The inflated bag at rest by energy minimisation: independent of pellucid, numpy and scipy alone.

An eighth of a bag of two square sheets of side 1, joined at their edges: one quarter of one sheet, of constant-strain triangles,
between three planes of symmetry. Sought is the least of the elastic energy less pressure times volume. The sheet bears no
compression: the energy of a triangle is that of the principal Green strains e1 >= e2 (Pipkin 1986, IMA J. Appl. Math. 36, 85)

    taut,     e2 + nu e1 > 0:   K/2 (e1² + e2² + 2 nu e1 e2) / (1 - nu²)
    wrinkled, e1 > 0:           K/2 e1²
    slack:                      0

per area, with K = E t. The sheet has no stress at the start, which is flat or domed to a height. With small p/K the bag is as good as
inextensible: the paper bag problem.

    python bag.py                    volumes for flat and domed sheets, finer and finer
"""

import numpy as np
from scipy.optimize import minimize


def mesh(n: int, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of n x n squares cut in four about their middles; domed to half the height in the middle."""
    lattice = np.linspace(0.0, 0.5, n + 1)
    middle = 0.5 * (lattice[1:] + lattice[:-1])
    x = np.concatenate([np.stack(np.meshgrid(s, s, indexing="ij"), axis=-1).reshape(-1, 2) for s in (lattice, middle)])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, m = i * (n + 1) + j, (i + 1) * (n + 1) + j, (n + 1) ** 2 + i * n + j
    around = [a, b, b + 1, a + 1]
    triangles = np.concatenate([np.stack([around[k], around[(k + 1) % 4], m], axis=1) for k in range(4)])
    z = 0.5 * height * np.prod(1.0 - (2.0 * x) ** 2, axis=1)
    return np.column_stack([x, z]), triangles


class Bag:
    """The bag's energy over K = E t; pressures are p/K [1/m]."""

    def __init__(self, n: int, height: float, nu: float) -> None:
        self.x0, self.triangles = mesh(n, height)
        self.nu = nu
        a, b, c = self.x0[self.triangles.T]
        first = b - a
        e1 = first / np.linalg.norm(first, axis=1)[:, None]
        normal = np.cross(first, c - a)
        e2 = np.cross(normal / np.linalg.norm(normal, axis=1)[:, None], e1)
        edges = np.empty((len(a), 2, 2))
        for column, edge in enumerate((first, c - a)):
            edges[:, 0, column], edges[:, 1, column] = (edge * e1).sum(axis=1), (edge * e2).sum(axis=1)
        self.area, self.inverse = 0.5 * np.linalg.det(edges), np.linalg.inv(edges)
        # planes of symmetry x = 0, y = 0; the rim stays in z = 0
        x = self.x0
        rim = (x[:, 0] > 0.5 - 1e-9) | (x[:, 1] > 0.5 - 1e-9)
        self.free = np.stack([x[:, 0] > 1e-9, x[:, 1] > 1e-9, ~rim], axis=1)

    def volume(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Under the sheet, an eighth of the bag's, and its gradient."""
        a, b, c = (x[k] for k in self.triangles.T)
        gradient = np.zeros_like(x)
        # mean height times the area on the plane z = 0
        d1, d2, z = b - a, c - a, (a + b + c)[:, 2] / 3.0
        plan = 0.5 * (d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0])
        for k, (p, q) in enumerate(((b, c), (c, a), (a, b))):
            part = np.column_stack([0.5 * z * (p - q)[:, 1], 0.5 * z * (q - p)[:, 0], plan / 3.0])
            np.add.at(gradient, self.triangles[:, k], part)
        return float((z * plan).sum()), gradient

    def energy(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Elastic energy over K and its gradient."""
        a, b, c = (x[k] for k in self.triangles.T)
        F = np.stack([b - a, c - a], axis=2) @ self.inverse
        E = 0.5 * (np.swapaxes(F, 1, 2) @ F - np.eye(2))
        e, axes = np.linalg.eigh(E)
        low, high = e.T
        nu = self.nu
        taut, wrinkled = low + nu * high > 0.0, high > 0.0
        S = np.zeros_like(e)
        S[:, 1] = np.where(taut, (high + nu * low) / (1.0 - nu**2), np.where(wrinkled, high, 0.0))
        S[:, 0] = np.where(taut, (low + nu * high) / (1.0 - nu**2), 0.0)
        W = 0.5 * (S * e).sum(axis=1)
        stress = np.einsum("tik,tk,tjk->tij", axes, S, axes)
        # dW/dx of the corners b and c
        pull = (self.area[:, None, None] * (F @ stress)) @ np.swapaxes(self.inverse, 1, 2)
        gradient = np.zeros_like(x)
        np.add.at(gradient, self.triangles[:, 1], pull[:, :, 0])
        np.add.at(gradient, self.triangles[:, 2], pull[:, :, 1])
        np.add.at(gradient, self.triangles[:, 0], -pull.sum(axis=2))
        return float((self.area * W).sum()), gradient

    def inflate(self, pressures: list[float], start: np.ndarray | None = None) -> np.ndarray:
        """Places at rest under the last of some falling p/K, each from the one before."""
        x = self.x0.copy() if start is None else start.copy()
        if start is None:
            x[:, 2] = np.where(self.free[:, 2], 0.2 * np.prod(1.0 - (2.0 * self.x0[:, :2]) ** 2, axis=1), 0.0)
        for p in pressures:

            def total(q: np.ndarray, p: float = p) -> tuple[float, np.ndarray]:
                y = self.x0.copy()
                y[self.free] = q
                y[:, :2][~self.free[:, :2]] = 0.0
                W, dW = self.energy(y)
                V, dV = self.volume(y)
                return (W - p * V) / p**2, (dW - p * dV)[self.free] / p**2

            found = minimize(
                total, x[self.free], jac=True, method="L-BFGS-B", options={"maxiter": 20000, "maxfun": 30000, "maxcor": 50, "ftol": 1e-12, "gtol": 1e-8}
            )
            x[self.free] = found.x
        return x


def main() -> None:
    print("height  cells      p/K   volume  half_height  half_width_mid  half_width_corner  steps")
    for height in (0.0, 0.1):
        for n in (8, 16, 32):
            bag = Bag(n, height, 0.3)
            x = None
            for p in (0.1, 0.03, 0.01, 0.003, 0.001):
                x = bag.inflate([p], x)
                V = 8.0 * bag.volume(x)[0]
                corner = x[(n + 1) ** 2 - 1]
                print(f"{height:6.2f} {n:6d} {p:8.4f} {V:8.5f} {x[0,2]:9.4f} {x[n,1]:9.4f} {corner[0]:9.4f}", flush=True)


if __name__ == "__main__":
    main()
