"""Strip of cells at an opening, whose nodes have a prescribed velocity.

All nodes to which points in the layer of cells at the face contribute have the velocity of the flow along the normal, like
nodes around driven points (`pellucid.grid.nodal_conditions.ExternalAction`). The material in the strip thus has the prescribed
velocity. At its inner side the strip exchanges forces with the rest of the fluid.
"""

from math import ceil, log2

import numpy as np

from pellucid.conditions.open_faces.given_flow import GivenFlow
from pellucid.conditions.open_faces.strip import Passage, Strip
from pellucid.ranks.domain import domain

HEAVY = 1e6
"""Mass that is added to a node to give it the prescribed velocity, as a multiple of the mass of a cell filled with the
fluid: large enough that all material in the strip follows."""


class LedStrip(Strip):
    """Strip (layer of cells) at an opening with a flow of prescribed velocity."""

    def __init__(self, flow: GivenFlow, passage: Passage) -> None:
        """flow: data model of the prescribed flow; passage: the opening and the body that flows through it."""
        super().__init__(flow, passage)
        self._driven, body = self._actions.driven(), passage.member.body
        density = float(np.sum(body.stored_array("mass")) / np.sum(body.volumes()))
        self._mass = 2.0 ** ceil(log2(HEAVY * density * self._actions.field.grid.cell_volume))  # a power of 2: no rounding

    def mean_at(self, time: float) -> float:
        """Return the prescribed mean velocity through the opening at a time [s], in m/s."""
        mean = self._flow.velocity if self._flow.flow_rate is None else self._flow.flow_rate / self.area
        return self._flow.share(time) * (mean or 0.0)

    def begin(self, time: float, dt: float) -> None:
        """Set the velocity of the nodes over a step dt [s] from `time` [s]; it is zero if dt is 0."""
        self.speed = self.mean_at(time) if dt > 0.0 else 0.0
        self._driven.mass[self._nodes] += self._mass
        self._driven.momentum[self._nodes, self._face.axis] += self._mass * self._velocity()

    def _velocity(self) -> np.ndarray:
        return self._direction * self.speed * self._share

    def act(self, dt: float) -> tuple[float, np.ndarray]:
        """Return the work of the flow on the nodes over the step dt [s], in J, and its impulse [N s], shape (3,). Called
        after the momentum update."""
        given = np.where(self._free(), self._mass * self._driven.impulse[self._nodes], 0.0)
        impulse = domain.of_nodes(given, self._nodes)
        return float(impulse[:, self._face.axis] @ self._velocity()), impulse.sum(axis=0)
