"""Changes of the deformation of a capsule in a shear flow by the walls and periodic images of a box.

    python validation/cells-capsule-in-shear/walls_and_images.py [CAPILLARY, .3] [X,Y,Z ...]

X,Y,Z: periods along the flow (x) and the vorticity (z), and distance of the walls (y), in radii.

Far away a capsule acts as the dipole D_ij = Σ f_i x_j of the forces f of its surface. Images and walls add to the flow near it
u_k = G_klij D_ij x_l, where G is the velocity gradient in the middle of the box by the force density -D_ij ∂_j δ, less that in
unbounded liquid. δ is spread to a Gaussian of the width `WIDTH`, which changes G by a few per cent. G is found by Fourier
series along x and z and Chebyshev collocation along y. `boundary_integrals.py` does the rest. Moments of higher order are left
out, so that the changes are good for large boxes only: they decrease with the fifth power of the distance, D with the third.
Nothing of the package is used.
"""

import sys

import boundary_integrals as integrals
import numpy as np

WIDTH = 0.6
NODES = 56  # intervals across the box; even, so that there is a node in the middle
BOXES = ((6, 8, 5), (10, 12, 9))
END = 3.0


def chebyshev(n):
    """Matrix of derivatives and nodes from 1 to -1 (Trefethen 2000, Spectral Methods in MATLAB, chapter 6)."""
    k = np.arange(n + 1)
    x, c = np.cos(np.pi * k / n), np.where((k == 0) | (k == n), 2.0, 1.0) * (-1.0) ** k
    D = np.outer(c, 1 / c) / (x[:, None] - x + np.eye(n + 1))
    return D - np.diag(D.sum(axis=1)), x


def added_gradient(x, y, z):
    """G for μ = 1, shape (3, 3, 3, 3)."""
    D, nodes = chebyshev(NODES)
    D, nodes, N, unit = 2 * D / y, y / 2 * nodes, NODES + 1, np.eye(NODES + 1)
    across = np.exp(-(nodes**2) / (2 * WIDTH**2)) / (np.sqrt(2 * np.pi) * WIDTH)
    slope, middle, largest = -nodes / WIDTH**2 * across, NODES // 2, 6.5 / WIDTH
    G = np.zeros((3, 3, 3, 3))
    for a in range(int(largest * x / (2 * np.pi)) + 1):
        last = int(largest * z / (2 * np.pi))
        for b in range(-last, last + 1):
            kx, kz = 2 * np.pi * a / x, 2 * np.pi * b / z
            gradient, laplacian = (1j * kx * unit, D, 1j * kz * unit), D @ D - (kx**2 + kz**2) * unit
            A, right = np.zeros((4 * N, 4 * N), complex), np.zeros((4 * N, 9), complex)
            for c in range(3):  # -Δu + ∇p = force, ∇·u = 0
                own = slice(c * N, (c + 1) * N)
                A[own, own], A[own, 3 * N :], A[3 * N :, own] = -laplacian, gradient[c], gradient[c]
                for j, source in enumerate((1j * kx * across, slope, 1j * kz * across)):
                    right[own, 3 * c + j] = -source
                for wall in (c * N, (c + 1) * N - 1):
                    A[wall], right[wall] = 0, 0
                    A[wall, wall] = 1
            found = np.linalg.lstsq(A, right, rcond=1e-12)[0]  # the mean of the pressure is free
            weight = (1 if a == 0 else 2) * np.exp(-(kx**2 + kz**2) * WIDTH**2 / 2) / (x * z)
            for k in range(3):
                u = found[k * N : (k + 1) * N]
                for m, derivative in enumerate((1j * kx * u[middle], D[middle] @ u, 1j * kz * u[middle])):
                    G[k, m] += weight * derivative.real.reshape(3, 3)
    unit = np.eye(3)
    pairs = [np.einsum(indices, unit, unit) for indices in ("ij,kl->klij", "ik,jl->klij", "il,jk->klij")]
    unbounded = (pairs[1] / 3 - sum(pairs) / 15) / ((2 * np.pi) ** 1.5 * WIDTH**3)
    return G - unbounded


def course(G, capillary, refinements):
    """Deformations every `boundary_integrals.EVERY`."""
    step = integrals.EVERY / np.ceil(integrals.EVERY / min(0.0125, 0.16 * capillary / 2 ** (refinements - 3)))
    X, T = integrals.icosphere(refinements)
    inverse, area, rules = integrals.rest_shape(X, T), integrals.areas_of(X, T), integrals.rules()

    def velocity(X):
        share = np.zeros(len(X))
        for k in range(3):
            np.add.at(share, T[:, k], integrals.areas_of(X, T) / 3)
        f = integrals.forces(X, T, inverse, area, 1 / capillary)
        v = integrals.induced(X, T, f / share[:, None], *rules) + X @ np.einsum("klij,ij->lk", G, f.T @ X)
        v[:, 0] += X[:, 1]
        return v

    found, steps = [0.0], round(integrals.EVERY / step)
    for number in range(1, round(END / step) + 1):
        v = velocity(X)
        X = X + step / 2 * (v + velocity(X + step * v))
        if number % steps == 0:
            found.append(integrals.deformation(X, T))
    return np.array(found)


def main():
    capillary = float(sys.argv[1]) if len(sys.argv) > 1 else 0.3
    boxes = [tuple(map(float, box.split(","))) for box in sys.argv[2:]] or BOXES
    times = [round(time / integrals.EVERY) for time in (1.0, 1.5, 2.0, 2.5, 3.0)]
    for box, G in (("unbounded", np.zeros((3, 3, 3, 3))), *((box, added_gradient(*box)) for box in boxes)):
        coarse, fine = (course(G, capillary, refinements) for refinements in (2, 3))
        print(box, ((4 * fine - coarse) / 3)[times].round(4), flush=True)


if __name__ == "__main__":
    main()
