"""Strip of cells at an opening through which a pressure drives a fluid into the grid.

The nodes of the strip move together along the normal n, with the profile w across the opening, at the mean velocity U that
follows from their momentum:

    U = Σ m_I w_I n·v_I / Σ m_I w_I²,    J_I = m_I (U w_I n - v_I),

where node I has the mass m_I, the velocity v_I before and the impulse J_I. The distance that columns of points have entered
is therefore known, as for a prescribed velocity.
"""

from typing import Annotated, NamedTuple

import numpy as np

from pellucid.conditions.open_faces.given_flow import GivenFlow
from pellucid.conditions.open_faces.outlet_pressure import EndOfFluid
from pellucid.conditions.open_faces.strip import Passage, Strip
from pellucid.grid.nodal_fields import FOUND, RUN, NodalField, allocate
from pellucid.ranks.domain import domain


class StripNodes(NamedTuple):
    """Nodal field of a strip (layer of cells) driven by a pressure, stored with the nodes of its velocity field."""

    impulse: Annotated[np.ndarray, NodalField(3, FOUND, RUN, "N s", "impulse that makes the strip move as one")]


class PushedStrip(Strip):
    """Strip (layer of cells) at an opening with a flow driven by a given pressure."""

    def __init__(self, flow: GivenFlow, passage: Passage, pressure: float, column: int) -> None:
        """flow: data model of the flow; passage: the opening and the body that flows through it; pressure: pressure at the
        opening [Pa]; column: column in the array of works for the work of the pressure and of the strip."""
        super().__init__(flow, passage)
        self._end, self._pressure, self._column = EndOfFluid(passage.member, self._face.name, column), pressure, column
        self._impulse = allocate(StripNodes, self._actions.field.grid.n_nodes).impulse

    def mean_at(self, time: float) -> float:
        """Return the mean velocity through the opening in the current step [m/s], whatever the `time`, since velocities at
        later times are unknown."""
        return self.speed

    def begin(self, time: float, dt: float) -> None:
        """Apply the pressure, changed in time by `rise` or `amplitude`, over a step that begins at `time` [s]."""
        self._end.push(self._flow.share(time) * self._pressure)

    def act(self, dt: float) -> tuple[float, np.ndarray]:
        """Give the nodes of the strip their common motion, after the momentum update. Return zero work [J] and zero impulse
        [N s], shape (3,), since the velocity field records both."""
        nodes, strip, axis = self._actions.field.grid.nodes, self._nodes, self._face.axis
        free = self._free()
        mass, velocity = np.where(free[:, axis], nodes.mass[strip], 0.0), nodes.velocity[strip]
        parts = np.stack([mass * self._share * velocity[:, axis], mass * self._share**2], axis=1)
        momentum, inertia = domain.of_nodes(parts, strip).sum(axis=0).tolist()
        along = momentum / inertia if inertia > 0.0 else 0.0
        self.speed = self._direction * along
        goal = np.zeros_like(velocity)
        goal[:, axis] = along * self._share
        self._impulse[strip] = np.where(free, nodes.mass[strip, None] * (goal - velocity), 0.0)
        self._actions.field.add_impulses(self._impulse, self._column)
        return 0.0, np.zeros(3)
