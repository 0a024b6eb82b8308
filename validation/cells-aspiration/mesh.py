"""The quarter disc of cells/aspiration: a rounded square of quadrilaterals about the middle, rings about that.

    python validation/cells-aspiration/mesh.py > src/pellucid/gallery/cells/aspiration.obj

Rings that pass the mouth lie closer there; beyond, each is wider than the one within by an eighth.
"""

import numpy as np

ACROSS = 8  # quadrilaterals along each edge of the square, half as many as round the quarter
SQUARE, RIM = 0.5, 10.0  # radii
PASSING = 2.6  # initial radius of what comes to the mouth
FACE = -0.083  # height of the plane
CORNER = 0.8  # corner of the square in the middle, of its radius
ROUNDING = (0.55, 0.75, 0.9, 1.0)  # how round the edge of the square and the rings about it are


def radii():
    found = [SQUARE]
    while found[-1] < PASSING:
        found.append(found[-1] + min(0.08, 0.11 / found[-1]))
    step = found[-1] - found[-2]
    while found[-1] < RIM:
        step *= 1.125
        found.append(found[-1] + step)
    return [*found[:-1], RIM]


def on_ring(share, roundness):
    """Place at a share of the quarter on a ring of radius 1, between a square and a circle."""
    angle = 0.5 * np.pi * share
    circle = np.array([np.cos(angle), np.sin(angle)])
    square = CORNER * np.array([1.0, 2 * share] if share <= 0.5 else [2 - 2 * share, 1.0])
    return (1 - roundness) * square + roundness * circle


def main():
    nodes, quads, core = [], [], {}
    for i in range(ACROSS + 1):
        for j in range(ACROSS + 1):
            ring = max(i, j)
            share = 0.0 if ring == 0 else (j / ring / 2 if i == ring else 1 - i / ring / 2)
            core[i, j] = len(nodes)
            nodes.append(SQUARE * ring / ACROSS * on_ring(share, ROUNDING[0] * ring / ACROSS))
    for i in range(ACROSS):
        quads += [(core[i, j], core[i + 1, j], core[i + 1, j + 1], core[i, j + 1]) for j in range(ACROSS)]
    edge = [core[ACROSS, j] for j in range(ACROSS + 1)] + [core[i, ACROSS] for i in range(ACROSS - 1, -1, -1)]
    for number, radius in enumerate(radii()[1:], start=1):
        roundness = ROUNDING[min(number, len(ROUNDING) - 1)]
        ring = list(range(len(nodes), len(nodes) + len(edge)))
        nodes += [radius * on_ring(k / (2 * ACROSS), roundness) for k in range(len(edge))]
        quads += [(edge[k], ring[k], ring[k + 1], edge[k + 1]) for k in range(len(edge) - 1)]
        edge = ring
    for x, y in np.where(np.abs(nodes) < 1e-12, 0.0, nodes):
        print(f"v {x:.8g} {y:.8g} {FACE:g}")
    for quad in quads:
        print("f", *(corner + 1 for corner in quad))


if __name__ == "__main__":
    main()
