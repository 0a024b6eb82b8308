"""Passes over nodes of the grid: over all of them, or over those of a list."""

from typing import Annotated, NamedTuple

import numpy as np

from pellucid.grid.nodal_fields import FOUND, OR, RUN, STEP, NodalField
from pellucid.jit import pointwise

CHUNK = 512  # nodes that a thread takes at a time
ALL = np.zeros(0, np.int64)
"""In place of a list: of no nodes there are no chunks, and no pass is made."""


class NodeFlags(NamedTuple):
    """Flags of nodes, 0 or 1, by which lists are made."""

    awaiting: Annotated[np.ndarray, NodalField(1, FOUND, RUN, "", "contact may give impulses in this step", np.uint8)]
    reached: Annotated[np.ndarray, NodalField(1, OR, STEP, "", "the body with its own nodes gives to the node", np.uint8)]


def chunks_of(n: int) -> int:
    """In how many chunks threads take n nodes."""
    return -(-n // CHUNK)


@pointwise
def end_of(chunk, node, n):
    """Number behind the last of a chunk of the listed nodes, of n in all."""
    return min(CHUNK * (chunk + 1), len(node) if len(node) > 0 else n)


@pointwise
def listed(node, e):
    """The node with number e."""
    return node[e] if len(node) > 0 else e
