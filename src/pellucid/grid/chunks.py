"""Division of grid nodes into chunks, each processed by one thread: all nodes, or the nodes of a list."""

from typing import NamedTuple

import numpy as np

from pellucid.jit import kernel, pointwise

CHUNK = 512  # largest number of nodes in a chunk
ALL = np.zeros(0, np.int64)
"""Used instead of a list for "all nodes". An empty list has no chunks and causes no pass, so the two cannot be confused."""


class ChunkedNodes(NamedTuple):
    """Grid nodes in chunks (ranges of nodes). One thread processes a chunk; the sums of the chunks are added in order."""

    node: np.ndarray  # (m,) indices of listed nodes; empty (`ALL`) for all nodes of the grid
    edges: np.ndarray  # (chunks + 1,) place in the list of the first node of each chunk, and the end of the last

    @property
    def n(self) -> int:
        """Number of chunks (ranges of grid nodes, each processed by one thread)."""
        return len(self.edges) - 1


class NodesByRow(NamedTuple):
    """Grid nodes in chunks, each within one row of slabs (a range of grid layers, see `pellucid.grid.points.Slabs`). A process
    computes whole rows of slabs, and therefore whole chunks."""

    chunks: ChunkedNodes  # all chunks, in the order of the rows
    of_row: np.ndarray  # (rows + 1,) first chunk of each row of slabs, and the end of the last


def chunked(node: np.ndarray) -> ChunkedNodes:
    """Divide a list of nodes, shape (m,), into chunks for loops that compute no sums. Such chunks may extend over several
    rows of slabs (blocks of grid cells)."""
    return ChunkedNodes(node, np.minimum(CHUNK * np.arange(chunks_of(len(node)) + 1), len(node)))


def by_row(rows: np.ndarray, node: np.ndarray = ALL, most: int = CHUNK) -> NodesByRow:
    """Divide all nodes, or a sorted list of nodes, shape (m,), into chunks that each lie within one row of slabs (blocks of
    grid cells).

    rows, shape (rows + 1,): the first node of each row of slabs, and the end of the last row; most: largest number of nodes
    in a chunk.
    """
    of_row, n = np.empty(len(rows), np.int64), rows[-1] if node is ALL else len(node)
    edges = np.empty(len(rows) + n // most + 1, np.int64)
    return NodesByRow(ChunkedNodes(node, edges[: 1 + _divide(rows, node, node is ALL, most, edges, of_row)]), of_row)


@kernel()
def _divide(rows, node, is_all, most, edges, of_row):
    """Divide grid nodes into chunks: fill `edges` with the start of each chunk and the end of the last, and `of_row` with
    the first chunk of each row of slabs (blocks of grid cells) and the end; return the number of chunks.

    is_all: True to divide all nodes instead of the list `node`; rows, node, most: see `by_row`.
    """
    chunks = end = 0
    edges[0] = of_row[0] = 0
    for row in range(len(rows) - 1):
        first = end
        if is_all:
            end = rows[row + 1]
        while not is_all and end < len(node) and node[end] < rows[row + 1]:
            end += 1
        pieces = (end - first + most - 1) // most
        for piece in range(pieces):
            edges[chunks + piece + 1] = first + (end - first) * (piece + 1) // pieces
        chunks += pieces
        of_row[row + 1] = chunks
    return chunks


def chunks_of(n: int) -> int:
    """Return the number of chunks of at most CHUNK nodes into which n nodes are divided."""
    return -(-n // CHUNK)


@pointwise
def listed(node, e):
    """Return the storage index of entry e of a list of nodes, shape (m,). An empty list stands for all nodes: the index is
    then e."""
    return node[e] if len(node) > 0 else e
