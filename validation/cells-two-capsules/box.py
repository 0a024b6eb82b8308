"""Effect of walls and periodic images on two capsules that pass each other: an immersed boundary in a channel without inertia.

    python validation/cells-two-capsules/box.py LENGTH HALF_HEIGHT WIDTH CELL START [REFINEMENTS, 3]

The channel is periodic along the flow (LENGTH) and the vorticity (WIDTH), with walls at y = ±HALF_HEIGHT, all in radii; START
is the distance of the centres along the flow at the start, in diameters. The velocity is a Fourier series along x and z and
central differences along y: with wave numbers k and the force f, (D² - k²)² v = ik D f_k + k² f_y, u_k = i D v/k, and
(D² - k²) u = -f across k. Forces and velocities pass between surface and grid by Peskin's four-point function (2002, Acta
Numerica 11, 479). The surface and its forces are those of crossing.py; a uniform normal velocity keeps its volume. Two boxes
are to be compared at the same CELL: the four-point function spreads the surface over four cells, which changes the result more
than most boxes do. Nothing of the package is used.
"""

import sys
from pathlib import Path

import numpy as np
from crossing import CAPILLARY, INFLATION, OFFSET, PLACES, STEP, centroid
from numba import njit

sys.path.insert(0, str(Path(__file__).parents[1] / "cells-capsule-in-shear"))
from boundary_integrals import areas_of, forces, icosphere, rest_shape

LATEST = 30.0  # time at which capsules that do not pass each other are given up


@njit(cache=True)
def weights(place):
    """First node and the weights of four nodes, of Peskin's function about a place in cells."""
    first, found = int(np.floor(place)) - 1, np.empty(4)
    for k in range(4):
        r = abs(place - first - k)
        if r < 1:
            found[k] = (3 - 2 * r + np.sqrt(1 + 4 * r - 4 * r * r)) / 8
        else:
            found[k] = (5 - 2 * r - np.sqrt(max(0.0, -7 + 12 * r - 4 * r * r))) / 8
    return first, found


@njit(cache=True)
def around(place, shape):
    """Return the indices along x, y and z of the 64 nodes around a place, in cells, and their weights. shape: of the grid
    (3, x, y, z), which is periodic along x and z."""
    (a, wa), (b, wb), (c, wc) = weights(place[0]), weights(place[1]), weights(place[2])
    x, y, z, w = np.empty(64, np.int64), np.empty(64, np.int64), np.empty(64, np.int64), np.empty(64)
    for n in range(64):
        p, q, r = n // 16, n // 4 % 4, n % 4
        x[n], y[n], z[n], w[n] = (a + p) % shape[1], b + q, (c + r) % shape[3], wa[p] * wb[q] * wc[r]
    return x, y, z, w


@njit(cache=True)
def spread(places, forces, grid):
    """Add forces at places, in cells, to a grid (3, x, y, z) that is periodic along x and z."""
    for i in range(len(places)):
        x, y, z, w = around(places[i], grid.shape)
        for n in range(64):
            for k in range(3):
                grid[k, x[n], y[n], z[n]] += w[n] * forces[i, k]


@njit(cache=True)
def gathered(places, grid):
    """Return the values of a grid at places, in cells."""
    found = np.zeros_like(places)
    for i in range(len(places)):
        x, y, z, w = around(places[i], grid.shape)
        for n in range(64):
            for k in range(3):
                found[i, k] += w[n] * grid[k, x[n], y[n], z[n]]
    return found


class Channel:
    """Velocities of a viscous liquid without inertia, due to forces on the nodes of a grid."""

    def __init__(self, length, half_height, width, cell):
        self.cell, self.lower = cell, np.array([-length / 2, -half_height, -width / 2])
        self.cells = tuple(round(side / cell) for side in (length, 2 * half_height, width))
        nx, ny, nz = self.cells
        inner = np.eye(ny - 1)
        ones = [np.diag(np.ones(ny - 1 - k), k) + np.diag(np.ones(ny - 1 - k), -k) for k in (1, 2)]
        second = (ones[0] - 2 * inner) / cell**2
        fourth = (ones[1] - 4 * ones[0] + 6 * inner) / cell**4
        fourth[0, 0] += 1 / cell**4  # no slope at the walls
        fourth[-1, -1] += 1 / cell**4
        kx, kz = 2 * np.pi * np.fft.fftfreq(nx, cell), 2 * np.pi * np.fft.rfftfreq(nz, cell)
        self.k = np.sqrt(kx[:, None] ** 2 + kz**2)
        self.along = np.stack([kx[:, None] + 0 * kz, 0 * kx[:, None] + kz]) / np.where(self.k > 0, self.k, 1)
        squares = self.k[: nx // 2 + 1, :, None, None] ** 2
        self.across = np.linalg.inv(second - squares * inner)
        self.normal = np.linalg.inv(fourth - 2 * squares * second + squares**2 * inner)
        self.mode = np.minimum(np.arange(nx), nx - np.arange(nx))

    def solved(self, inverses, right):
        parts = np.matmul(inverses[self.mode], np.stack([right.real, right.imag], axis=-1))
        return parts[..., 0] + 1j * parts[..., 1]

    def velocity(self, force):
        """force: on unit of volume, at the nodes, shape (3, x, y, z); the result has the same shape."""
        f = np.moveaxis(np.fft.fft(np.fft.rfft(force, axis=3), axis=1), 2, 3)
        ax, az = self.along[0][..., None], self.along[1][..., None]
        fk, fs = ax * f[0] + az * f[2], ax * f[2] - az * f[0]
        k, twice = self.k[..., None], 2 * self.cell
        v = np.zeros_like(f)
        v[1][..., 1:-1] = self.solved(self.normal, 1j * k * (fk[..., 2:] - fk[..., :-2]) / twice + k**2 * f[1][..., 1:-1])
        v[1][0, 0] = 0
        u = 1j * (v[1][..., 2:] - v[1][..., :-2]) / twice / np.where(k > 0, k, 1)
        s = self.solved(self.across, -fs[..., 1:-1])
        v[0][..., 1:-1], v[2][..., 1:-1] = ax * u - az * s, az * u + ax * s
        for axis in (0, 2):
            v[axis][0, 0, 1:-1] = self.across[0, 0] @ -f[axis][0, 0, 1:-1]
        return np.fft.irfft(np.fft.ifft(np.moveaxis(v, 3, 2), axis=1), n=self.cells[2], axis=3)


def course(channel, start, refinements):
    """Return distances of the centres along the flow and across it, in diameters."""
    sphere, T = icosphere(refinements)
    rest = sphere / (1 + INFLATION)
    inverse, area = rest_shape(rest, T), areas_of(rest, T)
    X = sphere + np.array([-start, OFFSET, 0.0])
    nx, ny, nz = channel.cells

    def velocity(X):
        f = forces(X, T, inverse, area, 1 / CAPILLARY) / channel.cell**3
        grid = np.zeros((3, nx, ny + 1, nz))
        spread((X - channel.lower) / channel.cell, f, grid)
        spread((-X - channel.lower) / channel.cell, -f, grid)
        v = gathered((X - channel.lower) / channel.cell, channel.velocity(grid))
        v[:, 0] += X[:, 1]
        normal = np.zeros_like(X)
        for k in range(3):
            np.add.at(normal, T[:, k], np.cross(X[T[:, 1]] - X[T[:, 0]], X[T[:, 2]] - X[T[:, 0]]) / 6)
        unit = normal / np.linalg.norm(normal, axis=1)[:, None]
        return v - (v * normal).sum() / (normal * unit).sum() * unit

    found = []
    while True:
        found.append(centroid(X, T)[0][:2])
        if found[-1][0] > start or len(found) * STEP > LATEST:
            return np.array(found)
        X = X + STEP * velocity(X + STEP / 2 * velocity(X))


def main():
    *box, cell, start = (float(word) for word in sys.argv[1:6])
    along, across = course(Channel(*box, cell), start, int(sys.argv[6]) if len(sys.argv) > 6 else 3).T
    if along[-1] < 0:
        print(f"the capsules do not pass each other: at time {LATEST} their distance is {along[-1]:.3f}, {across[-1]:.3f}")
    else:
        print(*(f"{place}: {np.interp(place, along, across):.4f}" for place in (*PLACES[:-1], start)))


if __name__ == "__main__":
    main()
