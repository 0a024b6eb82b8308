"""A rotating frame: Coriolis and centrifugal forces in a case whose coordinates rotate.

In a frame that rotates with the constant angular velocity Ω about a point c, a velocity v changes by the additional
acceleration -2Ω × v - Ω × (Ω × (x - c)) (Goldstein 1980, Classical Mechanics, section 4-10). The Coriolis force acts along the
mean velocity of a step, so it does no work at any step; with the velocity v and the velocity v* that a node would have without
the frame, the new velocity solves

    v_new + Δt Ω × v_new = v* - Δt Ω × v - Δt Ω × (Ω × (x - c))
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.energy import Channel
from pellucid.findings import Finding, Path, listed
from pellucid.model import Vector, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel, is_alone
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart

if TYPE_CHECKING:  # numba is slow to import
    from pellucid.grid.velocity_field import VelocityField

FRAME_WORK = Channel("rotating_frame_work")


class RotatingFrame(Condition):
    """A frame that rotates with a constant angular velocity: Coriolis and centrifugal forces act on all bodies."""

    angular_velocity: Vector = parameter("rad/s", "angular velocity Ω of the frame")
    centre: Vector = parameter("m", "a point on the axis of rotation", (0.0, 0.0, 0.0))

    def channels(self) -> Sequence[Channel]:
        return (FRAME_WORK,)

    def accelerates(self, axis: int) -> bool:
        return any(rate != 0.0 for other, rate in enumerate(self.angular_velocity) if other != axis)

    @classmethod
    def activate(cls, conditions: Sequence["RotatingFrame"], assembly: Assembly) -> Sequence[StepPart]:
        column = assembly.layout.column(FRAME_WORK) if conditions else 0
        return [FrameForces(frame, actions.field, column) for frame in conditions for actions in assembly.actions]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about bodies with their own nodes, axes in a plane case, and a second rotating frame."""
        yield from parts.no_grid((*path, "angular_velocity"), "the forces of a rotating frame act on nodes of the grid")
        if any(place < path for place, _ in parts.placed(RotatingFrame)):
            yield Finding(path, "a case has only one frame", "remove this [[rotating_frame]]")
        owning = [body.name for body in parts.of(BodyModel) if body.moves and body.owns_nodes(is_alone(body, parts))]
        if owning:
            text = f"the forces act on nodes of the grid, but bodies {listed(owning)} have their own nodes"
            yield Finding(path, text, "use bodies of kind material-points or membrane-points")
        for axis, name in enumerate("xyz"):
            turned = [other for other in range(3) if other != axis and not parts.active_axes[other]]
            if self.angular_velocity[axis] != 0.0 and turned:
                text = f"rotates about {name}, but the grid is one cell thick along {'xyz'[turned[0]]}"
                yield Finding((*path, "angular_velocity"), text, f"set its {name} component to 0")


class FrameForces(StepPart):
    """Applies Coriolis and centrifugal forces to the nodes of a velocity field."""

    def __init__(self, frame: RotatingFrame, field: "VelocityField", column: int) -> None:
        self._field, self._column, turn = field, column, np.array(frame.angular_velocity)
        self.pushed_fields = [field]
        self._turn = np.cross(np.eye(3), turn)  # Ω × v = self._turn @ v
        index, position = field.grid.where()
        order = np.argsort(index)
        self._node = index[order]
        self._outward = -(position[order] - np.array(frame.centre)) @ (self._turn @ self._turn).T

    def act_on_nodes(self, dt: float) -> None:
        nodes, at, turn = self._field.grid.nodes, self._node, dt * self._turn
        new = nodes.velocity[at]
        old = new - nodes.velocity_increment[at]
        wanted = (new - old @ turn.T + dt * self._outward) @ np.linalg.inv(np.eye(3) + turn).T
        self._field.add_impulses(nodes.mass[at, None] * (wanted - new), self._column, node=at)
