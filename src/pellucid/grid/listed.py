"""Lists of grid nodes, and nodal flags from which such lists are made."""

from typing import Annotated, NamedTuple

import numpy as np

from pellucid.grid.nodal_fields import FOUND, OR, RUN, STEP, NodalField
from pellucid.jit import pointwise


class NodeFlags(NamedTuple):
    """Nodal flags, 0 or 1: nodes that may receive contact impulses, and nodes to which a body with its own nodes
    contributes."""

    awaiting: Annotated[
        np.ndarray, NodalField(1, FOUND, RUN, "", "1 if contact may exert an impulse on the node in this step", np.uint8)
    ]
    reached: Annotated[
        np.ndarray, NodalField(1, OR, STEP, "", "1 if the body with its own nodes contributes to the node", np.uint8)
    ]


@pointwise
def listed(node, e):
    """Return the storage index of entry e of a list of nodes, shape (m,). An empty list stands for all nodes: the index is
    then e."""
    return node[e] if len(node) > 0 else e
