"""The nodes about a rigid body: they move as it does, and hold it where walls and other bodies do.

The mass of a node is a small part of that of the body. Were nodes free, what stops one would stop this part alone, and under a
lasting load the body would sink in. So the nodes that the body reaches take the rigid motion with the momentum of them all,
before contact and with every impulse that contact finds:

    min Σ_I φ_I m_I |V + ω × s_I - v_I|²,  while no point of the body passes a wall ,

where s_I is the middle of the body's mass about node I. As with driven points, a node follows wholly where the body gives it a
share FULL_DRIVE_FRACTION of its mass, φ_I = min(1, share/FULL_DRIVE_FRACTION). The impulses on the nodes do no work on rigid
motions, so that they take neither momentum nor angular momentum; what they lose is the energy of an impact without rebound.
"""

from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np

from pellucid.conditions.rigid.motions import RigidMotions, RigidWalls
from pellucid.contact.contact_body import ContactBody
from pellucid.energy import IMPACT, SUPPORT, StepWork
from pellucid.grid.actions import NodalActions
from pellucid.grid.clearing import Clearing
from pellucid.grid.momentum import FULL_DRIVE_FRACTION, MASS_EPS
from pellucid.grid.nodal_fields import STEP, SUM, NodalField, allocate, with_memory
from pellucid.grid.vectors import scatter_vectors
from pellucid.ranks.domain import domain

HOLD = 1e6  # of the mass of all nodes: the weight of nodes within the grid that a support clamps
ROUNDING = 1e-13  # of the momentum of the nodes


class BodySums(NamedTuple):
    """What a rigid body alone gives the nodes of its velocity field."""

    body_moment: Annotated[np.ndarray, NodalField(3, SUM, STEP, "kg m", "of a rigid body's points about its centre of mass")]
    body_mass: Annotated[np.ndarray, NodalField(3, SUM, STEP, "kg", "of these along x, where the field has other bodies")]


class RigidNodes:
    """The nodes of a velocity field that a rigid body reaches.

    arrays: of the body; alone: whether no other body is in its velocity field.
    """

    def __init__(
        self, body: ContactBody, arrays: Mapping[str, np.ndarray], actions: NodalActions, walls: RigidWalls, alone: bool
    ) -> None:
        self._body, self._arrays, self._actions, self._walls, self._alone = body, arrays, actions, walls, alone
        self._field, self._nodes = actions.field, actions.field.grid.nodes
        self._sums = with_memory(
            allocate(BodySums, 0), self._field.grid.n_nodes, "body_moment", *(() if alone else ("body_mass",))
        )
        self._clear = Clearing(STEP, self._field.grid.rows, self._sums)
        self.led_impulse = np.zeros(6)
        """What the nodes take that neither forces nor walls give: of the numbers that are prescribed, what leads them."""

    def hold(self, arm: np.ndarray, motions: RigidMotions, push: np.ndarray) -> np.ndarray:
        """Let the nodes move as the body, whose points are at these places from its centre, shape (n, 3) [m].

        push: what forces on it give its numbers in the step, shape (6,), see `RigidMotions`. Returns these then.
        """
        self._find_nodes(arm, motions)
        self._push = push
        velocity = self._of(self._nodes.velocity)
        self._impulse = self._to_rigid(velocity)
        if np.abs(self._impulse).max(initial=0.0) <= ROUNDING * np.abs(self._weight * velocity).max(initial=0.0):
            self._impulse[:] = 0.0
        else:
            self._give(self._impulse)
        return self._motion

    def await_contact(self) -> None:
        """Remember the velocities before contact: all other impulses have been given."""
        self._velocity, self._increment = self._of(self._nodes.velocity), self._of(self._nodes.velocity_increment)

    def respond(self) -> None:
        """Give the nodes the rigid velocity that follows from the contact impulses so far."""
        velocity = self._pushed()
        self._nodes.velocity[self._at] = velocity + self._response(velocity) / self._m

    def finish(self) -> None:
        """End contact: these velocities become those of the nodes, with the impulses that they take."""
        velocity = self._pushed()
        self._nodes.velocity[self._at] = velocity
        self._give(self._response(velocity))

    def count(self, done: StepWork) -> None:
        """Add the impulses of walls and clamps on the nodes to the work and impulses of the step; the velocity field has
        counted them as external."""
        for row, axis, impulse in self._reactions:
            done.reactions[row, axis] += impulse
            done.impulse[axis] -= impulse
            done.works[[SUPPORT, IMPACT]] += impulse * self._actions.supports.velocity[row, axis]

    def _find_nodes(self, arm: np.ndarray, motions: RigidMotions) -> None:
        body, nodes, m = self._body, self._nodes, self._arrays["mass"][:, None]
        self._clear()
        scatter_vectors(body.n_slabs, body.mapped, m * arm, self._sums.body_moment)
        share = nodes.mass
        if not self._alone:
            scatter_vectors(body.n_slabs, body.mapped, m * np.array([1.0, 0.0, 0.0]), self._sums.body_mass)
            share = self._sums.body_mass[:, 0]
        self._here = here = np.flatnonzero(share > MASS_EPS)
        self._at = domain.of_nodes(here, here)
        self._m, constrained, share = self._of(nodes.mass)[:, None], self._of(nodes.constrained), self._of(share)
        free, driven = constrained == 0, self._field.external.driven_mass
        if len(driven):
            free &= self._of(driven) < FULL_DRIVE_FRACTION * self._m
        self._weight = np.minimum(1.0, share[:, None] / (FULL_DRIVE_FRACTION * self._m)) * free * self._m
        clamped = (constrained > 0) & (self._actions.supports.mirror[constrained - 1] == 0)
        self._clamped = [(int(constrained[k, d]) - 1, int(k), int(d)) for k, d in np.argwhere(clamped)]
        mass = float(self._weight.sum())
        self._hold = HOLD * mass
        self._motions, self._given = motions.at(self._of(self._sums.body_moment) / share[:, None]), motions.given
        self._roots = motions.roots(self._weight + self._hold * clamped, self._motions, mass)

    def _to_rigid(self, velocity: np.ndarray) -> np.ndarray:
        """Impulses after which nodes with these velocities, shape (n, 3), move as the body."""
        goals, given = self._actions.supports.velocity, self._given
        momentum = self._push + np.einsum("kd,kdi->i", self._weight * (velocity - self._motions @ given), self._motions)
        for row, k, d in self._clamped:
            momentum += self._hold * (goals[row, d] - self._motions[k, d] @ given) * self._motions[k, d]
        kept = self._walls.keep_inside(given + self._roots @ (self._roots.T @ momentum), self._roots)
        self._motion = motion = kept.motion
        self._reactions = [(wall.row, wall.axis, push) for wall, push in kept.impulses]
        impulse = self._weight * (self._motions @ motion - velocity)
        self.led_impulse = np.einsum("kd,kdi->i", impulse, self._motions) - self._push - kept.given
        for row, k, d in self._clamped:
            held = self._hold * float(goals[row, d] - self._motions[k, d] @ motion)
            self._reactions.append((row, d, held))
            self.led_impulse -= held * self._motions[k, d]
        return np.asarray(impulse)

    def _pushed(self) -> np.ndarray:
        """Velocities of the nodes with the contact impulses so far, as if each node moved alone."""
        return self._velocity + self._of(self._nodes.velocity_increment) - self._increment

    def _of(self, values: np.ndarray) -> np.ndarray:
        """What the nodes that the body reaches have of what all nodes have, whatever process found it."""
        return domain.of_nodes(values[self._here], self._here)

    def _response(self, velocity: np.ndarray) -> np.ndarray:
        """The impulses by which nodes with these velocities become rigid, beside those given before contact."""
        return self._to_rigid(velocity - self._impulse / self._m) - self._impulse

    def _give(self, impulse: np.ndarray) -> None:
        everywhere = np.zeros_like(self._nodes.velocity)
        everywhere[self._at] = impulse
        self._field.add_impulses(everywhere, IMPACT, -1.0)
