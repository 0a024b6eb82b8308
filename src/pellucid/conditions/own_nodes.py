"""Supports and prescribed motions of bodies with nodes of their own, such as finite elements."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pellucid.conditions.prescribed import ConstraintWork, Drive
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.support import Support
from pellucid.conditions.walls import nodes_of
from pellucid.grid.momentum import ExternalAction


class OwnDrive(Drive):
    """Nodes that lie where a support is at the start are held by it, those of a motion follow it; none passes a held face.

    The rows of what is prescribed are the supports, the motions, and one for thin axes. On the grid, the nodes about driven
    ones are gripped as those of points are, so that contact finds them as firm as they are.
    """

    def __init__(self, body: Any, motions: Sequence[Motion], outside: ExternalAction, supports: Sequence[Support]) -> None:
        super().__init__(body, motions, outside)
        back = np.argsort(body.arrays["id"])
        position, driven = body.arrays["position"][back], body.arrays["driven"][back]
        numbers, walls = np.zeros((len(position), 3), np.int64), np.zeros((3, 2), np.int64)
        for row, support in enumerate(supports, start=1):
            held = nodes_of(support, body.grid, position)
            numbers[np.ix_(held, np.flatnonzero(support.axes()))] = row
            face = support.face()
            if face is not None and support.axes()[face[0]]:
                walls[face] = row
        for row in range(len(motions)):
            numbers[np.ix_(driven == row + 1, np.flatnonzero(self._axes[row]))] = len(supports) + row + 1
        body.set_prescribed(numbers, len(supports) + len(motions) + 1, walls)
        body.prescribed_velocity[: len(supports)] = [support.velocity for support in supports] or np.zeros((0, 3))
        body.top_speed = self.top_speed
        self._first, self._last = len(supports), len(supports) + len(motions)

    def begin(self, time: float, dt: float) -> None:
        """Forces of the elements, and the motion over a step from `time` [s]."""
        self.body.begin(dt)
        if self.names:
            super().begin(time, dt)
            self.body.prescribed_velocity[self._first : self._last] = self._velocity

    def prescribe_velocities(self) -> None:
        """What contact did to the nodes of the grid that driven ones grip, while these are where they gripped them."""
        if self.names:
            super().prescribe_velocities()

    def prescribe_positions(self) -> None:
        """Own nodes are where their velocities lead."""

    def collect(self) -> ConstraintWork:
        """What the motions did: on the nodes themselves, and through contact on the grid's nodes that they grip."""
        on_nodes = self.body.reactions[self._first : self._last]
        work = float(np.sum(on_nodes * self._velocity))
        if not self.names:
            return ConstraintWork(work, 0.0, {})
        through = super().collect()
        impulses = {name: impulse + own for (name, impulse), own in zip(through.impulses.items(), on_nodes, strict=True)}
        return ConstraintWork(work + through.work, through.loss, impulses)
