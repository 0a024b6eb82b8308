"""Base class of bodies with their own nodes and explicit time integration: conditions, contact on the grid, checkpoints."""

import warnings
from abc import abstractmethod
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pellucid.bodies.own_nodes.contact_surface import PointsOfFaces, PointsOfNodes
from pellucid.bodies.own_nodes.grid_transfer import GridCoupling
from pellucid.bodies.own_nodes.kernels import Drag
from pellucid.bodies.own_nodes.motion import NodalMotion
from pellucid.contact.contact_body import ContactBody, TakesSecondImpulses
from pellucid.contact.contact_surface import ContactSurface
from pellucid.energy import StepWork, Totals
from pellucid.findings import listed
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.jit.bundle import Bundle
from pellucid.parts.body import Placement
from pellucid.parts.capabilities import (
    BoundByContact,
    NodalSupport,
    Relaxable,
    ReleasesSupports,
    Springs,
    TakesDrag,
    TakesExternalForces,
    TakesGravity,
    TakesMotions,
    TakesSupports,
)
from pellucid.parts.families import NodalBody
from pellucid.state import of_owner, with_owner

ALIKE = 1e-6  # relative difference of velocities that counts as round-off


class Overruled(NamedTuple):
    """A support and a motion that prescribe the same nodes along some axes."""

    support: NodalSupport  # overruled by the motion
    motion: int  # index of the motion
    nodes: int  # number of nodes that both prescribe
    axes: tuple[int, ...]  # axes along which both prescribe these nodes

    def differ(self, velocity: np.ndarray) -> list[str]:
        """Return the names of the axes along which motion and support prescribe different velocities. velocity: velocities of
        all motions [m/s], shape (motions, 3).
        """
        pairs = ((axis, self.support.velocity[axis], float(velocity[self.motion, axis])) for axis in self.axes)
        return ["xyz"[axis] for axis, one, other in pairs if abs(one - other) > ALIKE * max(abs(one), abs(other))]


def overruled(supports: Sequence[NodalSupport], numbers: np.ndarray, axes: np.ndarray) -> list[Overruled]:
    """Return all pairs of a support and a prescribed motion that overrules it, since both prescribe a node along an axis.

    numbers: 1 + the number of the motion that each node follows, 0 for none, shape (n,); axes: 1 if a motion prescribes the
    velocity along the axis, shape (motions, 3).
    """
    found = []
    for motion, along in enumerate(axes):
        driven = numbers == motion + 1
        for support in supports:
            both = tuple(axis for axis in range(3) if along[axis] and support.axes[axis])
            nodes = int((support.nodes & driven).sum())
            if nodes and both:
                found.append(Overruled(support, motion, nodes, both))
    return found


def warning(pair: Overruled, motion: str, body: str, velocity: np.ndarray) -> str | None:
    """Return a warning if a support and a motion (`pair`) prescribe different velocities for the same nodes; None otherwise.
    motion, body: names of the motion and of the body; velocity: velocities of all motions [m/s], shape (motions, 3).
    """
    axes = pair.differ(velocity)
    if not axes:
        return None
    nodes = "1 node" if pair.nodes == 1 else f"{pair.nodes} nodes"
    return (
        f"{pair.support.label} and motion `{motion}` prescribe different velocities along {listed(axes)} at {nodes} of body "
        f"{body}: the motion is used there; choose regions that do not overlap, or constrain other directions"
    )


FREE = (False, False, False)


class ExplicitNodes(
    NodalBody,
    BoundByContact,
    TakesExternalForces,
    TakesGravity,
    TakesDrag,
    TakesSupports,
    ReleasesSupports,
    TakesMotions,
    TakesSecondImpulses,
    Relaxable,
):
    """A body whose nodes move by their own forces; the grid, if there is one, is used for contact.

    A step consists of `begin`, the conditions, `predict`, `correct` after contact was resolved, and `update`. Nodes are stored
    in mesh order. Subclasses compute the internal forces, `motion.internal`, and stresses and energies.
    """

    contact_surface: PointsOfFaces | PointsOfNodes | None = None
    """Contact surface of the body; None if contact is computed on the grid nodes."""
    _contact_row = 0  # row of `motion.loads` for the forces of contact surfaces
    contact_rate = 0.0
    """Reciprocal of the longest step for which the springs of contact are stable [1/s]."""

    def __init__(
        self,
        position: np.ndarray,
        velocity: np.ndarray,
        mass: np.ndarray,
        placement: Placement,
        volume: np.ndarray | None = None,
    ) -> None:
        """position: [m], velocity: [m/s], shape (n, 3), used without copying; mass: nodal masses [kg], shape (n,); placement:
        velocity field, grid and gravity; volume: nodal volumes [m³], shape (n,), None for membranes.
        """
        n, grid_case = len(mass), placement.grid_case
        self.arrays = {
            "id": np.arange(n),
            "position": position,
            "velocity": velocity,
            "mass": mass,
            "prescribed": np.zeros((n, 3), np.int64),
        }
        field = self.velocity_field = placement.velocity_field
        self.grid = field.grid if field else None
        thin = grid_case.thin() if grid_case else FREE
        velocity[:, np.array(thin)] = 0.0
        self.coupling: GridCoupling | None = None
        if grid_case is not None and field is not None:
            if not isinstance(field, OwnNodesField):
                raise ValueError(f"the velocity field {field.name} moves its bodies, which have no own nodes")
            self.functions = field.grid.functions((2, 2, 2))  # nodes have no extent: GIMP assumes half a cell
            self.coupling = GridCoupling(field, self.functions, position, velocity, mass, volume)
        increment = self.coupling.increment if self.coupling else np.zeros((n, 3))
        self.motion = NodalMotion(self.arrays, self.grid, thin, placement.gravity, placement.n_loads, increment)
        self._left_grid: tuple[int, int] | None = None
        self._dt = 0.0
        self._overruled: list[Overruled] = []
        self.totals = Totals()

    # conditions

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        self.motion.add_supports(supports)

    def let_go(self, supports: Collection[int]) -> None:
        self.motion.let_go(supports)

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Set the prescribed motions of nodes, which overrule supports.

        names: names of the motions; numbers: 1 + the number of the motion that each node follows, 0 for none, shape (n,); axes:
        1 if a motion prescribes the velocity along the axis, shape (motions, 3).
        """
        self.motion.add_motions(names, numbers, axes)
        self._overruled = overruled(self.motion.supports, numbers, axes)

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        self.motion.set_motion_velocities(velocity)
        agree = []
        for pair in self._overruled:
            if (text := warning(pair, self.motion.motions[pair.motion], self.name, velocity)) is not None:
                warnings.warn(text, stacklevel=2)
            else:
                agree.append(pair)
        self._overruled = agree

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        self.motion.add_external_force(force, column)

    @property
    def follows(self) -> bool:
        """True if motions or supports prescribe the velocities of all nodes along all axes with more than one cell."""
        thin = self.grid.thin if self.grid else FREE
        return not self.motion.free[:, ~np.array(thin)].any()

    # the step

    def begin(self, dt: float) -> None:
        self._dt = dt
        if self.coupling:
            self.coupling.sort_if_needed()
        self.motion.loads.fill(0.0)

    def predict(self, dt: float) -> None:
        if self.coupling and self.touches_on_nodes:
            self.coupling.scatter(self.motion.forces())

    def correct(self, remap: bool) -> None:
        if self.touches_on_nodes:
            self.gather()
        self.motion.advance_velocities(self._dt)
        if self.constraint is not None:
            self.constraint.prescribe_velocities()
        if remap and self.touches_on_nodes:
            self.scatter_momentum()
        self.motion.sum_momentum(self.totals)

    def update(self, dt: float) -> None:
        self.motion.advance_positions(dt)
        self._left_grid = self.coupling.check_positions() if self.coupling else None

    def _count_power(self) -> None:
        """Store half the power of the internal forces at the end of the step [W] in the totals; zero during a relaxation."""
        self.totals.half_power = 0.0 if self.relaxes else 0.5 * self.motion.power()

    def renew_totals(self) -> None:
        self.motion.top_speed = self.constraint.top_speed if self.constraint is not None else 0.0
        self.motion.sum_momentum(self.totals)
        self.update(0.0)

    def check(self, n_steps: int, time: float) -> None:
        for fault in (self.motion.fault(), self._left_grid):
            if fault is not None:
                self.stop(*fault, n_steps, time)

    def work(self) -> StepWork:
        return self.motion.work()

    def damp(self, rate: float, dt: float) -> tuple[float, np.ndarray]:
        self.motion.slow(rate, dt)
        return 0.0, np.zeros(3)

    def share_gravity(self, share: float) -> None:
        self.motion.share_gravity(share)

    # steady states

    def begin_relaxing(self, scaled: bool) -> None:
        """Do nothing, whatever `scaled` is: a dynamic relaxation of this body uses the nodal masses as inertia and does not
        scale them.
        """

    def relax(self, keep: float, gain: float, load_rate: float, gravity_share: float) -> None:
        self.relaxes = True
        self.motion.top_speed = 0.0  # limits the step in the time of the loads only
        self.motion.drag, self.motion.load_rate = Drag(keep, gain), load_rate
        self.load_rate = load_rate
        self.motion.share_gravity(gravity_share)

    def springs(self) -> Springs:
        """Return the internal forces and the nodal positions at the start of the step, from which a relaxation estimates the
        stiffness.
        """
        position = self.arrays["position"] - self._dt * self.arrays["velocity"]
        contact = None if self.contact_surface is None else (position, self.motion.loads[self._contact_row])
        return Springs(position, self.motion.internal, self.motion.inertia, self.motion.free, contact)

    def unbalanced(self) -> tuple[float, float]:
        force, internal = self.motion.forces(), self.motion.internal
        left = (force + self.motion.leading_forces(self._dt))[self.motion.free]
        every = np.hypot(np.linalg.norm(internal), np.linalg.norm(force - internal))
        return float(np.linalg.norm(left)), float(every)

    # contact

    @property
    def touches_on_nodes(self) -> bool:
        """True if the body has its own velocity field and may have contact with other bodies on the nodes of the grid."""
        return isinstance(self.velocity_field, OwnNodesField) and self.velocity_field.touches_on_nodes

    def bound_by_contact(self, touching: Sequence[ContactSurface]) -> None:
        """Remove the contact surface if it is not one of `touching`, the surfaces with possible contact. Otherwise limit the
        time step to the initial step, since the stiffness of the contact springs is chosen for it.
        """
        surface = self.contact_surface
        if surface is None or not any(other is surface for other in touching):
            self.contact_surface, self.contact_rate = None, 0.0
        elif not surface.is_hard:
            self.contact_rate = surface.rate

    def place_surface(self) -> None:
        """Move the points of the contact surface to the present positions of the nodes, between steps."""

    @property
    def on_grid(self) -> ContactBody | None:
        return self if self.coupling else None

    def _coupled(self) -> GridCoupling:
        if self.coupling is None:
            raise ValueError(f"body {self.name} has no grid")
        return self.coupling

    def gather(self) -> np.ndarray:
        """Return the velocity increments of the nodes from contact on the grid over this step [m/s], shape (n, 3)."""
        return self._coupled().gather()

    def take_second_impulses(self, dt: float) -> float:
        self.motion.add_velocities(self._coupled().gather_second(), dt)
        self.constrain_again()
        self.motion.sum_momentum(self.totals)
        return 0.0

    def scatter_momentum(self) -> None:
        """Scatter the momentum of the nodes to the grid again, after the nodal velocities changed."""
        self._coupled().scatter_momentum()

    @property
    def mapped(self) -> Bundle:
        """Data of the nodes for transfers to the grid, for kernels."""
        return self._coupled().mapped

    @property
    def n_slabs(self) -> int:
        """Number of slabs (layers of grid cells) by which the nodes are sorted."""
        return self._coupled().n_slabs

    @abstractmethod
    def half_width(self) -> tuple[float, float, float]:
        """Return (d, a, b): the distance d of the surface of the body from its nodes [m], and two numbers that define it if d
        is negative; see `ContactBody.half_width`.
        """

    # checkpoint

    def state_arrays(self) -> dict[str, np.ndarray]:
        index = self.coupling.state_arrays() if self.coupling else {}
        surface = self.contact_surface.state_arrays() if self.contact_surface else {}
        return {**self.arrays, **with_owner("elements", self.element_arrays), **with_owner("index", index), **surface}

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        for name in ("position", "velocity"):
            self.arrays[name][...] = state[name]
        for name, array in self.element_arrays.items():
            array[...] = state[f"elements/{name}"]
        if self.coupling:
            self.coupling.sort()
        self.renew_totals()

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        for name, array in self.arrays.items():
            array[...] = arrays[name]
        for name, array in self.element_arrays.items():
            array[...] = arrays[f"elements/{name}"]
        if self.coupling:
            self.coupling.restore(of_owner("index", arrays))
        if self.contact_surface:
            self.contact_surface.restore(arrays)
