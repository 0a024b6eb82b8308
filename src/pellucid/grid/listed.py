"""Passes over nodes of the grid: over all of them, or over those of a list."""

import numpy as np

from pellucid.jit import pointwise

CHUNK = 512  # nodes that a thread takes at a time
ALL = np.zeros(0, np.int64)
"""In place of a list: of no nodes there are no chunks, and no pass is made."""


def chunks_of(n: int) -> int:
    """In how many chunks threads take n nodes."""
    return -(-n // CHUNK)


@pointwise
def end_of(chunk, node, mass):
    """Number behind the last of a chunk of the listed nodes; mass: of all nodes."""
    return min(CHUNK * (chunk + 1), len(node) if len(node) > 0 else len(mass))


@pointwise
def listed(node, e):
    """The node with number e."""
    return node[e] if len(node) > 0 else e
