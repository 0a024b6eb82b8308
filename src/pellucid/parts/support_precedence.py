"""Precedence of supports that constrain the same node along the same axis.

The result does not depend on the order in which a case lists supports of faces:

1. A support that constrains a face of the grid along its normal has the highest precedence, as nothing passes the face.
2. A region comes next; of several regions, the later one. At the nodes of a face as in 1, a region applies only if it moves
   with the face. Regions may also move nodes of a body away from the face.
3. Of faces parallel to the axis, the slowest support comes first, then the last in the order x-lower, x-upper, ...,
   z-upper.

Of several supports on one face, the one with the earliest end (`until`) comes first.
"""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pellucid.parts.capabilities import NodalSupport


def find_owners(
    supports: "Sequence[NodalSupport]", n_nodes: int, gone: Collection[int] = (), may_leave: bool = False
) -> np.ndarray:
    """Find the support of each node along each axis.

    Parameters
    ----------
    supports : sequence of NodalSupport
        The supports, in the order of the case, each with its nodes, shape (n_nodes,).
    gone : collection of int
        Indices of supports that are no longer active.
    may_leave : bool
        True if regions may move nodes away from a face: for nodes of a body, not for those of the grid.

    Returns
    -------
    ndarray, shape (n_nodes, 3)
        0 for a free node, else 1 + the index of its support.
    """
    owners = np.zeros((n_nodes, 3), np.int64)
    there = [row for row in range(len(supports)) if row not in gone]
    for axis in range(3):
        rows, owner = [row for row in there if supports[row].axes[axis]], owners[:, axis]
        faces = in_order(supports, [row for row in rows if supports[row].face is not None], axis)
        for row in faces:
            owner[supports[row].nodes] = row + 1
        across = [row for row in faces if is_across(supports[row], axis)]
        for row in (row for row in rows if supports[row].face is None):
            nodes = supports[row].nodes.copy()
            for face in across:
                if not _agree(supports[row], supports[face], axis, may_leave):
                    nodes &= ~supports[face].nodes
            owner[nodes] = row + 1
    return owners


def in_order(supports: "Sequence[NodalSupport]", rows: Collection[int], axis: int) -> list[int]:
    """Return the numbers of those supports among `rows` sorted by precedence along an axis (0, 1, 2): the highest comes
    last."""
    return sorted(rows, key=lambda row: _rank(supports[row], axis))


def is_across(support: "NodalSupport", axis: int) -> bool:
    """Return True if a support constrains a face of the grid that is normal to `axis` (0, 1, 2)."""
    return support.face is not None and support.face[0] == axis


def _rank(support: "NodalSupport", axis: int) -> tuple[bool, float, float, tuple[int, int], float]:
    """Return a sort key of a support that constrains a face of the grid; a larger key means a higher precedence along an
    axis (0, 1, 2)."""
    velocity, face = support.velocity[axis], support.face or (0, 0)
    return is_across(support, axis), -support.until, -abs(velocity), face, velocity


def _agree(region: "NodalSupport", face: "NodalSupport", axis: int, may_leave: bool) -> bool:
    """Return True if, at nodes of a face of the grid, a support of a region prescribes the same velocity along an axis
    as the support of the face, or, if `may_leave`, a velocity away from the face."""
    away = region.velocity[axis] - face.velocity[axis]
    inward = -1.0 if face.face is not None and face.face[1] == 1 else 1.0
    return away == 0.0 or (may_leave and away * inward > 0.0)
