"""Nodes around a rigid body: they move with the body, and stop it where walls and other bodies stop them.

The mass of a node is a small part of the mass of the body. If the nodes were free, a stopped node would stop only this
part, and under a lasting load the body would sink in. Therefore the nodes that the body reaches take the rigid motion u =
(V, ω) with their total momentum, before contact and with every contact impulse:

    min ½ Σ_I φ_I m_I |R_I u - v_I|² + ½ (u - u°)·E (u - u°),  while no point of the body passes a wall ,

where R_I u = V + ω × (x_I - c) is the rigid velocity at the node, c the centre of mass, and u° the motion at the start of
the step. The points of the body transfer their rotation to the nodes as an affine field, so that they give the node the
mass m°_I with the velocity R_I u°. As for driven points, a node follows completely if the body gives it at least the
fraction FULL_DRIVE_FRACTION of its mass, φ_I = min(1, share/FULL_DRIVE_FRACTION).

Position of the surface: where other bodies share the nodes, only nodes at most half a cell outside the surface move with
the body. The shape functions of its points reach up to 1.5 cells farther, and a fluid would meet the body there. The other
nodes, called outer nodes, have φ_I = 0 and keep the velocity of the other bodies; forces on the share m°_I of their mass
act on the body, Q = Σ m°_I R_Iᵀ Δv_I.

No slip on the surface itself, with APIC (`pellucid.conditions.rigid.no_slip`): the other bodies at an inner node have the
velocity R_I u + δ_I. The node gets the momentum m°_I δ_I at the start of the step, and loses it when the velocities return
to the points of the body. Outer nodes follow R_I u + δ_I along the surface, with φ_I as above; their motion along the
normal stays free. Where an earlier rigid body also reaches the node, δ is zero. MUSL maps the momentum again and would mix
both velocities of a node: the nodes that the body shares strain the points with the velocities that moved them.

Momentum and angular momentum: the impulses J_I = φ_I m_I (R_I u - v_I) act on the body where they act on the node, with the
lever arm x_I - c. The inertia Σ m°_I R_Iᵀ R_I of the inner nodes differs from the inertia K of the body: shape functions
distribute the mass of a point, and outer nodes have a part of the mass. E = K - Σ m°_I R_Iᵀ R_I corrects for this, so that

    Σ R_Iᵀ J_I + E (u - u°) = Q + impulses on the body as a whole ,    K (u' - u°) = Σ m°_I R_Iᵀ (v_I - R_I u°) + E (u - u°) .

The second equation gives the motion u' of the body from the inner nodes at the end of the step. The other bodies at a node
get m_I v_I minus the body's part: their increments are relative to the velocity that they alone gave the node. The energy
lost by the impulses is that of an impact without rebound.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Annotated, NamedTuple

import numpy as np

from pellucid.conditions.rigid.motions import SMALL, RigidMotions, RigidWalls, inertia_at
from pellucid.conditions.rigid.no_slip import NoSlip
from pellucid.conditions.wall_surface import find_distances
from pellucid.contact.contact_body import ContactBody
from pellucid.energy import IMPACT, SUPPORT, StepWork
from pellucid.geometry.shapes.contract import Space
from pellucid.grid.actions import NodalActions
from pellucid.grid.clearing import Clearing
from pellucid.grid.nodal_conditions import FULL_DRIVE_FRACTION, MASS_EPS, free_axes
from pellucid.grid.nodal_fields import STEP, SUM, NodalField, allocate, with_memory
from pellucid.grid.transfer import scatter_numbers, scatter_vectors
from pellucid.ranks.domain import domain

HOLD = 1e6  # weight of clamped nodes within the grid, relative to the mass of all nodes
SURFACE_WITHIN = 2.0  # cells from a node within which its surface is looked for
ROUNDING = 1e-13  # relative to the momentum of the nodes
LEAST_SHARE = 0.01  # smallest fraction of inertia: of other bodies at an outer node; of the body, with E and supports
LEAST_OTHERS = 1e-6  # smallest fraction of a node's mass for which the velocity of other bodies is known
FILLED_HALF_A_CELL_OUTSIDE = {"trilinear": 1 / 8, "gimp": 1 / 8, "quadratic-bspline": 1 / 6, "cubic-bspline": 77 / 384}
"""Fraction of the volume of a node filled by a body with a plane face half a cell away, for each kind of shape functions."""


class BodySums(NamedTuple):
    """Nodal sums over the points of a rigid body, stored with the nodes of its velocity field."""

    body_moment: Annotated[
        np.ndarray,
        NodalField(3, SUM, STEP, "kg m", "mass moment of a rigid body's points about its centre of mass, on periodic grids"),
    ]
    body_mass: Annotated[
        np.ndarray, NodalField(3, SUM, STEP, "kg", "x: mass of the rigid body's points, if the field has other bodies")
    ]


class Received(NamedTuple):
    """Momentum and energy that a rigid body receives from the nodes at the end of a step; vectors have the six components
    of a rigid motion, see `RigidMotions`."""

    momentum: np.ndarray  # (6,) momentum of the body, including its momentum at the start of the step
    motion: np.ndarray  # (6,) motion with this momentum if no component were prescribed
    mixing: float  # kinetic energy lost in the transfer from nodes shared by several bodies [J]
    spread: float  # other losses of kinetic energy: inertia correction, light nodes whose velocity changes fast [J]


class RigidNodes:
    """Nodes of a velocity field to which the points of a rigid body contribute.

    body: the body on the grid; arrays: arrays of the body; actions: external actions on the nodes of the field; walls:
    walls that stop the body; alone: True if no other body is in its velocity field; flip: weight of FLIP in the update of
    point velocities; earlier: the nodes of bodies in the field that act before this body in a step; no_slip: computes the
    fluid velocities near the surface, None if points of the field have no affine velocity fields.
    """

    def __init__(
        self,
        body: ContactBody,
        arrays: Mapping[str, np.ndarray],
        actions: NodalActions,
        walls: RigidWalls,
        alone: bool,
        flip: float,
        earlier: "Sequence[RigidNodes]",
        no_slip: NoSlip | None,
    ) -> None:
        self._earlier = earlier
        self._body, self._arrays, self._actions, self._walls, self._alone = body, arrays, actions, walls, alone
        self._field, self._nodes, self._flip = actions.field, actions.field.grid.nodes, flip
        grid = self._field.grid
        self._periods = np.array(grid.periods) * grid.periodic
        wanted = ("body_moment",) * any(grid.periodic) + ("body_mass",) * (not alone)
        self._density = float(np.sum(arrays["mass"]) / np.sum(arrays["volume"]))
        self._sums = with_memory(allocate(BodySums, 0), grid.n_nodes, *wanted)
        self._no_slip = no_slip
        self._clear = Clearing(STEP, grid.rows, self._sums)
        self.region: Space | None = None
        """Region that the body fills in this step, which defines its surface; None if only its points are known."""
        self.led_impulse = np.zeros(6)
        """Sum of the impulses on the nodes, in the six components of a rigid motion, without those of forces and walls.
        In prescribed components, the prescribed motions exert it."""

    def hold(
        self,
        centre: np.ndarray,
        arm: np.ndarray,
        motions: RigidMotions,
        inertia: np.ndarray,
        before: np.ndarray,
        push: np.ndarray,
    ) -> np.ndarray:
        """Give the nodes the rigid motion for a step; return its components after the step, (6,).

        centre: centre of mass of the body [m], (3,); arm: positions of the body's points relative to its centre, shape
        (n, 3) [m]; motions: defines the components; inertia: inertia matrix of the body in components, (6, 6), see
        `RigidMotions`; before: components of the motion at the start of the step, (6,); push: change of the momentum
        components by forces in the step, (6,).
        """
        self._inertia, self._before, self._push = inertia, before, push
        self._find_nodes(centre, arm, motions)
        velocity = self._of(self._nodes.velocity)
        self._impulse = self._to_rigid(velocity)
        if self._no_slip is not None:
            self._field.strain_as_moved(self._at[self._shared.any(axis=1)])
        if np.abs(self._impulse).max(initial=0.0) <= ROUNDING * np.abs(self._weight * velocity).max(initial=0.0):
            self._impulse[:] = 0.0
        else:
            self._give(self._impulse)
        return self._motion

    def receive(self, motions: RigidMotions) -> Received:
        """Return the momentum and energy that the body receives from the nodes at the end of a step, from their final
        velocities; motions: defines the components of rigid motions."""
        nodes, m, u = self._nodes, self._share[:, None], self._before
        velocity, increment = self._of(nodes.velocity), self._of(nodes.velocity_increment)
        old, pic = velocity - increment, np.where(self._shared, 1.0, 1.0 - self._flip)
        rigid = np.where(self._outer, self._base, self._motions @ u)
        change = np.einsum(
            "kd,kdi->i", np.where(self._outer, 0.0, m * (increment - self._slip + pic * (old - rigid))), self._motions
        )
        # later bodies may have changed the impulses of forces on outer nodes
        gained = np.where(self._outer, m * (velocity - self._base), 0.0)
        change += self._lacking @ (self._motion - u) + np.einsum("kd,kdi->i", gained, self._motions) - self._from_outer
        momentum = self._inertia @ u + change
        after = motions.natural(self._inertia, momentum)
        squares = 0.5 * np.sum(increment * increment, axis=1)
        of_shared = (velocity - self._slip - rigid) * (velocity - 0.5 * increment)
        of_others = increment * (rigid + 0.5 * increment) - pic * (rigid - old) * velocity
        power = np.sum(np.where(self._shared, of_shared, of_others), axis=1)
        won = 0.5 * float(after @ self._inertia @ after - u @ self._inertia @ u)
        spread = 0.5 * float(u @ self._lack @ u - after @ self._lack @ after + (u + after) @ self._from_outer)
        light = float(np.sum(self._share * (self._of(nodes.increment_energy) - squares)))  # see `NodalMomentum.works`
        mixing = float(np.sum(self._share * power)) - won - spread
        return Received(momentum, after, max(mixing, 0.0), spread + light + min(mixing, 0.0))

    def await_contact(self) -> None:
        """Store the nodal velocities before contact. Called when all other impulses of the step have been applied."""
        self._velocity, self._increment = self._of(self._nodes.velocity), self._of(self._nodes.velocity_increment)

    def respond(self) -> None:
        """Set the nodal velocities to the rigid motion that results from the contact impulses so far, so that further
        contact impulses are computed for the response of the whole body."""
        velocity = self._pushed()
        self._nodes.velocity[self._at] = velocity + self._response(velocity) / self._m

    def finish(self) -> None:
        """Complete contact: set the final velocities of the nodes as if each moved independently, then apply the impulses
        that give the nodes the rigid motion; the velocity field records the work of these impulses."""
        velocity = self._pushed()
        self._nodes.velocity[self._at] = velocity
        self._give(self._response(velocity))

    def count(self, done: StepWork) -> None:
        """Add the impulses of supports on the nodes, and their work, to the record `done` of the step; subtract these
        impulses from the external impulses in `done`, which already contain them."""
        done.impulse[:] += self._beside[:3]
        for row, axis, impulse in self._reactions:
            done.reactions[row, axis] += impulse
            done.impulse[axis] -= impulse
            done.works[[SUPPORT, IMPACT]] += impulse * self._actions.supports.velocity[row, axis]

    def _find_nodes(self, centre: np.ndarray, arm: np.ndarray, motions: RigidMotions) -> None:
        body, nodes, m = self._body, self._nodes, self._arrays["mass"][:, None]
        self._clear()
        mass = nodes.mass
        if not self._alone:
            scatter_numbers(body.n_slabs, body.mapped, m * np.array([1.0, 0.0, 0.0]), self._sums.body_mass)
            mass = self._sums.body_mass[:, 0]
        if self._periods.any():
            scatter_vectors(body.n_slabs, body.mapped, m * arm, self._sums.body_moment)
        self._here = here = np.flatnonzero(mass > MASS_EPS)
        self._at = domain.of_nodes(here, here)
        self._m, constrained, self._share = self._of(nodes.mass)[:, None], self._of(nodes.constrained), self._of(mass)
        self._free = free = domain.of_nodes(free_axes(nodes, self._field.external, here), here)
        self._given = motions.given
        self._motions = motions.at(self._arms(centre))
        filled = self._share / (self._density * self._field.grid.cell_volume)
        if self._no_slip is not None:  # a face of the grid, such as a plane of symmetry, cuts off a part of a node
            filled /= self._no_slip.share_in_grid(self._at)
        self._outer = (filled < FILLED_HALF_A_CELL_OUTSIDE[self._field.grid.case.functions])[:, None] & (not self._alone)
        self._goal, self._slip, self._normal, follows = (np.zeros((len(self._at), n)) for n in (3, 3, 3, 1))
        self._part_from_others(centre, motions, follows)
        led = np.minimum(1.0, self._share[:, None] / (FULL_DRIVE_FRACTION * self._m))
        self._weight = np.where(self._outer, follows, led) * free * self._m
        self._kept = np.where(self._outer, 1.0 - self._share[:, None] / self._m, 1.0)
        clamped = (constrained > 0) & (self._actions.supports.mirror[constrained - 1] == 0)
        self._clamped = [(int(constrained[k, d]) - 1, int(k), int(d)) for k, d in np.argwhere(clamped)]
        self._hold = HOLD * float(self._weight.sum())
        self._find_inertia(motions, clamped)

    def _part_from_others(self, centre: np.ndarray, motions: RigidMotions, follows: np.ndarray) -> None:
        """Split the momentum of nodes that the rigid body shares with other bodies, so that velocity increments are
        relative to the velocity of the other bodies. Outer nodes (more than half a cell outside the surface of the body)
        follow the other bodies only.

        centre: centre of mass of the body [m]; motions: defines the components of rigid motions. Also computes the velocity
        of the fluid near the surface, and sets `follows`, the degree to which outer nodes have this velocity along the
        surface, between 0 and 1, shape (n, 1).

        """
        nodes, at, mass = self._nodes, self._at, self._m[:, 0].copy()
        self._base = self._of(nodes.velocity) - self._of(nodes.velocity_increment)
        common = [(np.isin(at, other._at), np.isin(other._at, at), other) for other in self._earlier]
        apart_from_rigid = np.ones(len(at), bool)
        bound = np.zeros(len(at))  # mass of bodies that move with the node
        for here, there, other in common:
            mass[here] -= other._share[there]
            apart_from_rigid[here] = False
            bound[here] += np.where(other._outer[there, 0], 0.0, other._share[there])
        others = mass - self._share
        self._shared = shared = (others > LEAST_OTHERS * self._m[:, 0])[:, None] & self._free
        self._outer &= (others > LEAST_SHARE * self._m[:, 0])[:, None]
        if not shared.any():
            return
        own = self._share / np.where(others > 0.0, others, 1.0)
        apart = np.where(shared, own[:, None] * (self._base - self._motions @ self._before), 0.0)
        self._base += apart
        moved = np.where(self._outer, apart, 0.0)
        for here, there, other in common:
            other._base[there] += np.where(other._outer[there], moved[here], 0.0)
        moved *= 1.0 - bound[:, None] / self._m
        self._find_slip(centre, motions, (shared | np.array(self._field.grid.thin)).all(axis=1) & apart_from_rigid, follows)
        moved += self._share[:, None] / self._m * self._slip
        nodes.velocity[at] += moved
        nodes.strain_velocity[at] += moved
        nodes.velocity_increment[at] += moved - apart
        nodes.momentum[at] += self._m * apart

    def _find_slip(self, centre: np.ndarray, motions: RigidMotions, chosen: np.ndarray, follows: np.ndarray) -> None:
        """Compute the fluid velocities relative to the body that give no slip on the surface itself, at the nodes of the
        mask `chosen`, shape (n,), and set `follows`, shape (n, 1): the degree, between 0 and 1, to which outer nodes have
        this velocity along the surface. centre: centre of mass of the body [m]; motions: defines the components of rigid
        motions."""
        no_slip, near = self._no_slip, np.flatnonzero(chosen)
        if no_slip is None or not len(near):
            return
        nodes, at = self._nodes, self._at
        window = no_slip.find_window(at)
        mass, body_mass, old = (
            domain.of_nodes(values, window.node)
            for values in (
                nodes.mass[window.node],
                self._sums.body_mass[window.node, 0],
                nodes.velocity[window.node] - nodes.velocity_increment[window.node],
            )
        )
        velocity = np.where(mass[:, None] > MASS_EPS, old, 0.0)
        velocity[np.searchsorted(window.node, at)] = self._base
        filled = body_mass / (self._density * self._field.grid.cell_volume * window.share)
        place = self._field.grid.find_positions(at[near])
        surface = no_slip.find_surface(window, filled, place)
        if (region := self.region) is not None:
            most = SURFACE_WITHIN * self._field.grid.lattice.cell
            inside = partial(region.contains, active=self._field.grid.active_axes)
            distance, found = find_distances(inside, centre + self._arms(centre)[near], surface.normal, most)
            surface = surface._replace(distance=np.where(found, distance, surface.distance))
        relative, known = [], []
        for height in no_slip.heights:
            out = (height - surface.distance)[:, None] * surface.normal
            there, is_known = no_slip.sample(window, velocity, mass - body_mass, place + out)
            relative.append(there - motions.at(self._arms(centre)[near] + out) @ self._before)
            known.append(is_known)
        certainty = known[0] * surface.certainty
        goal = no_slip.continue_profile(surface._replace(certainty=certainty), relative[0], relative[1], known[1])
        outer = self._outer[near, 0]
        self._goal[near] = goal
        self._slip[near] = np.where(outer[:, None], 0.0, goal)
        self._normal[near] = np.where(outer[:, None], surface.normal, 0.0)
        follows[near, 0] = np.where(outer, certainty, 1.0)

    def _arms(self, centre: np.ndarray) -> np.ndarray:
        """Return the vectors from the centre of the body to the nodes, shape (n, 3) [m]; on a periodic grid, to the images
        nearest to the points of the body."""
        arms = self._field.grid.find_positions(self._at) - centre
        if (periods := self._periods).any():
            middle = self._of(self._sums.body_moment) / self._share[:, None]
            arms += periods * np.round((middle - arms) / np.where(periods > 0.0, periods, np.inf))
        return np.where(self._field.grid.thin, 0.0, arms)

    def _find_inertia(self, motions: RigidMotions, clamped: np.ndarray) -> None:
        """Compute the inertia matrix of the nodes, and the correction E: the inertia of the body minus that of its inner
        nodes (not more than half a cell outside its surface). E is set to zero where supports leave too little inertia.
        motions: defines the components of rigid motions; clamped: mask of the node directions that supports hold, shape (n,
        3)."""
        inner = np.where(self._outer, 0.0, self._share[:, None]) * np.ones(3)
        self._lack = self._lacking = self._inertia - inertia_at(inner, self._motions)
        of_nodes, mass = inertia_at(self._kept * self._weight + self._hold * clamped, self._motions), float(self._weight.sum())
        across = np.einsum("kd,kdi->ki", self._normal * (self._weight > 0.0), self._motions)
        of_nodes -= np.einsum("k,ki,kj->ij", np.max(self._kept * self._weight, axis=1), across, across)
        left = of_nodes + self._lack - LEAST_SHARE * self._inertia
        if np.linalg.eigvalsh(left).min() < -SMALL * (mass + self._hold * clamped.any()):
            self._lacking = np.zeros((6, 6))
        self._roots = motions.roots(of_nodes + self._lacking, mass)

    def _to_rigid(self, velocity: np.ndarray) -> np.ndarray:
        """Return the impulses [N s], shape (n, 3), that change the velocities of the nodes from `velocity` [m/s], shape (n,
        3), to the rigid motion that results from the momentum of the nodes and the loads on the body; also store this
        motion and the impulses of walls and supports."""
        goals, given = self._actions.supports.velocity, self._given
        lacks = self._kept * self._along(velocity - self._goal - self._motions @ given)
        momentum = self._push + np.einsum("kd,kdi->i", lacks, self._motions)
        for row, k, d in self._clamped:
            momentum += self._hold * (goals[row, d] - self._motions[k, d] @ given) * self._motions[k, d]
        gained = np.where(self._outer, self._share[:, None] * (velocity - self._base), 0.0)
        self._from_outer = np.einsum("kd,kdi->i", gained, self._motions)
        momentum += self._lacking @ (self._before - given) + self._from_outer
        kept = self._walls.keep_inside(given + self._roots @ (self._roots.T @ momentum), self._roots)
        self._motion = motion = kept.motion
        self._reactions = [(wall.row, wall.axis, push) for wall, push in kept.impulses]
        impulse = self._along(self._motions @ motion + self._goal - velocity)
        # the body gets its share of the impulses on outer nodes
        self._from_outer += np.einsum("kd,kdi->i", (1.0 - self._kept) * impulse, self._motions)
        self.led_impulse = np.einsum("kd,kdi->i", impulse, self._motions) - self._push - kept.given
        self._beside = self._lacking @ (motion - self._before) - self._from_outer
        self.led_impulse += self._beside
        for row, k, d in self._clamped:
            held = self._hold * float(goals[row, d] - self._motions[k, d] @ motion)
            self._reactions.append((row, d, held))
            self.led_impulse -= held * self._motions[k, d]
        return np.asarray(impulse)

    def _along(self, velocity: np.ndarray) -> np.ndarray:
        """Return the momentum [N s], shape (n, 3), of the nodes at given velocities [m/s], shape (n, 3), multiplied for
        each node by the degree to which the node follows the body, between 0 and 1. Outer nodes (more than half a cell
        outside the surface of the body) contribute only the component along the surface."""
        free = self._weight > 0.0
        across = np.sum(self._normal * free * velocity, axis=1)[:, None] * self._normal
        return np.asarray(self._weight * (velocity - across))

    def _pushed(self) -> np.ndarray:
        """Return the velocities of the nodes [m/s] after the contact impulses so far, as if each node moved independently,
        shape (n, 3)."""
        return self._velocity + self._of(self._nodes.velocity_increment) - self._increment

    def _of(self, values: np.ndarray) -> np.ndarray:
        """Return the values of a nodal array, shape (nodes, ...), at the n nodes to which the body contributes, shape (n,
        ...), gathered from all processes."""
        return domain.of_nodes(values[self._here], self._here)

    def _response(self, velocity: np.ndarray) -> np.ndarray:
        """Return the impulses [N s], shape (n, 3), that change the velocities of the nodes from `velocity` [m/s], shape (n,
        3), to the rigid motion, without the impulses that were already applied before contact."""
        return self._to_rigid(velocity - self._impulse / self._m) - self._impulse

    def _give(self, impulse: np.ndarray) -> None:
        self._field.add_impulses(impulse, IMPACT, -1.0, self._at)
