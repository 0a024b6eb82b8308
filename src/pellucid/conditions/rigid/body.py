"""Rigid body in a run: the motion follows from the momentum and angular momentum of its points, or is prescribed."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.conditions.driven_points import To
from pellucid.conditions.loads.rigid_load import Push
from pellucid.conditions.rigid.kinematics import (
    RigidState,
    centre_of,
    inertia_of,
    inverse_inertia,
    matrix_of,
    rates_of,
    resultant,
    rotation_between,
    spun,
    turn_freely,
)
from pellucid.conditions.rigid.motions import Leads, RigidMotions, RigidWalls, Wall
from pellucid.conditions.rigid.no_slip import NoSlip
from pellucid.conditions.rigid.nodes import RigidNodes
from pellucid.conditions.walls_of_bodies import ENDLESS, MovedRegion, find_region
from pellucid.energy import CONTACT, GRAVITY, IMPACT, MOTION, SUPPORT, StepWork, total_work
from pellucid.geometry.shapes.rotation import Turn
from pellucid.grid.passes.moving import move_points, moving
from pellucid.grid.points import FIELD_ENERGY
from pellucid.grid.velocity_transfer import Apic
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.parts.capabilities import CarriesRotation
from pellucid.parts.constraint import RigidConstraint, RigidRates, ToolLoads
from pellucid.parts.families import GridBody
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.loads.rigid_spring import RigidSpring
    from pellucid.conditions.prescribed_motion import Motion
    from pellucid.grid.velocity_field import VelocityField


class RigidBody(RigidConstraint):
    """A rigid body: its points have the rigid motion with their total momentum and angular momentum.

    Motions may prescribe components of the rigid motion. Each point counts as a cube of its volume (a square in the plane),
    with the own inertia m a²/6 for the mass m and the edge a; the inertia of a box of whole points is then exact. Arrays of
    the body: `start`, the initial position of each point [m]; `angle`, the rotation of the body since the start [rad];
    `affine`, which contains the angular velocity of the body for each point.
    """

    strains = False

    def __init__(
        self,
        member: AssembledBody,
        assembly: Assembly,
        motions: "Sequence[Motion]",
        springs: "Sequence[RigidSpring]",
        earlier: "Sequence[RigidBody]" = (),
    ) -> None:
        """member: the body; motions: its prescribed motions; springs: springs between the body and anchors; earlier: rigid
        bodies that act on the nodes before this body."""
        self.body, self._thin, self._layout = member.body, member.thin, assembly.layout
        # across a thin axis nothing moves, so that only the turn about it is left
        self._turns = [axis for axis in range(3) if not any(self._thin[other] for other in range(3) if other != axis)]
        points, actions = member.body.on_grid, member.actions
        if isinstance(member.body, GridBody):
            member.body.storage.keep_whole()
        if not isinstance(member.body, CarriesRotation):
            raise ValueError(f"body {member.body.name} is rigid, but its points cannot store a rotation")
        if points is None or actions is None:
            raise ValueError(f"body {member.body.name} is rigid, but has no points on the grid")
        alone = sum(other.actions is actions for other in assembly.bodies.values()) == 1
        transfer = member.body.carry_rotation()
        self._points, self._walls = points, RigidWalls(actions)
        self._target = np.zeros_like(member.body.arrays["position"])
        self._moving = moving(points.mapped.content, To(self._target))
        self.leads = leads = Leads(motions, [axis for axis in range(3) if not self._thin[axis]], self._turns)
        self._led_turns = [axis for axis in self._turns if leads.led[3 + axis]]
        self._free_turns = [axis for axis in self._turns if not leads.led[3 + axis]]
        self.velocity_field: VelocityField | None = member.velocity_field
        before = [other.nodes for other in earlier if other.velocity_field is self.velocity_field]
        # points without affine velocity fields cannot carry the velocity of a shear flow to a node beyond the surface
        no_slip = None if alone or not isinstance(transfer, Apic) else NoSlip(actions.field.grid)
        how = self._walls, alone, transfer.flip, before, no_slip
        self.nodes: RigidNodes = RigidNodes(points, member.body.arrays, actions, *how)
        self._region = None if no_slip is None else find_region(member, actions.field.grid)
        self._dt = self._loss = self.mixing = self.own_energy = 0.0
        self._pushes: list[tuple[Wall, float]] = []
        self._centre, self._velocity, self._turn = np.zeros(3), np.zeros(3), np.zeros(3)
        self._arm = np.zeros((0, 3))  # of the points, from the centre, before they move [m]
        self._begun: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None  # as `state` found them, for `hold_nodes`
        self._pushed: list[tuple[np.ndarray, np.ndarray]] = []
        self._loads: list[Push] = []
        self._kept_loads: list[Push] = []
        self._kept_gravity = 1.0
        self._stiffness = sum((np.array(spring.stiffness) for spring in springs), np.zeros(3))
        self._push_works = np.zeros(assembly.layout.n_columns)
        self._led, self._turned = np.zeros((2, 6))  # impulses of motions: direct, and due to rotation [N s, N m s]
        arrays = member.body.arrays
        arrays["start"], arrays["angle"] = arrays["position"].copy(), np.zeros_like(arrays["position"])
        m, arm = arrays["mass"][:, None], arrays["position"] - centre_of(arrays["mass"][:, None], arrays["position"])
        self.top_speed = leads.top_speed + leads.top_turn * float(np.linalg.norm(arm, axis=1).max())
        """Largest prescribed speed of a point [m/s]."""
        self._own_inertia = float(np.sum(arrays["mass"] * (2.0 * self._widths()) ** 2)) / 6.0  # of the points [kg m²]
        self._tensor = inertia_of(m, arm, self._own_inertia)  # at the start of a step [kg m²]
        inertia = self._tensor[np.ix_(self._turns, self._turns)]
        self._carry(rates_of(m, arm, arrays["velocity"], self._turns)[3:])
        member.body.constrain(self, self.nodes)
        self.swing = sum(spring.swing(float(np.sum(m)), inertia) for spring in springs)
        """Largest oscillation rate of the body on its springs, which the time step must resolve [1/s]."""

    def add_forces(self, place: np.ndarray, force: np.ndarray) -> None:
        """Add forces [N] that act over the coming step at positions `place` [m], shape (m, 3) each."""
        self._pushed.append((place, force))

    def placement(self) -> Turn:
        m, x, start = self.body.arrays["mass"][:, None], self.body.arrays["position"], self.body.arrays["start"]
        before, after = centre_of(m, start), centre_of(m, x)
        return Turn(rotation_between(m, start - before, x - after), before, after)

    def prescribed_rates(self) -> RigidRates:
        rates = self.leads.rates
        return RigidRates(rates[:3], rates[3:], centre_of(self.body.arrays["mass"][:, None], self.body.arrays["position"]))

    def set_velocities(self, moving: bool) -> None:
        velocity, turn, centre = self.prescribed_rates()
        factor = 1.0 if moving else 0.0
        arrays = self.body.arrays
        arrays["velocity"][...] = factor * (velocity + np.cross(turn, arrays["position"] - centre))
        self._carry(factor * turn)

    def shares(self, impulse: np.ndarray) -> tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]]:
        return self.leads.shares(impulse)

    def moves_freely(self) -> bool:
        return not self.leads.is_whole

    def state(self) -> RigidState:
        """Return the state at the start of the step: the centre of mass, the angular velocity, and the velocity change per
        impulse and per angular impulse."""
        self._begun = centre, _, inertia = self._about_centre()
        per_mass = (~self.leads.led[:3] & ~np.array(self._thin)) / float(np.sum(self.body.arrays["mass"]))
        return RigidState(centre, self._turn_rate(), per_mass, inverse_inertia(inertia, self._free_turns))

    def _about_centre(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the centre of mass [m], (3,), the positions of the points relative to it [m], (n, 3), and the inertia
        tensor [kg m²], (3, 3)."""
        m, x = self.body.arrays["mass"][:, None], self.body.arrays["position"]
        centre = centre_of(m, x)
        arm = x - centre
        return centre, arm, inertia_of(m, arm, self._own_inertia)

    def add_load(self, push: Push) -> None:
        """Add a force and a torque on the body over the coming step; push: force, torque and the columns for their work."""
        self._loads.append(push)

    def moved(self) -> np.ndarray:
        """Return the displacement of the centre of mass [m] and the angles [rad] since the start, shape (6,)."""
        arrays = self.body.arrays
        m = arrays["mass"][:, None]
        return np.concatenate([centre_of(m, arrays["position"]) - centre_of(m, arrays["start"]), arrays["angle"][0]])

    def rates(self) -> np.ndarray:
        """Return the velocity of the centre of mass [m/s] and the angular velocity [rad/s], shape (6,)."""
        arrays = self.body.arrays
        return np.concatenate([centre_of(arrays["mass"][:, None], arrays["velocity"]), self._turn_rate()])

    def _turn_rate(self) -> np.ndarray:
        """Return the angular velocity of the body [rad/s], shape (3,)."""
        C = self.body.arrays["affine"][0]
        return np.array([C[7], C[2], C[3]])

    # searches for equilibria

    def seek(self) -> np.ndarray:
        self.leads.seek()
        self._led_turns, self._free_turns = self._turns, []
        return self.leads.sought[:3].copy()

    def displacement(self) -> np.ndarray:
        return self.moved()[:3]

    def displace(self, displacement: np.ndarray) -> None:
        self._target[...] = self.body.arrays["position"] + (displacement - self.displacement())
        move_points(self._moving, 0.0)
        if isinstance(self.body, GridBody):
            self.body.storage.complete("position")
        if (surface := getattr(self.body, "contact_surface", None)) is not None:
            surface.turn(self._centre, np.eye(3), self._centre, 0.0)

    def share_gravity(self, share: float) -> None:
        if self.velocity_field is not None:
            self.velocity_field.share_gravity(share)

    def discard_loads(self) -> None:
        self._loads = []

    def loads(self) -> ToolLoads:
        mass = float(np.sum(self.body.arrays["mass"]))
        forces = {GRAVITY: np.zeros(3) if self.velocity_field is None else mass * self.velocity_field.gravity}
        for push in self._loads:
            forces[push.column] = forces.get(push.column, np.zeros(3)) + push.strength[:3]
        return ToolLoads(forces, self._stiffness)

    def keep_loads(self) -> None:
        field = self.velocity_field
        self._kept_loads, self._kept_gravity = self._loads, 1.0 if field is None else field.gravity_share

    def apply_kept_loads(self) -> None:
        self._loads = list(self._kept_loads)
        self.share_gravity(self._kept_gravity)

    # steps

    def begin(self, time: float, dt: float) -> None:
        """Compute the prescribed displacements and rotations over the step dt [s] that begins at `time` [s]."""
        self._begun = None
        self.leads.begin(time, dt)
        if self.leads.sought.any():
            self.leads.keep_sought(self.moved())
        self.leads.rates *= self.body.load_rate
        self._carry(self.rates()[3:])

    def _carry(self, turn: np.ndarray) -> None:
        """Set the affine velocity fields (gradients of velocity, as in APIC) of the points to the angular velocity `turn`
        [rad/s], shape (3,), and compute the kinetic energy of the rotation of the points about their own centres."""
        self.own_energy = 0.5 * self._own_inertia * float(turn @ turn)
        self.body.arrays["affine"][:, :FIELD_ENERGY] = matrix_of(turn).ravel()

    @property
    def own_spin(self) -> np.ndarray:
        """Sum of the angular momenta of the points about their own centres [N m s], (3,)."""
        return self._own_inertia * self.rates()[3:]

    def hold_nodes(self, dt: float) -> None:
        """Give the nodes to which the body contributes the rigid motion that results from their momentum and the loads, over
        the step dt [s]."""
        self._centre, arm, self._tensor = self._begun or self._about_centre()
        self._dt, self._arm, self._begun = dt, arm, None
        self._motions = motions = RigidMotions(self._thin, self._turns, self.leads, arm)
        self._inertia = motions.of_body(float(np.sum(self.body.arrays["mass"])), self._tensor)
        self._walls.find(self.body.arrays["position"], self._widths(), motions.at(arm), dt)
        old = self.rates()
        touching = [Push(resultant(place - self._centre, force), CONTACT) for place, force in self._pushed]
        pushes, self._pushed, self._loads = [*touching, *self._loads], [], []
        strength = sum((push.strength for push in pushes), np.zeros(6))
        given = dt * motions.momentum_of(strength)
        if self._region is not None:
            self.nodes.region = MovedRegion(self._region, self.placement(), ENDLESS, None)
        new = self.nodes.hold(self._centre, arm, motions, self._inertia, old * motions.sizes, given)
        self._push_works[:] = 0.0
        mean = 0.5 * (old + new / motions.sizes)
        self._push_works[IMPACT] = sum(push.book(self._push_works, dt, mean) for push in pushes)

    def _widths(self) -> np.ndarray:
        """Return half the edges of the cubes that the points represent [m]: one value for all points, or shape (n,)."""
        half, scale, exponent = self._points.half_width()
        return np.full(1, half) if half >= 0.0 else np.asarray(0.5 * (self.body.arrays["volume"] * scale) ** exponent)

    def prescribe_velocities(self) -> None:
        """Set the point velocities V + ω × (x - c), with the velocity V of the centre of mass c, the angular velocity ω and
        the positions x of the points; V and ω follow from the momentum of the body or are prescribed. Walls stop points
        that the nearby nodes do not stop."""
        points, motions, inertia = self.body.arrays, self._motions, self._inertia
        received = self.nodes.receive(motions)
        free = motions.prescribed(inertia, received.momentum)
        kept = self._walls.keep_inside(free, motions.roots(inertia, float(inertia.max())))
        self._pushes, u = kept.impulses, kept.motion
        self._led = np.zeros(6)
        if (led := self.leads.led).any():
            self._led = np.where(led, (inertia @ u - received.momentum - kept.given) * motions.sizes, 0.0)
        lost = 0.5 * float(received.motion @ inertia @ received.motion - u @ inertia @ u)
        self._loss, self.mixing = lost + received.spread, received.mixing
        self._velocity, self._turn = u[:3], u[3:] / motions.sizes[3:]
        points["velocity"][...] = self._velocity + np.cross(self._turn, self._arm)
        self._carry(self._turn)

    def prescribe_positions(self) -> None:
        """Set the positions of the points at the end of the step, and rotate their velocities with the body so that its
        angular momentum is conserved."""
        arrays, leads, inertia = self.body.arrays, self.leads, self._tensor
        spin, given = inertia @ self._turn, np.zeros(3)
        given[self._led_turns] = leads.rates[3:][self._led_turns]

        def velocity_of(rotation: np.ndarray) -> np.ndarray:
            turned, omega = rotation @ inertia @ rotation.T, given.copy()
            omega[self._free_turns] = spun(turned, spin - turned @ given, self._free_turns)
            return omega

        rotation, angle, turn = turn_freely(velocity_of, self._dt)
        r = self._arm @ rotation.T
        moved = self._centre + self._dt * self._velocity
        if (led := leads.led[:3]).any():
            moved[led] = (centre_of(arrays["mass"][:, None], arrays["start"]) + leads.reached[:3])[led]
        arrays["angle"][...] = np.where(leads.led[3:], leads.reached[3:], arrays["angle"][0] + angle)
        self._target[...] = moved + r
        move_points(self._moving, 0.0)
        if (surface := getattr(self.body, "contact_surface", None)) is not None:
            surface.turn(self._centre, rotation, moved, self._dt)
        arrays["velocity"][...] = self._velocity + np.cross(turn, r)
        self._carry(turn)
        if self._led_turns:
            self._turned[3:] = np.where(leads.led[3:], rotation @ inertia @ rotation.T @ turn - spin, 0.0)

    def work(self) -> StepWork:
        """Return the work of the loads over the step, the kinetic energy lost when the velocities are made rigid, and the
        impulses of supports and motions."""
        done = self._layout.no_work()
        done.works[:] = self._push_works  # the field counted them as one of impacts
        done.works[IMPACT] += self._loss
        self.nodes.count(done)
        for wall, push in self._pushes:
            done.reactions[wall.row, wall.axis] += push
            done.works[[SUPPORT, IMPACT]] += push * wall.velocity
        return self._with_motions(done) if self.leads.led.any() else done

    def _with_motions(self, done: StepWork) -> StepWork:
        """Return the record `done` of the step's work with the work and impulses of the prescribed motions added. The
        impulse of the motions on the nodes is subtracted from the external impulses, in which the velocity field has
        included it."""
        on_nodes = np.where(self.leads.led, self.nodes.led_impulse * self._motions.sizes, 0.0)
        done.impulse[:] -= on_nodes[:3]
        given = on_nodes + self._led
        done.works[[MOTION, IMPACT]] += float(given @ self.leads.rates)
        done.works[MOTION] += float(self._turned @ self.leads.rates)
        along, about = self.leads.shares(given + self._turned)
        return done._replace(motions=along, turning=about)


class RigidBodies(StepPart):
    """Active condition of all rigid bodies of a case. The bodies act on the nodes after all other conditions and before
    contact."""

    def __init__(self, bodies: Sequence[RigidBody], n_columns: int) -> None:
        self._bodies, self._columns = bodies, n_columns
        self.pushed_fields = [body.velocity_field for body in bodies if body.velocity_field is not None]

    def begin(self, time: float, dt: float) -> None:
        for body in self._bodies:
            body.begin(time, dt)

    def act_on_nodes(self, dt: float) -> None:
        """Give the nodes around each body its rigid motion over the step dt [s], then store the nodal velocities before
        contact."""
        for body in self._bodies:
            body.hold_nodes(dt)
        for body in self._bodies:
            body.nodes.await_contact()

    def work(self) -> StepWork:
        return total_work([body.work() for body in self._bodies], self._columns)
