"""Which support prescribes the velocity of a node along an axis, where several constrain it.

The result does not depend on the order in which a case lists supports of faces:

1. A face of the grid that a support holds across the axis comes first: nothing passes it.
2. A region comes next, and of several regions the later one. At the nodes of such a face it counts only where it moves as the
   face does. Nodes of a body may also be moved away from the face.
3. Of faces along the axis, that of the slowest support comes first, then the last in the order x-lower, x-upper, ..., z-upper.

Of supports on one face, the one that ends first (`until`) comes first.
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
        Rows of supports that constrain nothing any more.
    may_leave : bool
        Whether regions may move nodes away from a face. True for nodes of a body, False for those of the grid.

    Returns
    -------
    ndarray, shape (n_nodes, 3)
        0 where a node is free, else 1 + the row of its support.
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
    """Sort rows of supports of faces so that the one that counts along an axis comes last."""
    return sorted(rows, key=lambda row: _rank(supports[row], axis))


def is_across(support: "NodalSupport", axis: int) -> bool:
    """Return True if a support holds a face of the grid across an axis."""
    return support.face is not None and support.face[0] == axis


def _rank(support: "NodalSupport", axis: int) -> tuple[bool, float, float, tuple[int, int], float]:
    """The larger it is, the more a support of a face counts along an axis."""
    velocity, face = support.velocity[axis], support.face or (0, 0)
    return is_across(support, axis), -support.until, -abs(velocity), face, velocity


def _agree(region: "NodalSupport", face: "NodalSupport", axis: int, may_leave: bool) -> bool:
    """Return True if a region moves its nodes at a face of the grid as the face moves, or off it where it may."""
    away = region.velocity[axis] - face.velocity[axis]
    inward = -1.0 if face.face is not None and face.face[1] == 1 else 1.0
    return away == 0.0 or (may_leave and away * inward > 0.0)
