"""The inflated bag at rest by energy minimisation: independent of pellucid, numpy and scipy alone.

An eighth of a bag of two square sheets of side 1, joined at their edges: a quarter of one sheet, of constant-strain triangles,
between three planes of symmetry. Sought is the least of the elastic energy less pressure times volume. The sheet bears no
compression: the energy of a triangle is that of the principal Green strains e1 >= e2 (Pipkin 1986, IMA J. Appl. Math. 36, 85)

    taut,     e2 + nu e1 > 0:   K/2 (e1² + e2² + 2 nu e1 e2) / (1 - nu²)
    wrinkled, e1 > 0:           K/2 e1²
    slack:                      0

per area, with K = E t. The sheet has no stress at the start, where it is flat or domed to a height. With small p/K the bag is
as good as inextensible: the paper bag problem.

    python bag.py            the paper bag's volume: a flat bag, finer and finer, at lower and lower pressure
    python bag.py --write    src/pellucid/references/inflated_bag.csv: the domed bag of the gallery, height 0.1
"""

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.sparse import csr_matrix

POISSON_RATIO = 0.3
HEIGHT, CELLS = 0.1, 32
PRESSURES = (0.1, 0.06, 0.04, 0.03, 0.02, 0.01)
REFERENCE = Path(__file__).parents[2] / "src" / "pellucid" / "references" / "inflated_bag.csv"


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
        m = len(self.triangles)
        corner = (np.ones(3 * m), (self.triangles.T.ravel(), np.arange(3 * m)))
        self.gather = csr_matrix(corner, shape=(len(self.x0), 3 * m))  # from corners of triangles to vertices
        # planes of symmetry x = 0, y = 0; the rim stays in z = 0
        x = self.x0
        rim = (x[:, 0] > 0.5 - 1e-9) | (x[:, 1] > 0.5 - 1e-9)
        self.free = np.stack([x[:, 0] > 1e-9, x[:, 1] > 1e-9, ~rim], axis=1)

    def volume(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Under the sheet, an eighth of the bag's, and its gradient."""
        a, b, c = (x[k] for k in self.triangles.T)
        # mean height times the area on the plane z = 0
        d1, d2, z = b - a, c - a, (a + b + c)[:, 2] / 3.0
        plan = 0.5 * (d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0])
        parts = [
            np.column_stack([0.5 * z * (p - q)[:, 1], 0.5 * z * (q - p)[:, 0], plan / 3.0]) for p, q in ((b, c), (c, a), (a, b))
        ]
        return float((z * plan).sum()), self.gather @ np.concatenate(parts)

    def energy(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Elastic energy over K and its gradient."""
        a, b, c = (x[k] for k in self.triangles.T)
        F = np.stack([b - a, c - a], axis=2) @ self.inverse
        first, second = F[:, :, 0], F[:, :, 1]
        e11, e22 = 0.5 * ((first**2).sum(axis=1) - 1.0), 0.5 * ((second**2).sum(axis=1) - 1.0)
        e12 = 0.5 * (first * second).sum(axis=1)
        mean, half = 0.5 * (e11 + e22), 0.5 * (e11 - e22)
        radius = np.hypot(half, e12)
        low, high, nu = mean - radius, mean + radius, self.nu
        taut, wrinkled = low + nu * high > 0.0, high > 0.0
        major = np.where(taut, (high + nu * low) / (1.0 - nu**2), np.where(wrinkled, high, 0.0))
        minor = np.where(taut, (low + nu * high) / (1.0 - nu**2), 0.0)
        W = 0.5 * (major * high + minor * low)
        turn = 0.5 * (major - minor) / np.maximum(radius, 1e-300)  # stress and strain have the same principal axes
        s11, s22, s12 = 0.5 * (major + minor) + turn * half, 0.5 * (major + minor) - turn * half, turn * e12
        stress = np.stack([np.stack([s11, s12], axis=1), np.stack([s12, s22], axis=1)], axis=1)
        # dW/dx of the corners b and c
        pull = (self.area[:, None, None] * (F @ stress)) @ np.swapaxes(self.inverse, 1, 2)
        corners = np.concatenate([-pull.sum(axis=2), pull[:, :, 0], pull[:, :, 1]])
        return float((self.area * W).sum()), self.gather @ corners

    def inflate(self, p: float, start: np.ndarray | None = None) -> np.ndarray:
        """Places at rest under p/K [1/m], sought from a start."""
        begin = self.x0.copy() if start is None else start
        if start is None:
            begin[:, 2] = np.where(self.free[:, 2], 0.2 * np.prod(1.0 - (2.0 * self.x0[:, :2]) ** 2, axis=1), 0.0)

        def placed(q: np.ndarray) -> np.ndarray:
            x = self.x0.copy()
            x[self.free] = q
            return x

        def total(q: np.ndarray) -> tuple[float, np.ndarray]:
            x = placed(q)
            (W, dW), (V, dV) = self.energy(x), self.volume(x)
            return (W - p * V) / p**2, (dW - p * dV)[self.free] / p**2

        options = {"maxiter": 20000, "maxfun": 30000, "maxcor": 50, "ftol": 1e-12, "gtol": 1e-8}
        return placed(minimize(total, begin[self.free], jac=True, method="L-BFGS-B", options=options).x)


def row(bag: Bag, n: int, p: float, x: np.ndarray) -> tuple[float, ...]:
    """p/K, volume of the whole bag, half its height, half widths in the middle of an edge and at a corner."""
    return p, 8.0 * bag.volume(x)[0], x[0, 2], x[n, 1], x[(n + 1) ** 2 - 1, 0]


def paper_bag() -> None:
    """Print the flat bag's volumes."""
    print("cells     p/K   volume  half height  half width  corner")
    for n in (8, 16, 32):
        bag, x = Bag(n, 0.0, POISSON_RATIO), None
        for p in (0.1, 0.03, 0.01, 0.003, 0.001):
            x = bag.inflate(p, x)
            print(n, *(f"{value:10.5f}" for value in row(bag, n, p, x)), flush=True)


def write() -> None:
    """Write the reference of the gallery case."""
    bag, x, rows = Bag(CELLS, HEIGHT, POISSON_RATIO), None, []
    for p in PRESSURES:
        x = bag.inflate(p, x)
        rows.append(row(bag, CELLS, p, x))
        print(*(f"{value:10.5f}" for value in rows[-1]), flush=True)
    lines = [",".join(f"{value:.6g}" for value in values) for values in rows[::-1]]
    head = "# The bag of lian2014/airbag at rest by least energy: validation/lian2014-airbag/bag.py. p/(E t) in 1/m, m³, m"
    names = "pressure,volume,height,half_width,corner"
    REFERENCE.write_text("\n".join([head, names, *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write() if "--write" in sys.argv else paper_bag()
