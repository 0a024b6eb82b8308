"""Steady flow in a lid-driven cavity by finite differences, independent of the package.

python cavity.py    writes lid-driven-cavity-100.csv and -400.csv into the gallery, and prints the extremes (two minutes)

The stream function ψ on a uniform grid of n x n cells, with ∇²ω/Re = u·∇ω, ω = -∇²ψ, by central differences; vorticity at the
walls by Thom's formula; Newton's method. The results of 128 and 256 cells are extrapolated by the square of the cell.
"""

import csv
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import spsolve

GALLERY = Path(__file__).parents[2] / "src" / "pellucid" / "gallery" / "flows"
AT = np.linspace(0.0, 1.0, 65)


def stream_function(n: int, reynolds: float) -> np.ndarray:
    """Return ψ at the nodes, shape (n + 1, n + 1), for a cavity of edge 1 and a lid at y = 1 of velocity 1."""
    h, m = 1.0 / n, n - 1
    one, second = sparse.identity(m), sparse.diags_array([1.0, -2.0, 1.0], offsets=[-1, 0, 1], shape=(m, m)) / h**2
    first = sparse.diags_array([-1.0, 1.0], offsets=[-1, 1], shape=(m, m)) / (2 * h)
    low, high = (sparse.csr_array(([1.0], ([k], [k])), shape=(m, m)) for k in (0, m - 1))
    laplace = (sparse.kron(second, one) + sparse.kron(one, second)).tocsr()
    along_x, along_y = sparse.kron(first, one).tocsr(), sparse.kron(one, first).tocsr()
    walls = sparse.kron(low + high, one) + sparse.kron(one, low + high)
    # vorticity: -∇²ψ inside, -2ψ/h² at a wall with the ψ beside it, and -2/h more at the lid
    lid = np.kron(np.ones(m), np.eye(m)[-1]) * (-2.0 / h)
    of_wall = -2.0 / h**2
    spread = (-laplace @ laplace + walls * of_wall / h**2).tocsr()
    in_x = (-along_x @ laplace + sparse.kron(high - low, one) * of_wall / (2 * h)).tocsr()
    in_y = (-along_y @ laplace + sparse.kron(one, high - low) * of_wall / (2 * h)).tocsr()
    psi = np.zeros(m * m)
    for _ in range(30):
        u, v, wx, wy = along_y @ psi, -along_x @ psi, in_x @ psi, in_y @ psi + lid / (2 * h)
        residual = (spread @ psi + lid / h**2) / reynolds - u * wx - v * wy
        tangent = spread / reynolds - sparse.diags_array(u) @ in_x - sparse.diags_array(wx) @ along_y
        tangent = tangent - sparse.diags_array(v) @ in_y + sparse.diags_array(wy) @ along_x
        change = spsolve(tangent.tocsc(), -residual)
        psi += change
        if np.abs(change).max() < 1e-11:
            break
    whole = np.zeros((n + 1, n + 1))
    whole[1:-1, 1:-1] = psi.reshape(m, m)
    return whole


def profiles(n: int, reynolds: float, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return u on the line x = 0.5 and v on the line y = 0.5."""
    psi, x = stream_function(n, reynolds), np.linspace(0.0, 1.0, n + 1)
    u = CubicSpline(x, psi[n // 2], bc_type=((1, 0.0), (1, 1.0)))(at, 1)
    v = -CubicSpline(x, psi[:, n // 2], bc_type=((1, 0.0), (1, 0.0)))(at, 1)
    return u, v


if __name__ == "__main__":
    fine = np.linspace(0.0, 1.0, 20001)
    for reynolds in (100, 400):
        extremes = []
        for n in (64, 128, 256):
            u, v = profiles(n, reynolds, fine)
            extremes.append(np.array([u.min(), v.max(), v.min()]))
            print(reynolds, n, extremes[-1].round(5))
        print(reynolds, "extrapolated", (extremes[-1] + (extremes[-1] - extremes[-2]) / 3).round(5))
        coarse, finer = profiles(128, reynolds, AT), profiles(256, reynolds, AT)
        columns = [AT, *(b + (b - a) / 3 for a, b in zip(coarse, finer, strict=True))]
        with (GALLERY / f"lid-driven-cavity-{reynolds}.csv").open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["place", "u", "v"])
            writer.writerows([f"{value:.5f}" for value in row] for row in zip(*columns, strict=True))
