"""Lists of grid nodes, and the flags from which they are made."""

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
    """Return the storage index of entry e of a list of nodes, shape (m,), or e itself if the list is empty, which stands for
    all nodes."""
    return node[e] if len(node) > 0 else e
