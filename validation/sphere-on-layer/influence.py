"""A smooth rigid sphere or cylinder pressed into an elastic layer on a rigid base, by pressures on rings or strips.

    python influence.py            spheres.csv and cylinders.csv
    python influence.py checks     limits with exact solutions, and refinement

Nothing is shared with `src/pellucid/references/solids.py`, which solves Fredholm's equation instead. A wave of pressure
p cos kx on a layer of the thickness h lowers its face by 2 L(kh) p cos(kx)/(E* k), E* = E/(1-nu^2). Here L is found from
Airy's function phi(z) = (A + B z) cosh kz + (C + D z) sinh kz by four conditions at both faces. A ring or a strip of uniform
pressure lowers the face by the integral of that over its waves (Hankel's or Fourier's transform), of which the part of a
half-space, or its logarithm, is known in closed form. Pressures are those at which the faces meet, and none pulls.

The sphere has its true shape, not a parabola; displacements are those of small strains. Lengths are over the radius R, forces
over E* R^2, of a cylinder over E* R on unit of length. Needs scipy.
"""

import csv
import sys
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.special import ellipe, ellipk, j0, j1

RINGS, WAVES = 240, 400
TALL = 1e3


def compliance(kh: float, poisson_ratio: float, bonded: bool) -> float:
    """L: 1 for deep layers, kh times a constant for shallow ones."""
    if kh > 30:
        return 1.0
    nu = poisson_ratio / (1 - poisson_ratio)  # of plane strain

    def rows(z):
        """phi, phi', phi'', phi''' of the four terms, k = 1."""
        c, s = np.cosh(z), np.sinh(z)
        return np.array(
            [
                [c, z * c, s, z * s],
                [s, c + z * s, c, s + z * c],
                [c, 2 * s + z * c, s, 2 * c + z * s],
                [s, 3 * c + z * s, c, 3 * s + z * c],
            ]
        )

    def sinks(z):
        phi = rows(z)
        return phi[3] - (2 + nu) * phi[1]

    base = rows(0.0)
    along = base[2] + nu * base[0] if bonded else base[1]  # no displacement along the base, or no shear
    scale = np.cosh(kh)
    conditions = np.array([sinks(0.0), along, rows(kh)[1] / scale, rows(kh)[0] / scale])
    terms = np.linalg.solve(conditions, [0.0, 0.0, 0.0, 1.0 / scale])
    return float(-sinks(kh) @ terms / 2)


@lru_cache
def waves(thickness: float, poisson_ratio: float, bonded: bool):
    """k, weights, L(kh)."""
    nodes, weights = np.polynomial.legendre.leggauss(WAVES)
    k = 15.0 / thickness * (nodes + 1)
    return k, 15.0 / thickness * weights, np.array([compliance(kh, poisson_ratio, bonded) for kh in k * thickness])


def disc(a, r):
    """Displacement of a half-space at r by the pressure 1 on a disc of radius a, E* = 1 (Johnson 1985, section 3.4)."""
    near, far = np.minimum(r / a, 1.0), np.minimum(a / r, 1.0)
    outside = far < 1.0
    inner = 4 * a / np.pi * ellipe(near**2)
    outer = 4 * r / np.pi * (ellipe(far**2) - (1 - far**2) * ellipk(np.where(outside, far, 0.0) ** 2))
    return np.where(outside, outer, inner)


def of_rings(edges, thickness, poisson_ratio, bonded):
    """Displacements at the middles of rings by unit pressures on each."""
    r = 0.5 * (edges[1:] + edges[:-1])
    discs = np.stack([disc(a, r) if a > 0 else np.zeros_like(r) for a in edges], axis=1)
    k, weight, L = waves(thickness, poisson_ratio, bonded)
    pressed = edges * j1(np.outer(k, edges)) / k[:, None]
    more = 2 * j0(np.outer(r, k)) @ (((L - 1) * weight)[:, None] * np.diff(pressed, axis=1))
    return r, np.pi * np.diff(edges**2), np.diff(discs, axis=1) + more


def of_strips(edges, thickness, poisson_ratio, bonded):
    """The same for pairs of strips at both sides of the middle; 1 - exp(-kh) stands for L in closed form."""
    x = 0.5 * (edges[1:] + edges[:-1])
    h = thickness

    def sums(y):  # the integral of 1/2 ln(1 + h²/y²)
        y = np.where(np.abs(y) < 1e-300, 1e-300, y)
        return 0.5 * y * np.log1p((h / y) ** 2) + h * np.arctan(y / h)

    closed = sums(edges - x[:, None]) + sums(edges + x[:, None])
    k, weight, L = waves(thickness, poisson_ratio, bonded)
    pressed = 2 * np.sin(np.outer(k, edges)) / k[:, None]
    more = np.cos(np.outer(x, k)) @ (((L - 1 + np.exp(-k * h)) / k * weight)[:, None] * np.diff(pressed, axis=1))
    return x, 2 * np.diff(edges), 2 / np.pi * (np.diff(closed, axis=1) + more)


def parabola(r):
    return r**2 / 2


def sphere(r):
    return 1 - np.sqrt(1 - r**2)


def press(influence, depth, layer, shape=sphere, rings=RINGS):
    """Force and radius of contact, on rings twice over: the second time they reach a tenth beyond the contact found first."""
    end = min(1.0, np.sqrt(2 * depth))
    for _ in range(2):
        edges = np.linspace(0.0, end, rings + 1)
        place, area, matrix = influence(edges, *layer)
        wanted = depth - shape(place)
        n = int(np.count_nonzero(wanted > 0))
        pressure = np.linalg.solve(matrix[:n, :n], wanted[:n])
        while pressure[-1] < 0:
            n -= int(np.count_nonzero(pressure < 0))
            pressure = np.linalg.solve(matrix[:n, :n], wanted[:n])
        while n < rings:  # the next one may touch as well
            more = np.linalg.solve(matrix[: n + 1, : n + 1], wanted[: n + 1])
            if more[-1] < 0:
                break
            pressure, n = more, n + 1
        contact = float(edges[n])
        end = min(end, 1.1 * contact)
    return float(pressure @ area[:n]), contact


def of_sphere(contact):
    """Depth and force of a sphere in a half-space (I. N. Sneddon 1965, Int. J. Engng Sci. 3, 47)."""
    log = np.log((1 + contact) / (1 - contact))
    return contact / 2 * log, (1 + contact**2) / 2 * log - contact


def checks():
    print("half-space: contact, force over the exact one, contact over the exact one")
    for contact in (0.1, 0.2, 0.3):
        depth, exact = of_sphere(contact)
        force, found = press(of_rings, depth, (TALL, 0.3, True))
        print("sphere", contact, f"{force / exact:.4f} {found / contact:.4f}")
        force, found = press(of_rings, contact**2, (TALL, 0.3, True), parabola)
        print("parabola", contact, f"{force / (4 / 3 * contact**3):.4f} {found / contact:.4f}")
    print("rings, h = 2, nu = 0.3, bonded, depth 0.1: force")
    for rings in (60, 120, 240):
        print(rings, f"{press(of_rings, 0.1, (2.0, 0.3, True), rings=rings)[0]:.6f}")
    print("layers of 0.02 that slip: depth, force over that of a bed of springs of E*/h, on a sphere and on a cylinder")
    for depth in (0.002, 0.005):
        layer = 0.02, 0.3, False
        bed = np.pi * depth**2 / 0.02, 4 / 3 * np.sqrt(2) * depth**1.5 / 0.02
        found = press(of_rings, depth, layer, parabola, 480)[0], press(of_strips, depth, layer, parabola, 480)[0]
        print(depth, f"{found[0] / bed[0]:.4f} {found[1] / bed[1]:.4f}")
    print("cylinder on a layer of 2: half width, force over Hertz' for that half width, pi E* a^2/4")
    for depth in (0.001, 0.004):
        force, contact = press(of_strips, depth, (2.0, 0.3, False), rings=480)
        print(f"{contact:.4f} {force / (np.pi / 4 * contact**2):.4f}")


def main():
    here = Path(__file__).parent
    for name, influence in (("spheres", of_rings), ("cylinders", of_strips)):
        rows = []
        for bonded in (True, False):
            for poisson_ratio in (0.0, 0.3, 0.45):
                for thickness in (1.0, 2.0, 4.0):
                    for depth in (0.02, 0.05, 0.1):
                        force, a = press(influence, depth, (thickness, poisson_ratio, bonded))
                        kept = (thickness, poisson_ratio, "bonded" if bonded else "slips", depth, f"{force:.6g}", f"{a:.4f}")
                        rows.append(kept)
        with (here / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            columns = ["thickness", "poisson_ratio", "base", "depth", "force", "contact"]
            csv.writer(file, lineterminator="\n").writerows([columns, *rows])


if __name__ == "__main__":
    checks() if sys.argv[1:] == ["checks"] else main()
