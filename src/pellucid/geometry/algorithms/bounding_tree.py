"""A tree of oriented boxes about triangles, and the pairs of edges and triangles that may meet.

Each box lies along the principal axes of its triangles (Gottschalk, Lin & Manocha 1996, SIGGRAPH, 171), so boxes about long
facets are as thin as these, whatever their direction. Boxes are halved by the centres of the triangles; those of one level are
tested at once.
"""

from collections.abc import Iterator

import numpy as np

LEAF = 4  # triangles in a box of the last level, at most
EDGES_AT_ONCE = 20_000
PAIRS_AT_ONCE = 200_000  # of an edge and a box; bounds the memory


class BoundingTree:
    """Boxes about m triangles with corners [m], shape (m, 3, 3).

    slack: distance [m] by which boxes are wider than their triangles; vertices: numbers of the corners, shape (m, 3).
    """

    def __init__(self, corners: np.ndarray, vertices: np.ndarray, slack: float) -> None:
        m = len(corners)
        depth = max(int(np.ceil(np.log2(m / LEAF))), 0)
        self._order = np.arange(m)
        self._bounds = np.arange(2**depth + 1) * m // 2**depth
        self._levels: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = []
        centred = corners - corners.mean(axis=(0, 1))
        first, second = centred.sum(axis=1), np.einsum("mki,mkj->mij", centred, centred)
        for level in range(depth + 1):
            bounds = np.arange(2**level + 1) * m // 2**level
            start, count = bounds[:-1], np.diff(bounds)
            order, own = self._order, np.repeat(np.arange(2**level), np.diff(bounds))
            mean = np.add.reduceat(first[order], start) / (3 * count)[:, None]
            spread = np.add.reduceat(second[order], start) / (3 * count)[:, None, None] - mean[:, :, None] * mean[:, None, :]
            axes = np.linalg.eigh(spread)[1].transpose(0, 2, 1)  # in rows
            local = np.einsum("mij,mkj->mki", axes[own], corners[order])
            low, high = np.minimum.reduceat(local.min(axis=1), start), np.maximum.reduceat(local.max(axis=1), start)
            shared = vertices[order][start]  # vertices that all triangles of a box have, -1 without
            has = (vertices[order][:, None, :] == shared[own][:, :, None]).any(axis=2)
            shared = np.where(np.logical_and.reduceat(has, start), shared, -1)
            self._levels.append((axes, 0.5 * (low + high), 0.5 * (high - low) + slack, shared))
            centre = local.mean(axis=1)
            wide = np.maximum.reduceat(centre, start) - np.minimum.reduceat(centre, start)
            along = wide.argmax(axis=1)[own]
            self._order = order[np.lexsort((centre[np.arange(m), along], own))]
        # triangles of the last level are halved no more, so their order within a box does not matter

    def near(self, edges: np.ndarray, start: np.ndarray, end: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield numbers of edges and of triangles near them, shape (p,) each, for some of the edges at once.

        edges: numbers of the vertices at the ends, shape (n, 2); triangles that share one with an edge may be left out. start,
        end: their places [m], shape (n, 3).
        """
        middle, half = 0.5 * (start + end), 0.5 * (end - start)
        last = len(self._levels) - 1
        for lower in range(0, len(edges), EDGES_AT_ONCE):
            some = np.arange(lower, min(lower + EDGES_AT_ONCE, len(edges)))
            waiting = [(0, some, np.zeros(len(some), np.int64))]
            found, n_found = list[tuple[np.ndarray, np.ndarray]](), 0
            while waiting:
                level, e, box = waiting.pop()
                if len(e) > PAIRS_AT_ONCE:
                    parts = range(0, len(e), PAIRS_AT_ONCE)
                    waiting += [(level, e[k : k + PAIRS_AT_ONCE], box[k : k + PAIRS_AT_ONCE]) for k in reversed(parts)]
                    continue
                meets = _meets(self._levels[level], edges[e], middle[e], half[e], box)
                e, box = e[meets], box[meets]
                if level < last:
                    waiting.append((level + 1, np.repeat(e, 2), (2 * box[:, None] + np.arange(2)).ravel()))
                    continue
                count = self._bounds[box + 1] - self._bounds[box]
                place = np.repeat(self._bounds[box] - np.cumsum(count) + count, count) + np.arange(count.sum())
                found.append((np.repeat(e, count), self._order[place]))
                n_found += len(place)
                if n_found > PAIRS_AT_ONCE or not waiting:
                    yield np.concatenate([one for one, _ in found]), np.concatenate([other for _, other in found])
                    found, n_found = [], 0


def _meets(
    level: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    edges: np.ndarray,
    middle: np.ndarray,
    half: np.ndarray,
    box: np.ndarray,
) -> np.ndarray:
    """Return which edges may meet a triangle of their boxes: those that no plane along a side of the box or along the edge
    separates from it, and that have no vertex in common with all of its triangles."""
    axes, centre, size, shared = (some[box] for some in level)
    away = np.einsum("nij,nj->ni", axes, middle) - centre
    along = np.einsum("nij,nj->ni", axes, half)
    reach = np.abs(along)
    meets = (np.abs(away) <= size + reach).all(axis=1)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        across = np.abs(away[:, i] * along[:, j] - away[:, j] * along[:, i])
        meets &= across <= (size[:, i] * reach[:, j] + size[:, j] * reach[:, i]) * (1.0 + 1e-12)
    return meets & (edges[:, :, None] != shared[:, None, :]).all(axis=(1, 2))
