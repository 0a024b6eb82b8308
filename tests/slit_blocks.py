"""A block of tetrahedra that is cut into two halves at half its height, in a file."""

from itertools import product
from pathlib import Path

import numpy as np

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
SIX = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
"""Tetrahedra of a cube about a diagonal."""


def slit_block(path: Path, size: float, gap: float | None, n: int = 4) -> None:
    """Write a cube with edges `size` [m], n cubes of six tetrahedra along each edge, and a gap between the halves [m], as a
    VTK file.

    If the gap is None, the halves share the nodes between them.
    """
    number: dict[tuple[int, int, int, int], int] = {}
    nodes, cells = [], []
    for i, j, k in product(range(n), repeat=3):
        half = -1 if k < n // 2 else 1
        corners = []
        for a, b, c in CORNERS:
            side = half if k + c == n // 2 and gap is not None else 0
            key = i + a, j + b, k + c, side
            if key not in number:
                number[key] = len(nodes)
                nodes.append(np.array(key[:3]) * size / n + (0.0, 0.0, 0.5 * side * (gap or 0.0)))
            corners.append(number[key])
        cells += [[corners[q] for q in four] for four in SIX]
    lines = ["# vtk DataFile Version 3.0", "block", "ASCII", "DATASET UNSTRUCTURED_GRID", f"POINTS {len(nodes)} double"]
    lines += [" ".join(map(repr, node.tolist())) for node in nodes]
    lines += [f"CELLS {len(cells)} {5 * len(cells)}", *("4 " + " ".join(map(str, cell)) for cell in cells)]
    lines += [f"CELL_TYPES {len(cells)}", *["10"] * len(cells)]
    path.write_text("\n".join(lines) + "\n")
