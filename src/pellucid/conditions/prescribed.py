"""Prescribed motions and rigid bodies at work: what they do to the points of a body."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pellucid.conditions import driven_points as driving
from pellucid.conditions.prescribed_motion import Motion
from pellucid.errors import CaseError, Problem
from pellucid.grid.momentum import ExternalAction
from pellucid.grid.sorting import MOST_SLABS
from pellucid.jit.bundle import Bundle
from pellucid.reductions import ordered_sum


class ConstraintWork(NamedTuple):
    """What constraints on points did over a step."""

    work: float  # [J]
    loss: float  # part of it that is lost in inelastic impact [J]
    impulses: dict[str, np.ndarray]  # by the name of the motion, shape (3,), what the nodes took included [N s]


class Drive:
    """The prescribed motions of one body.

    The body's points carry `driven`, the number of their motion plus one or 0, and `start`, their first position [m].
    """

    def __init__(self, body: Any, motions: Sequence[Motion], outside: ExternalAction) -> None:
        self.body = body
        self.names = [motion.name for motion in motions]
        self._functions = [motion.functions() for motion in motions]
        self.top_speed = max((motion.top_speed() for motion in motions), default=0.0)
        self._outside = Bundle(outside)
        self._velocity, self._displacement = np.zeros((len(motions), 3)), np.zeros((len(motions), 3))
        self._axes = np.zeros((len(motions), 3), np.int64)
        self._impulse = np.zeros((MOST_SLABS, len(motions), 3))
        self._energy = np.zeros((MOST_SLABS, 2))
        for number, functions in enumerate(self._functions):
            self._axes[number, list(functions)] = 1
        body.arrays["driven"], body.arrays["start"] = self._marked(body, motions), body.arrays["position"].copy()
        self._bundle: Bundle | None = None
        # a body that is driven as a whole along every axis is rigid: what the nodes about it do does not strain it
        everywhere = self._axes[:, ~np.array(body.grid.thin)].all() and (body.arrays["driven"] > 0).all()
        self.strains = not everywhere

    @staticmethod
    def _marked(body: Any, motions: Sequence[Motion]) -> np.ndarray:
        position = body.arrays["position"]
        driven = np.zeros(len(position), np.int64)
        x, y, z = (not thin for thin in body.grid.thin)
        for number, motion in enumerate(motions, start=1):
            inside = (
                np.ones(len(position), bool) if motion.part is None else motion.part.geometry().contains(position, (x, y, z))
            )
            if not inside.any():
                text, remedy = "no point of the body lies in this shape at the start", "make it larger or move it"
                raise CaseError(Problem(text, f"motion.{motion.name}.part", remedy=remedy))
            if driven[inside].any():
                other = motions[int(driven[inside].max()) - 1].name
                text = f"some points of body {body.name} already follow the motion {other}"
                raise CaseError(Problem(text, f"motion.{motion.name}.part", remedy="let the parts of a body not overlap"))
            driven[inside] = number
        return driven

    def _bound(self) -> Bundle:
        """The arrays as kernels take them; a checkpoint replaces those of the body."""
        driven, start = self.body.arrays["driven"], self.body.arrays["start"]
        if self._bundle is None or self._bundle.content[0] is not driven:
            self._bundle = Bundle(driven, start, self._velocity, self._displacement, self._axes, self._impulse, self._energy)
        return self._bundle

    def begin(self, time: float, dt: float) -> None:
        """The motion over a step from `time` [s]: mean velocities, which lead exactly to the displacements at its end."""
        for number, functions in enumerate(self._functions):
            for axis, function in functions.items():
                self._displacement[number, axis] = function(time + dt)
                self._velocity[number, axis] = (self._displacement[number, axis] - function(time)) / dt
        driving.constrain_nodes(self.body.n_slabs, self.body.mapped, self._bound(), self._outside)

    def prescribe_velocities(self) -> None:
        """Prescribed velocities."""
        driving.prescribe_velocities(self.body.n_slabs, self.body.mapped, self._bound(), self._outside)

    def prescribe_positions(self) -> None:
        """Prescribed positions."""
        driving.prescribe_positions(self.body.n_slabs, self.body.mapped, self._bound())

    def collect(self) -> ConstraintWork:
        """What this took."""
        n = self.body.n_slabs
        impulse = ordered_sum(self._impulse[:n].reshape(n, -1)).reshape(-1, 3)
        work, loss = ordered_sum(self._energy[:n])
        return ConstraintWork(float(work), float(loss), dict(zip(self.names, impulse, strict=True)))


class Rigid:
    """A body that moves as a rigid one: its points keep the motion that has their momentum and their angular momentum."""

    strains = False
    top_speed = 0.0  # of what is prescribed [m/s]

    def __init__(self, body: Any) -> None:
        self.body = body
        self._dt = self._loss = 0.0
        self._centre, self._velocity, self._spin = np.zeros(3), np.zeros(3), np.zeros(3)
        self._arm = np.zeros((0, 3))  # of the points, from the centre, before they move [m]

    def begin(self, time: float, dt: float) -> None:
        """Nothing is prescribed."""
        self._dt = dt

    def prescribe_velocities(self) -> None:
        """The rigid velocity field V + ω × (x - c) of the points' momentum."""
        points = self.body.points
        m, x, v = points.mass[:, None], points.position, points.velocity
        self._centre, self._velocity = np.sum(m * x, axis=0) / np.sum(m), np.sum(m * v, axis=0) / np.sum(m)
        self._arm = r = x - self._centre
        self._spin = np.sum(m * np.cross(r, v - self._velocity), axis=0)
        rigid = self._velocity + np.cross(self._turn(r), r)
        self._loss = float(0.5 * np.sum(m * (v * v - rigid * rigid)))
        v[...] = rigid

    def prescribe_positions(self) -> None:
        """Places of the rigid motion. The velocities turn with the body, which keeps its angular momentum."""
        points = self.body.points
        r = self._arm @ _rotation(self._dt * self._turn(self._arm)).T
        driving.move_points_to(self.body.n_slabs, self.body.mapped, self._centre + self._dt * self._velocity + r)
        points.velocity[...] = self._velocity + np.cross(self._turn(r), r)

    def _turn(self, r: np.ndarray) -> np.ndarray:
        """Angular velocity [rad/s] of the spin for points at r from the centre [m]."""
        m = self.body.points.mass[:, None]
        inertia = np.sum(m * r * r) * np.eye(3) - np.einsum("pi,pj->ij", m * r, r)
        thin = self.body.grid.thin  # across a thin axis nothing moves, so that only the turn about it is left
        turns = [axis for axis in range(3) if not any(thin[other] for other in range(3) if other != axis)]
        omega = np.zeros(3)  # points on a line have no inertia about it: the pseudo-inverse leaves that turn out
        omega[turns] = np.linalg.pinv(inertia[np.ix_(turns, turns)], rcond=1e-10, hermitian=True) @ self._spin[turns]
        return omega

    def collect(self) -> ConstraintWork:
        """The energy of what was not a rigid motion is lost."""
        return ConstraintWork(0.0, self._loss, {})


def _rotation(angle: np.ndarray) -> np.ndarray:
    """Rotation by a vector of angles [rad] (Rodrigues), shape (3, 3)."""
    size = float(np.linalg.norm(angle))
    if size == 0.0:
        return np.eye(3)
    x, y, z = angle / size
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(size) * cross + (1.0 - np.cos(size)) * cross @ cross
