"""A block with a horizontal slit from one of its ends, as a closed surface of triangles in a file."""

from pathlib import Path

import numpy as np


def forked_block(path: Path, lower: tuple[float, ...], size: tuple[float, ...], slit: float, depth: float) -> None:
    """Write the surface of a block to a Wavefront file. The slit, of a given width and a depth along x [m], lies at half
    the height along z."""
    (length, width, height), half = size, 0.5 * slit
    low, high = 0.5 * height - half, 0.5 * height + half
    outline = [(0, 0), (length, 0), (length, height), (0, height), (0, high), (depth, high), (depth, low), (0, low)]
    sides = [(0, 1, 6), (0, 6, 7), (1, 2, 5), (1, 5, 6), (2, 3, 4), (2, 4, 5)]
    n = len(outline)
    vertices = np.array([(x, y, z) for y in (0.0, width) for x, z in outline]) + lower
    triangles = [(a, b, c) for a, b, c in sides] + [(c + n, b + n, a + n) for a, b, c in sides]
    for i in range(n):
        j = (i + 1) % n
        triangles += [(j, i, i + n), (j, i + n, j + n)]
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    path.write_text("\n".join(lines) + "\n")
