"""Rigid bodies: points with the rigid motion of their momentum and angular momentum."""

from collections.abc import Sequence

import numpy as np

from pellucid.conditions import driven_points
from pellucid.conditions.rigid_motions import RigidMotions, RigidWalls, Wall
from pellucid.conditions.rigid_nodes import RigidNodes
from pellucid.energy import CONTACT, IMPACT, SUPPORT, StepWork, total_work
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.assembly import AssembledBody, Assembly


class RigidBodies(ActiveCondition):
    """All rigid bodies of a case. What acts on the nodes has done so before they do, but for contact."""

    def __init__(self, bodies: Sequence["RigidBody"], n_columns: int) -> None:
        self._bodies, self._columns = bodies, n_columns

    def act_on_nodes(self, dt: float) -> None:
        """Let the nodes about each move as it does."""
        for body in self._bodies:
            body.hold_nodes(dt)
        for body in self._bodies:
            body.nodes.await_contact()

    def work(self) -> StepWork:
        """Of all."""
        return total_work([body.work() for body in self._bodies], self._columns)


class RigidBody:
    """A body that moves as a rigid one: its points get the rigid motion with their momentum and angular momentum."""

    strains = False
    top_speed = 0.0  # of what is prescribed [m/s]

    def __init__(self, member: AssembledBody, assembly: Assembly) -> None:
        self.body, self._thin, self._layout = member.body, member.thin, assembly.layout
        # across a thin axis nothing moves, so that only the turn about it is left
        self._turns = [axis for axis in range(3) if not any(self._thin[other] for other in range(3) if other != axis)]
        points, actions = member.body.on_grid, member.actions
        if points is None or actions is None:
            raise ValueError(f"body {member.body.name} is rigid, and has no points on the grid")
        alone = sum(other.actions is actions for other in assembly.bodies.values()) == 1
        self._points, self._walls = points, RigidWalls(actions)
        self.nodes = RigidNodes(points, member.body.arrays, actions, self._walls, alone)
        member.body.constrain(self, self.nodes)
        self._dt = self._loss = 0.0
        self._pushes: list[tuple[Wall, float]] = []
        self._centre, self._velocity, self._spin = np.zeros(3), np.zeros(3), np.zeros(3)
        self._arm = np.zeros((0, 3))  # of the points, from the centre, before they move [m]
        self._pushed: list[tuple[np.ndarray, np.ndarray]] = []
        self._push_work = 0.0

    def add_forces(self, place: np.ndarray, force: np.ndarray) -> None:
        """Forces [N] at places [m], shape (m, 3) each, over the coming step."""
        self._pushed.append((place.copy(), force))

    def hold_nodes(self, dt: float) -> None:
        """Let the nodes that it reaches move as it does over this step dt [s]."""
        m, x = self.body.arrays["mass"][:, None], self.body.arrays["position"]
        self._dt, self._centre = dt, np.sum(m * x, axis=0) / np.sum(m)
        self._arm = x - self._centre
        self._motions = RigidMotions(self._thin, self._turns, self._arm)
        self._at_points = self._motions.at(self._arm)
        self._walls.find(x, self._widths(), self._at_points, dt)
        v = self.body.arrays["velocity"]
        before = np.sum(m * v, axis=0) / np.sum(m)
        self._spin = np.sum(m * np.cross(self._arm, v - before), axis=0)
        old = np.concatenate([before, self._motions.length * self._turn(self._arm)])
        push = sum((dt * self._motions.momentum_of(place - self._centre, force) for place, force in self._pushed), np.zeros(6))
        self._pushed = []
        new = self.nodes.hold(self._arm, self._motions, push)
        self._push_work = float(push @ (0.5 * (old + new)))

    def _widths(self) -> np.ndarray:
        """How far points reach beyond their places [m]."""
        half, scale, exponent = self._points.half_width()
        return np.full(1, half) if half >= 0.0 else np.asarray(0.5 * (self.body.arrays["volume"] * scale) ** exponent)

    def prescribe_velocities(self) -> None:
        """The rigid velocity field V + ω × (x - c) of the points' momentum; walls stop what the nodes beside them let pass."""
        points, r = self.body.arrays, self._arm
        m, v = points["mass"][:, None], points["velocity"]
        self._velocity = np.sum(m * v, axis=0) / np.sum(m)
        self._spin = np.sum(m * np.cross(r, v - self._velocity), axis=0)
        length, mass = self._motions.length, float(np.sum(m))
        free = np.concatenate([self._velocity, length * self._turn(r)])
        roots = self._motions.roots(m * np.ones(3), self._at_points, mass)
        motion, self._pushes = self._walls.keep_inside(free, roots)
        if self._pushes:
            self._velocity, turn = motion[:3], motion[3:] / length
            self._spin = np.sum(m * np.cross(r, np.cross(turn, r)), axis=0)
        rigid = self._velocity + np.cross(self._turn(r), r)
        self._loss = float(0.5 * np.sum(m * (v * v - rigid * rigid)))
        v[...] = rigid

    def prescribe_positions(self) -> None:
        """Positions of the rigid motion. The velocities turn with the body, which keeps its angular momentum."""
        rotation = _rotation(self._dt * self._turn(self._arm))
        r = self._arm @ rotation.T
        moved = self._centre + self._dt * self._velocity
        target = moved + r
        driven_points.move_points_to(self._points.n_slabs, self._points.mapped, target)
        if (surface := getattr(self.body, "contact_surface", None)) is not None:
            surface.turn(self._centre, rotation, moved, self._dt)
        self.body.arrays["velocity"][...] = self._velocity + np.cross(self._turn(r), r)

    def _turn(self, r: np.ndarray) -> np.ndarray:
        """Angular velocity [rad/s] of the spin for points at r from the centre [m]."""
        m = self.body.arrays["mass"][:, None]
        inertia = np.sum(m * r * r) * np.eye(3) - np.einsum("pi,pj->ij", m * r, r)
        turns, omega = self._turns, np.zeros(3)
        # points on a line have no inertia about it: the pseudo-inverse leaves that turn out
        omega[turns] = np.linalg.pinv(inertia[np.ix_(turns, turns)], rcond=1e-10, hermitian=True) @ self._spin[turns]
        return omega

    def work(self) -> StepWork:
        """The kinetic energy of the part of the velocities that is not rigid is lost; what supports give it."""
        done = self._layout.no_work()
        done.works[IMPACT] = self._loss + self._push_work  # the field counted it as one of impacts
        done.works[CONTACT] = self._push_work
        self.nodes.count(done)
        for wall, push in self._pushes:
            done.reactions[wall.row, wall.axis] += push
            done.works[[SUPPORT, IMPACT]] += push * wall.velocity
        return done


def _rotation(angle: np.ndarray) -> np.ndarray:
    """Rotation by a vector of angles [rad] (Rodrigues), shape (3, 3)."""
    size = float(np.linalg.norm(angle))
    if size == 0.0:
        return np.eye(3)
    x, y, z = angle / size
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(size) * cross + (1.0 - np.cos(size)) * cross @ cross
