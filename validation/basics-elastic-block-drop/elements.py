"""A cube of soft tissue bounces on a rigid floor: trilinear bricks, central differences, lumped masses. Writes elements.csv.

python elements.py [along ...]: a quarter of the cube of `bounce.py`, ν = 0.3. Eight points a brick; the floor stops a node
where it would pass, without a penalty. Nothing here is shared with the package.
"""

import csv
import sys
from itertools import product
from pathlib import Path

import numpy as np

DENSITY, MODULUS, POISSON, SPEED, EDGE = 1000.0, 1e5, 0.3, 0.1, 0.1
COURANT, LASTING = 0.5, 0.03
CORNERS = list(product((0, 1), repeat=3))


def gradients(h):
    """Of the functions of a brick of edge h at its eight points: shape (8 points, 8 corners, 3)."""
    rows = []
    for xi in product((-(3**-0.5), 3**-0.5), repeat=3):
        one = np.array([[(1 + (2 * c - 1) * x) / 2 for c, x in zip(corner, xi, strict=True)] for corner in CORNERS])
        slope = np.array([[(2 * c - 1) / h for c in corner] for corner in CORNERS])
        rows.append([[slope[a, d] * np.prod(np.delete(one[a], d)) for d in range(3)] for a in range(8)])
    return np.array(rows)


def stress(F):
    """First Piola-Kirchhoff stress of the neo-Hookean solid μ/2 (I₁-3) - μ ln J + λ/2 (ln J)², shape (n, 3, 3)."""
    mu = MODULUS / (2 * (1 + POISSON))
    lam = MODULUS * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    back = np.linalg.inv(F).transpose(0, 2, 1)
    return mu * (F - back) + lam * np.log(np.linalg.det(F))[:, None, None] * back


def bounce(along):
    """Velocity of the centre of mass after the bounce over that before; times from 5 % lost [ms], until it turns and parts."""
    h = EDGE / along
    counts = (along // 2, along // 2, along)
    number = np.arange(np.prod([n + 1 for n in counts])).reshape([n + 1 for n in counts])
    bricks = np.stack(
        [number[tuple(slice(c, c + n) for c, n in zip(corner, counts, strict=True))].ravel() for corner in CORNERS]
    )
    X = h * np.stack(np.meshgrid(*[np.arange(n + 1) for n in counts], indexing="ij"), axis=-1).reshape(-1, 3)
    mass = np.bincount(bricks.ravel(), minlength=len(X)) * DENSITY * h**3 / 8
    B, weight = gradients(h), h**3 / 8
    wave = np.sqrt(MODULUS * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON)) / DENSITY)
    dt, u, v = COURANT * h / wave, np.zeros_like(X), np.tile((0.0, 0.0, -SPEED), (len(X), 1))
    times, speeds = [0.0], [-SPEED]
    while times[-1] < LASTING:
        corner, pull = u[bricks], np.zeros((8, bricks.shape[1], 3))
        for b in B:
            F = np.einsum("aei,aj->eij", corner, b) + np.eye(3)
            pull -= weight * np.einsum("eij,aj->aei", stress(F), b)
        for d in range(3):
            v[:, d] += dt * np.bincount(bricks.ravel(), weights=pull[..., d].ravel(), minlength=len(X)) / mass
        v[X[:, 0] == 0.0, 0] = v[X[:, 1] == 0.0, 1] = 0.0
        height = X[:, 2] + u[:, 2]
        v[:, 2] = np.maximum(v[:, 2], -height / dt)
        u += dt * v
        times.append(times[-1] + dt)
        speeds.append(float(mass @ v[:, 2] / mass.sum()))
    t, s = np.array(times), np.array(speeds)

    def crossing(level):
        k = int(np.argmax(s > level))
        return t[k - 1] + (t[k] - t[k - 1]) * (level - s[k - 1]) / (s[k] - s[k - 1])

    touch, turn, leave = crossing(-0.95 * SPEED), crossing(0.0), crossing(0.95 * s[-1])
    return s[-1] / SPEED, 1e3 * (turn - touch), 1e3 * (leave - touch)


def main(chosen):
    rows = []
    for along in chosen:
        rows.append([along, *(f"{number:.4g}" for number in bounce(along))])
        print(*rows[-1], flush=True)
    with open(Path(__file__).with_name("elements.csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([("along", "rebound", "turn_ms", "contact_ms"), *rows])


if __name__ == "__main__":
    main([int(argument) for argument in sys.argv[1:]] or [8, 16, 32, 48])
