"""Write the belt of basics/belt-on-drum: a strip of triangles that lies on a quarter of a drum, straight before and after it.

    python strip.py ../../src/pellucid/gallery/basics/belt-on-drum.obj [--across 4] [--size 0.005]

The mid-surface has half of the belt's thickness between it and the drum. Needs numpy.
"""

import argparse

import numpy as np

RADIUS, STRAIGHT, WIDTH = 0.1005, 0.15, 0.04  # of the mid-surface on the drum, of each straight part, of the belt [m]


def middle_line(size: float) -> np.ndarray:
    """Return points (x, z) along the belt, from the end that is pulled over the drum to the end that hangs [m]."""
    along = np.linspace(0.0, STRAIGHT, round(STRAIGHT / size) + 1)
    angle = np.linspace(0.0, 0.5 * np.pi, round(0.5 * np.pi * RADIUS / size) + 1)
    pulled = np.column_stack([along - STRAIGHT, np.full(len(along), RADIUS)])
    arc = RADIUS * np.column_stack([np.sin(angle), np.cos(angle)])
    hanging = np.column_stack([np.full(len(along), RADIUS), -along])
    return np.concatenate([pulled, arc[1:], hanging[1:]])


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("path")
    parser.add_argument("--across", type=int, default=4)
    parser.add_argument("--size", type=float, default=0.005)
    chosen = parser.parse_args()
    line, across = middle_line(chosen.size), np.linspace(0.0, WIDTH, chosen.across + 1)
    n = len(across)
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, z in line for y in across]
    for i in range(len(line) - 1):
        for j in range(n - 1):
            a, b, c, d = (number + 1 for number in (i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1))
            halves = ((a, c, b), (a, d, c)) if (i + j) % 2 == 0 else ((a, d, b), (b, d, c))
            lines += [f"f {p} {q} {r}" for p, q, r in halves]
    with open(chosen.path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
