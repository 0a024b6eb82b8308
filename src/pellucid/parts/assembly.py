"""The bodies of a case as conditions find them when a run is assembled."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from pellucid.energy import WorkLayout, channel_of_load
from pellucid.geometry.region import Selectable
from pellucid.geometry.shapes.contract import ActiveAxes
from pellucid.grid.actions import NodalActions
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import HasMesh, TakesExternalForces

Capability = TypeVar("Capability")
NO_AXES, NO_PERIODS = (False, False, False), (0.0, 0.0, 0.0)


class AssembledBody(NamedTuple):
    """A body that is built, its model, and the actions on the nodes of its velocity field; a case without a grid has none."""

    body: Body
    model: BodyModel
    actions: NodalActions | None

    @property
    def velocity_field(self) -> VelocityField | None:
        """The nodes of the grid that it shares with others, or where it meets them."""
        return self.actions.field if self.actions else None

    @property
    def thin(self) -> tuple[bool, bool, bool]:
        """Which axes are one cell thick."""
        return self.actions.field.grid.thin if self.actions else NO_AXES

    @property
    def active_axes(self) -> ActiveAxes:
        """The other axes, along which shapes have an extent."""
        x, y, z = self.thin
        return not x, not y, not z

    def offers(self, capability: type[Capability]) -> Capability:
        """The body as one that offers a capability. Raises ValueError where it does not: its model lets such a case pass."""
        if not isinstance(self.body, capability):
            raise ValueError(f"body {self.body.name} offers no `{capability.__name__}`, and its model does not say so")
        return self.body

    def selectable(self) -> Selectable:
        """What regions of conditions choose from, in the order in which the points are stored: asked for at the start."""
        return self._selectable(np.arange(len(self.body.stored_array("id"))))

    def selectable_by_number(self) -> Selectable:
        """The same in the order of the numbers of the points."""
        return self._selectable(np.argsort(self.body.stored_array("id")))

    def _selectable(self, order: np.ndarray) -> Selectable:
        """order: of the points as they are stored."""
        body = self.body
        place = np.argsort(body.stored_array("id")[order])  # from a point's number
        faces, position = place[body.cells().surface()], body.stored_array("position")[order]
        periods = self.actions.field.grid.periods if self.actions else NO_PERIODS
        start = self.model.selectable() if body.is_surface else None
        named = start.sets if start is not None else body.node_sets if isinstance(body, HasMesh) else {}
        sets = {name: place[nodes] for name, nodes in named.items()}
        if body.is_surface:
            return Selectable.of_membrane(position, faces, sets)._replace(periods=periods)
        return Selectable(position, faces, np.unique(faces), sets, periods)


class Assembly(NamedTuple):
    """What conditions ask of a run when they are activated."""

    bodies: Mapping[str, AssembledBody]  # by name
    actions: Sequence[NodalActions]  # of every velocity field
    layout: WorkLayout  # the columns of their channels

    def forces_on(self, body: str, channel: str) -> Callable[[np.ndarray], None]:
        """Ask for external forces on a body: what adds forces [N], shape (n, 3), in the order in which its points are stored,
        over a step."""
        takes, column = self.bodies[body].offers(TakesExternalForces), self.load_column(body, channel)
        return lambda force: takes.add_external_force(force, column)

    def load_column(self, body: str, channel: str) -> int:
        """Ask for external forces on a body: the column of their channel, for its `add_external_force` and the like."""
        actions = self.bodies[body].actions
        if actions:
            actions.take_loads()
        return self.layout.column(channel_of_load(channel))
