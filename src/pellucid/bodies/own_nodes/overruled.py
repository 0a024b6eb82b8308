"""Supports that are overruled by prescribed motions: if both prescribe a node along an axis, the motion applies."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pellucid.findings import listed
from pellucid.parts.capabilities import NodalSupport

ALIKE = 1e-6  # relative difference of velocities that counts as round-off


class Overruled(NamedTuple):
    """A support and a motion that prescribe the same nodes along some axes."""

    support: NodalSupport  # overruled by the motion
    motion: int  # index of the motion
    nodes: int  # number of nodes that both prescribe
    axes: tuple[int, ...]  # axes along which both prescribe these nodes

    def differ(self, velocity: np.ndarray) -> list[str]:
        """Return the names of the axes along which motion and support prescribe different velocities. velocity: velocities of
        all motions [m/s], shape (motions, 3).
        """
        pairs = ((axis, self.support.velocity[axis], float(velocity[self.motion, axis])) for axis in self.axes)
        return ["xyz"[axis] for axis, one, other in pairs if abs(one - other) > ALIKE * max(abs(one), abs(other))]


def overruled(supports: Sequence[NodalSupport], numbers: np.ndarray, axes: np.ndarray) -> list[Overruled]:
    """Return all pairs of a support and a prescribed motion that overrules it, since both prescribe a node along an axis.

    numbers: 1 + the number of the motion that each node follows, 0 for none, shape (n,); axes: 1 if a motion prescribes the
    velocity along the axis, shape (motions, 3).
    """
    found = []
    for motion, along in enumerate(axes):
        driven = numbers == motion + 1
        for support in supports:
            both = tuple(axis for axis in range(3) if along[axis] and support.axes[axis])
            nodes = int((support.nodes & driven).sum())
            if nodes and both:
                found.append(Overruled(support, motion, nodes, both))
    return found


def warning(pair: Overruled, motion: str, body: str, velocity: np.ndarray) -> str | None:
    """Return a warning if a support and a motion (`pair`) prescribe different velocities for the same nodes; None otherwise.
    motion, body: names of the motion and of the body; velocity: velocities of all motions [m/s], shape (motions, 3).
    """
    axes = pair.differ(velocity)
    if not axes:
        return None
    nodes = "1 node" if pair.nodes == 1 else f"{pair.nodes} nodes"
    return (
        f"{pair.support.label} and motion `{motion}` prescribe different velocities along {listed(axes)} at {nodes} of body "
        f"{body}: the motion is used there; choose regions that do not overlap, or constrain other directions"
    )
