"""A rigid body: its points move with their momentum and angular momentum, except where motions prescribe the motion."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.conditions.driven_points import To
from pellucid.conditions.rigid.kinematics import (
    Push,
    RigidState,
    centre_of,
    inertia_of,
    inverse_inertia,
    rates_of,
    resultant,
    rotation_by,
    spin_of,
    spun,
)
from pellucid.conditions.rigid.leads import Leads
from pellucid.conditions.rigid.motions import RigidMotions, RigidWalls, Wall
from pellucid.conditions.rigid.nodes import RigidNodes
from pellucid.energy import CONTACT, IMPACT, MOTION, SUPPORT, StepWork, total_work
from pellucid.grid.passes.moving import move_points, moving
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.parts.capabilities import SpreadsPoints

if TYPE_CHECKING:
    from pellucid.conditions.loads.rigid_spring import RigidSpring
    from pellucid.conditions.prescribed_motion import Motion


class RigidBody:
    """A body that moves as a rigid one: its points get the rigid motion with their momentum and angular momentum.

    Motions may prescribe parts of that motion. The arrays of the body have `start`, the first position of each point [m], and
    `angle`, how far the body has turned since [rad], the same for each.
    """

    strains = False

    def __init__(
        self, member: AssembledBody, assembly: Assembly, motions: "Sequence[Motion]", springs: "Sequence[RigidSpring]"
    ) -> None:
        self.body, self._thin, self._layout = member.body, member.thin, assembly.layout
        # across a thin axis nothing moves, so that only the turn about it is left
        self._turns = [axis for axis in range(3) if not any(self._thin[other] for other in range(3) if other != axis)]
        points, actions = member.body.on_grid, member.actions
        if points is None or actions is None:
            raise ValueError(f"body {member.body.name} is rigid, and has no points on the grid")
        alone = sum(other.actions is actions for other in assembly.bodies.values()) == 1
        if isinstance(member.body, SpreadsPoints):
            member.body.keep_whole()
        self._points, self._walls = points, RigidWalls(actions)
        self._target = np.zeros_like(member.body.arrays["position"])
        self._moving = moving(points.mapped.content, To(self._target))
        self.leads = leads = Leads(motions, [axis for axis in range(3) if not self._thin[axis]], self._turns)
        self.moves_freely = not leads.is_whole
        self._led_turns = [axis for axis in self._turns if leads.led[3 + axis]]
        self._free_turns = [axis for axis in self._turns if not leads.led[3 + axis]]
        self.nodes = RigidNodes(points, member.body.arrays, actions, self._walls, alone)
        member.body.constrain(self, self.nodes)
        self._dt = self._loss = 0.0
        self._pushes: list[tuple[Wall, float]] = []
        self._centre, self._velocity, self._spin = np.zeros(3), np.zeros(3), np.zeros(3)
        self._arm = np.zeros((0, 3))  # of the points, from the centre, before they move [m]
        self._pushed: list[tuple[np.ndarray, np.ndarray]] = []
        self._loads: list[Push] = []
        self._push_works = np.zeros(assembly.layout.n_columns)
        self._led, self._turned = np.zeros((2, 6))  # what leads it gave beside that on the nodes, and as it turned [N s, N m s]
        arrays = member.body.arrays
        arrays["start"], arrays["angle"] = arrays["position"].copy(), np.zeros_like(arrays["position"])
        m, arm = arrays["mass"][:, None], arrays["position"] - centre_of(arrays["mass"][:, None], arrays["position"])
        self.top_speed = leads.top_speed + leads.top_turn * float(np.linalg.norm(arm, axis=1).max())
        """Of what is prescribed [m/s]."""
        inertia = inertia_of(m, arm)[np.ix_(self._turns, self._turns)]
        self.swing = sum(spring.swing(float(np.sum(m)), inertia) for spring in springs)
        """How fast it swings on springs, which its step has to follow [1/s]."""

    def add_forces(self, place: np.ndarray, force: np.ndarray) -> None:
        """Forces [N] at places [m], shape (m, 3) each, over the coming step."""
        self._pushed.append((place.copy(), force))

    def state(self) -> RigidState:
        """Place, orientation and velocities of the body, and its response to forces."""
        m, x = self.body.arrays["mass"][:, None], self.body.arrays["position"]
        centre = centre_of(m, x)
        rates = rates_of(m, x - centre, self.body.arrays["velocity"], self._turns)
        free = ~self.leads.led[:3] & ~np.array(self._thin)
        return RigidState(centre, rates[3:], free / float(np.sum(m)), inverse_inertia(m, x - centre, self._free_turns))

    def add_load(self, push: Push) -> None:
        """A force and a torque over the coming step."""
        self._loads.append(push)

    def moved(self) -> np.ndarray:
        """Displacement of the centre of mass [m] and angles [rad] since the start, shape (6,)."""
        arrays = self.body.arrays
        m = arrays["mass"][:, None]
        return np.concatenate([centre_of(m, arrays["position"]) - centre_of(m, arrays["start"]), arrays["angle"][0]])

    def rates(self) -> np.ndarray:
        """Velocity of the centre of mass [m/s] and angular velocity [rad/s], shape (6,)."""
        m, x, v = (self.body.arrays[name] for name in ("mass", "position", "velocity"))
        return rates_of(m[:, None], x - centre_of(m[:, None], x), v, self._turns)

    def hold_nodes(self, dt: float) -> None:
        """Give the nodes that the body reaches its rigid velocity over this step dt [s]."""
        m, x = self.body.arrays["mass"][:, None], self.body.arrays["position"]
        self._dt, self._centre = dt, centre_of(m, x)
        self._arm = x - self._centre
        self._motions = motions = RigidMotions(self._thin, self._turns, self.leads, self._arm)
        self._at_points = motions.at(self._arm)
        self._walls.find(x, self._widths(), self._at_points, dt)
        old = rates_of(m, self._arm, self.body.arrays["velocity"], self._turns)
        touching = [Push(resultant(place - self._centre, force), CONTACT) for place, force in self._pushed]
        pushes, self._pushed, self._loads = [*touching, *self._loads], [], []
        strength = sum((push.strength for push in pushes), np.zeros(6))
        new = self.nodes.hold(self._arm, motions, dt * motions.momentum_of(strength))
        self._push_works[:] = 0.0
        mean = 0.5 * (old + new / motions.sizes)
        self._push_works[IMPACT] = sum(push.book(self._push_works, dt, mean) for push in pushes)

    def _widths(self) -> np.ndarray:
        """How far points reach beyond their places [m]."""
        half, scale, exponent = self._points.half_width()
        return np.full(1, half) if half >= 0.0 else np.asarray(0.5 * (self.body.arrays["volume"] * scale) ** exponent)

    def prescribe_velocities(self) -> None:
        """Give the points the rigid velocities V + ω × (x - c) of their momentum, or prescribed ones; walls stop points that
        the nodes beside them let pass."""
        points, r, led = self.body.arrays, self._arm, self.leads.led
        m, v = points["mass"][:, None], points["velocity"]
        velocity = np.sum(m * v, axis=0) / np.sum(m)
        self._velocity = np.where(led[:3], self.leads.rates[:3], velocity)
        self._spin = spin = spin_of(m, r, v - velocity)
        mass, sizes = float(np.sum(m)), self._motions.sizes
        free = np.concatenate([self._velocity, self._turn(r)]) * sizes
        roots = self._motions.roots(m * np.ones(3), self._at_points, mass)
        kept = self._walls.keep_inside(free, roots)
        self._pushes = kept.impulses
        if self._pushes:
            self._velocity, turn = kept.motion[:3], kept.motion[3:] / sizes[3:]
            self._spin = spin_of(m, r, np.cross(turn, r))
        turn = self._turn(r)
        rigid = self._velocity + np.cross(turn, r)
        self._led = np.zeros(6)
        if led.any():
            self._spin = spin_of(m, r, np.cross(turn, r))
            gained = np.concatenate([mass * (self._velocity - velocity), self._spin - spin])
            self._led = np.where(led, gained - kept.given * sizes, 0.0)
        self._loss = float(0.5 * np.sum(m * (v * v - rigid * rigid)))
        v[...] = rigid

    def prescribe_positions(self) -> None:
        """Positions of the rigid motion. The velocities turn with the body, which keeps its angular momentum."""
        arrays, leads, turn = self.body.arrays, self.leads, self._turn(self._arm)
        rotation = rotation_by(self._dt * turn)
        r = self._arm @ rotation.T
        moved = self._centre + self._dt * self._velocity
        if (led := leads.led[:3]).any():
            moved[led] = (centre_of(arrays["mass"][:, None], arrays["start"]) + leads.reached[:3])[led]
        arrays["angle"][...] = np.where(leads.led[3:], leads.reached[3:], arrays["angle"][0] + self._dt * turn)
        self._target[...] = moved + r
        move_points(self._moving, 0.0)
        if (surface := getattr(self.body, "contact_surface", None)) is not None:
            surface.turn(self._centre, rotation, moved, self._dt)
        turn = self._turn(r)
        arrays["velocity"][...] = self._velocity + np.cross(turn, r)
        if self._led_turns:
            spin = spin_of(arrays["mass"][:, None], r, np.cross(turn, r))
            self._turned[3:] = np.where(leads.led[3:], spin - self._spin, 0.0)

    def _turn(self, r: np.ndarray) -> np.ndarray:
        """Angular velocity [rad/s], prescribed or of the spin, for points at r from the centre [m]."""
        m, led, free = self.body.arrays["mass"][:, None], self._led_turns, self._free_turns
        inertia = inertia_of(m, r)
        omega = np.zeros(3)
        omega[led] = self.leads.rates[3:][led]
        omega[free] = spun(inertia, self._spin - inertia @ omega, free)
        return omega

    def work(self) -> StepWork:
        """Work of the step: the kinetic energy lost with velocities that are not rigid, and what supports give the body."""
        done = self._layout.no_work()
        done.works[:] = self._push_works  # the field counted them as one of impacts
        done.works[IMPACT] += self._loss
        self.nodes.count(done)
        for wall, push in self._pushes:
            done.reactions[wall.row, wall.axis] += push
            done.works[[SUPPORT, IMPACT]] += push * wall.velocity
        return self._with_motions(done) if self.leads.led.any() else done

    def _with_motions(self, done: StepWork) -> StepWork:
        """The work with that of the motions; the velocity field has counted their impulse on the nodes as external."""
        on_nodes = np.where(self.leads.led, self.nodes.led_impulse * self._motions.sizes, 0.0)
        done.impulse[:] -= on_nodes[:3]
        given = on_nodes + self._led
        done.works[[MOTION, IMPACT]] += float(given @ self.leads.rates)
        done.works[MOTION] += float(self._turned @ self.leads.rates)
        along, about = self.leads.shares(given + self._turned)
        return done._replace(motions=along, turning=about)


class RigidBodies(ActiveCondition):
    """All rigid bodies of a case. They act on the nodes after all other conditions, and before contact."""

    def __init__(self, bodies: Sequence[RigidBody], n_columns: int) -> None:
        self._bodies, self._columns = bodies, n_columns

    def begin(self, time: float, dt: float) -> None:
        """Set the prescribed motion of each body over the step."""
        for body in self._bodies:
            body.leads.begin(time, dt)

    def act_on_nodes(self, dt: float) -> None:
        """Give the nodes about each body its rigid velocity."""
        for body in self._bodies:
            body.hold_nodes(dt)
        for body in self._bodies:
            body.nodes.await_contact()

    def work(self) -> StepWork:
        """The work of all rigid bodies together."""
        return total_work([body.work() for body in self._bodies], self._columns)
