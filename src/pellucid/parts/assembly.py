"""The assembled bodies of a run, through which conditions access them when they are activated."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from pellucid.energy import WorkLayout, channel_of_load
from pellucid.errors import RunStopped, UnknownName
from pellucid.findings import absent
from pellucid.geometry.region import EVERY_AXIS, Selectable
from pellucid.geometry.shapes.contract import ActiveAxes
from pellucid.grid.actions import NodalActions
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import HasMesh, TakesExternalForces
from pellucid.users.users_code import file_of

Capability = TypeVar("Capability")
NO_AXES, NO_PERIODS = (False, False, False), (0.0, 0.0, 0.0)


class AssembledBody(NamedTuple):
    """A body in an `Assembly`, which conditions access: the built body, its model, and the actions on the nodes of its
    velocity field."""

    body: Body  # as built
    model: BodyModel  # as defined in the case
    actions: NodalActions | None  # on the nodes of its velocity field; None if the case has no grid

    @property
    def velocity_field(self) -> VelocityField | None:
        """Velocity field of the grid to which the body belongs, alone or with other bodies; None if the case has no grid."""
        return self.actions.field if self.actions else None

    @property
    def thin(self) -> tuple[bool, bool, bool]:
        """Axes along which the grid is one cell thick: True for these."""
        return self.actions.field.grid.thin if self.actions else NO_AXES

    @property
    def active_axes(self) -> ActiveAxes:
        """Axes along which the grid is more than one cell thick: True for these."""
        return self.actions.field.grid.active_axes if self.actions else EVERY_AXIS

    def offers(self, capability: type[Capability]) -> Capability:
        """Return the body of this entry, typed as having a capability (a class of `pellucid.parts.capabilities`). Raises
        ValueError if the body lacks the capability, which an error of the case should have reported before the run."""
        if not isinstance(self.body, capability):
            raise ValueError(f"body {self.body.name} lacks the capability `{capability.__name__}`; its model must report this")
        return self.body

    def selectable(self) -> Selectable:
        """Return the nodes and faces of the body from which regions in a case select, in storage order at the start."""
        return self._selectable(np.arange(len(self.body.stored_array("id"))))

    def selectable_by_number(self) -> Selectable:
        """Return the nodes and faces of the body from which regions in a case select, in the order of the point numbers."""
        return self._selectable(np.argsort(self.body.stored_array("id")))

    def _selectable(self, order: np.ndarray) -> Selectable:
        """Return the nodes and faces of the body from which regions in a case select; order: storage indices of the points in
        the required order."""
        body = self.body
        place = np.argsort(body.stored_array("id")[order])  # index by point number
        faces, position = place[body.cells().surface()], body.stored_array("position")[order]
        periods = self.actions.field.grid.periods if self.actions else NO_PERIODS
        start = self.model.selectable() if body.is_surface else None
        named = start.sets if start is not None else body.node_sets() if isinstance(body, HasMesh) else {}
        sets = {name: place[nodes] for name, nodes in named.items()}
        if body.is_surface:
            return Selectable.of_membrane(position, faces, sets)._replace(periods=periods)
        return Selectable(position, faces, np.unique(faces), sets, periods)


def of_class(kind: type) -> str:
    """Return the name of a class and the file that defines it, for messages about its code."""
    return f"`{kind.__name__}` ({file_of(kind)})"


class Assembly(NamedTuple):
    """The bodies of a run, actions on nodes and order of the works, which conditions access when they are activated."""

    bodies: Mapping[str, AssembledBody]  # by name
    actions: Sequence[NodalActions]  # actions on the nodes of each velocity field
    layout: WorkLayout  # columns of the work channels in a row of works
    active: type = object  # class of the conditions that are being activated, for messages
    finds_equilibria: bool = False  # True if the run finds equilibria with a factored stiffness

    def forces_on(self, body: str, channel: str) -> Callable[[np.ndarray], None]:
        """Return a function that adds external forces [N], shape (n, 3), in storage order, to the points of a body over a
        step. The function raises RunStopped, with the class of the condition, for an array of another shape.

        body: name of the body; channel: name of the entry of the energy balance that receives the work of the forces.
        Raises ValueError if no forces can act on the body, UnknownName if `Condition.load_channel` of no condition in the
        case returns the channel.
        """
        takes, column = self.bodies[body].offers(TakesExternalForces), self.load_column(body, channel)
        points, source = self.bodies[body].body, of_class(self.active)

        def add(force: np.ndarray) -> None:
            shape, wanted = getattr(force, "shape", None), (points.n_points, 3)
            if shape != wanted or force.dtype.kind not in "fiu":
                given = f"{type(force).__name__}" if shape is None else f"an array of {force.dtype} of shape {shape}"
                raise RunStopped(
                    f"{source} adds forces to body {body} as {given}; an array of numbers of shape {wanted} is required, with "
                    "one row for each point, in storage order",
                    body=body,
                )
            takes.add_external_force(force, column)

        return add

    def load_column(self, body: str, channel: str) -> int:
        """Register external forces on the body with this name, and return the column for `add_external_force` and similar
        methods of the body: the place of their channel (entry of the energy balance) in arrays of works. Raises UnknownName
        if `Condition.load_channel` of no condition in the case returns the channel."""
        if channel_of_load(channel) not in self.layout.loads:
            text = f"{of_class(self.active)}: no condition returns this channel from `load_channel`:"
            raise UnknownName(absent(text, channel, [load.name for load in self.layout.loads]))
        actions = self.bodies[body].actions
        if actions:
            actions.take_loads()
        return self.layout.column(channel_of_load(channel))
