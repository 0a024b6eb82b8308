"""Optional capabilities of bodies, one class for each; conditions, contact and the clock test with `isinstance` whether a
body has a capability. The members of a capability are methods only, as these tests would evaluate properties.

A kind of body declares its capabilities as base classes, whose methods it must then define; a user-defined kind only needs
the methods. The model of a body checks before a run which conditions of a case it supports, so that these tests succeed.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

import numpy as np

if TYPE_CHECKING:  # keeps the import fast for the models of conditions
    from pellucid.contact.contact_surface import ContactSurface
    from pellucid.contact.wall_plane import WallPlane
    from pellucid.energy import Passed
    from pellucid.geometry.meshes.cells import FaceShares
    from pellucid.grid.velocity_transfer import VelocityTransfer


class SurfacePoints(NamedTuple):
    """Quadrature points on a surface, at which a load is evaluated at one time, in arrays of any shape."""

    position: np.ndarray  # (..., 3) positions [m]
    normal: np.ndarray  # (..., 3) outward unit normals
    density_ratio: np.ndarray  # (...) current over initial areal density, i.e. initial over current area


Traction = Callable[[SurfacePoints, float], np.ndarray]
"""Force per current area [Pa], shape (..., 3), at a time after the start of the step of the clock [s]."""


class ActingTraction(NamedTuple):
    """A traction (force per unit area) that acts on a body over a step."""

    column: int  # column of the work of the traction in a row of works
    traction: Traction  # function of points on the surface and time that returns the traction [Pa]
    label: str  # name of the load for users


# loads and drag


@runtime_checkable
class TakesExternalForces(Protocol):
    """A body on whose points or nodes external forces can act."""

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces on the points [N], shape (n, 3), in storage order, over this step.

        column: place of the channel of the forces (entry of the energy balance) in arrays of works, see `pellucid.energy`.
        """


@runtime_checkable
class TakesPressure(Protocol):
    """A membrane on which a pressure can act along the normals."""

    def add_pressure(self, pressure: float, column: int) -> None:
        """Add the forces of a pressure [Pa] along the normals over this step.

        column: place of the work of these forces in arrays of works, see `pellucid.energy`.
        """


@runtime_checkable
class TakesTractions(Protocol):
    """A surface that evaluates its loads itself, at any times within a step (for example in sub-steps)."""

    def add_traction(self, traction: "Traction", column: int, label: str) -> None:
        """Add the forces of a traction (force per unit area) on the surface over this step.

        column: place of the work of these forces in arrays of works, see `pellucid.energy`; label: name of the load for
        users.
        """


@runtime_checkable
class TakesDrag(Protocol):
    """A body with inertia that a drag (a force against its velocity) can slow."""

    def damp(self, rate: float, dt: float) -> tuple[float, np.ndarray]:
        """Apply a drag over this step dt [s], which reduces velocities at a rate [1/s].

        Returns the energy [J] that the drag removed from the body, and the impulse of the drag on the body [N s], shape
        (3,); both are zero if the body itself reports them to the energy balance.
        """


@runtime_checkable
class TakesGravity(Protocol):
    """A body with its own nodes, on which gravity acts. For points on the grid, gravity acts on the nodes of the grid."""

    def share_gravity(self, share: float) -> None:
        """Set the fraction of gravity that acts on the body over this step; the default is 1."""


# supports and prescribed motions of own nodes


class NodalSupport(NamedTuple):
    """A support as it constrains nodes of a body with its own nodes: nodes, directions and prescribed velocity."""

    nodes: np.ndarray  # (n,) mask of the constrained nodes
    axes: tuple[bool, bool, bool]  # True for the constrained directions
    velocity: tuple[float, float, float]  # prescribed velocity [m/s]
    wall: tuple[int, int] | None  # axis and end (0 lower, 1 upper) of the face of the grid that acts as a wall
    label: str = "a support"  # name in messages
    friction: float = 0.0  # friction coefficient of the wall
    face: tuple[int, int] | None = None  # axis and end of the constrained face of the grid; None for a region
    until: float = inf  # time at which the support ends [s]


@runtime_checkable
class TakesSupports(Protocol):
    """A body with its own nodes that supports can constrain."""

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """Add supports that constrain nodes of the body."""


@runtime_checkable
class ReleasesSupports(Protocol):
    """A body that must be notified when supports release nodes of the body or of the grid during a run."""

    def let_go(self, supports: Collection[int]) -> None:
        """Set which supports act on the body from now on: all supports of the body except those with these numbers (indices
        in the list of supports)."""


@runtime_checkable
class HeldInRegions(Protocol):
    """A body whose points supports at rest hold, within the region of each support, in addition to holding the grid nodes."""

    def hold_in_regions(self, rows: np.ndarray) -> None:
        """Set for each point the support that holds it in all directions: its number in the list of supports, counted from
        1; 0 for none; shape (n,), in the order of the point numbers."""


@runtime_checkable
class TakesMotions(Protocol):
    """A body with its own nodes that can follow prescribed motions along axes."""

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Prescribe motions of nodes.

        names: names of the motions; numbers, shape (n,): 1 + the number of the motion that a node follows, 0 for none; axes,
        shape (motions, 3): 1 if a motion prescribes the velocity along the axis.
        """

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """Set the velocities of the prescribed motions over this step [m/s], shape (motions, 3)."""


@runtime_checkable
class TakesNormalMotions(Protocol):
    """A surface with its own nodes that can follow prescribed motions along its normal."""

    def add_normal_motions(self, names: Sequence[str], numbers: np.ndarray) -> None:
        """Prescribe motions of nodes along the surface normal.

        names: names of the motions; numbers, shape (n,): 1 + the number of the motion that a node follows, 0 for none.
        """

    def set_normal_velocities(self, rates: np.ndarray) -> None:
        """Set the velocities of the prescribed motions along the normal over this step [m/s], shape (motions,)."""


# shape


@runtime_checkable
class Membrane(Protocol):
    """A surface with two sides; its points are in the order of their numbers."""

    def pressed_areas(self) -> np.ndarray:
        """Return the vector areas on which a pressure acts, one for each point [m²], shape (n, 3); in plane problems, for the
        thickness of the slice."""

    def surface_areas(self) -> np.ndarray:
        """Return the area that belongs to each point [m²], shape (n,)."""


@runtime_checkable
class HasMesh(Protocol):
    """A body with a mesh, whose faces distribute loads to nodes by shape functions."""

    def node_sets(self) -> Mapping[str, np.ndarray]:
        """Return the node numbers of the named node sets of the mesh, by name."""

    def face_shares(self, faces: np.ndarray) -> "FaceShares":
        """Return the distribution of loads on triangles of the surface to the nodes of the body; faces: node numbers of the
        triangles, shape (f, 3).

        Called when all conditions are known, as the shape functions of the body may depend on the conditions.
        """


# contact between surfaces; for contact on the nodes of the grid see `pellucid.contact.contact_body`


@runtime_checkable
class HasContactSurface(Protocol):
    """A body that can make a contact surface, by which other bodies can have contact with this body."""

    def has_surface(self) -> bool:
        """Return True if the body has a surface of its own; False for fluids."""
        return True

    def make_contact_surface(self, column: int) -> "ContactSurface | None":
        """Create the contact surface of the body, or return None if the body has none; column: place of the work of contact
        forces in arrays of works."""

    def encloses(self, places: np.ndarray) -> bool:
        """Return True if the contact surface is closed and all positions [m], shape (n, 3), lie inside."""
        return False


@runtime_checkable
class BoundByContact(Protocol):
    """A body whose time step is limited by the springs of its contact surface."""

    def bound_by_contact(self, touching: "Sequence[ContactSurface]") -> None:
        """Remove the contact surface of the body if there is no contact partner; otherwise limit the first step so that it
        resolves the oscillation of the body on its contact springs.

        touching: all contact surfaces that have a partner.
        """


@runtime_checkable
class HasPointsAtWalls(Protocol):
    """A body without a contact surface whose points have contact with walls."""

    def make_points_at(self, plane: "WallPlane", column: int) -> "ContactSurface | None":
        """Create the contact surface formed by the body's points at a wall plane; return None if the body has no contact there.

        column: place of the work of contact forces in arrays of works.
        """


# only for bodies on the grid


@runtime_checkable
class LosesPoints(Protocol):
    """A body whose points can leave through faces of the grid."""

    def open_faces(self, faces: Sequence[tuple[int, int]]) -> None:
        """Allow points to leave through faces of the grid; each face is an axis (0, 1, 2) and an end (0 lower, 1 upper)."""

    def let_leave(self) -> "Passed | None":
        """Remove the points that left through the open faces in the last step, and return their number, mass, momentum and
        energies; None if no point left."""

    def just_left(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the positions beyond the faces [m], shape (n, 3), and the volumes [m³], shape (n,), of the points that left in
        this step."""


@runtime_checkable
class GainsPoints(Protocol):
    """A body into which points can enter through faces of the grid."""

    def make_room(self, rows: int, place: np.ndarray) -> None:
        """Reserve array rows for `rows` points that enter later. Until then these points have no mass and are at position
        `place` [m].

        After this call each process stores all points of the body.
        """

    def state_at(self, position: np.ndarray, volume: np.ndarray) -> dict[str, np.ndarray]:
        """Return the arrays, by name, of points in the initial state of the body at these positions [m], shape (n, 3), with
        volumes [m³], shape (n,)."""

    def stresses_of(self, sets: Callable[[np.ndarray], Sequence[np.ndarray]]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return the stresses [Pa], shape (n, 6), and volumes [m³], shape (n,), of the points in each of several sets.

        sets: function that returns, for the positions of all points [m], shape (m, 3), the indices of the points of each set.
        """

    def pressed(self, arrays: Mapping[str, np.ndarray], more: float) -> Mapping[str, np.ndarray]:
        """Return the arrays `arrays` of points, by name, with the pressure of a liquid increased by `more` [Pa]; unchanged for
        other materials."""

    def let_in(self, arrays: Mapping[str, np.ndarray], n_steps: int, time: float) -> "Passed":
        """Insert points with these arrays, by name, after step `n_steps` at the time `time` [s], and return their number, mass,
        momentum and energies."""


@runtime_checkable
class CarriesRotation(Protocol):
    """A body whose points can transfer the rotation of a rigid body to the nodes."""

    def carry_rotation(self) -> "VelocityTransfer":
        """Use affine velocity fields of the points in transfers to the nodes, which a constraint sets to the rotation of the
        body, and do not update velocities of points from the nodes. Return the rule by which velocities are transferred from
        nodes to points in this run (FLIP, blend or APIC)."""


@runtime_checkable
class KeepsHeat(Protocol):
    """A body whose points can store, as internal energy, the kinetic energy lost by transfers and the work of internal
    forces."""

    def use_separate_force_buffer(self) -> None:
        """Add the internal forces of the body to a separate nodal array of its velocity field
        (`VelocityField.separate_forces`), for bodies whose points store heat."""

    def return_heat(self, share: float) -> None:
        """Remove a fraction (`share`, 0 to 1) of the heat that the body's points stored in this step from their internal
        energy."""


# own steps


@runtime_checkable
class ShowsStart(Protocol):
    """A body without inertia, whose velocities follow from the loads."""

    def show_start(self, dt: float) -> None:
        """Compute the velocities at the start, before the first step dt [s]; the conditions of this step are already set."""


SLOWER_LOADS = "increase steady.load_steps or steady.loading, or decrease steady.courant"
"""Remedy if loads grow too fast for a relaxation."""


class Springs(NamedTuple):
    """Internal forces and masses of the nodes in a relaxation, from whose changes the stiffness is estimated."""

    position: np.ndarray  # (n, 3) positions of the nodes [m]
    force: np.ndarray  # (n, 3) internal forces at these positions [N]
    inertia: np.ndarray  # (n,) mass of the nodes in the relaxation [kg]
    free: np.ndarray  # (n, 3) mask of the directions that are not prescribed
    contact: tuple[np.ndarray, np.ndarray] | None = None  # positions at the start of the step [m] and contact forces there [N]

    def of_forces(self) -> tuple[np.ndarray, ...]:
        """Return the positions [m] and internal forces [N] of the nodes, and, if there is contact, the positions at the
        start of the step and the contact forces there, shape (n, 3) each."""
        return (self.position, self.force, *(self.contact or ()))


@runtime_checkable
class Relaxable(Protocol):
    """A body that can be brought to equilibrium by dynamic relaxation (`pellucid.simulation.steady`)."""

    def begin_relaxing(self, scaled: bool) -> None:
        """Prepare the body for a dynamic relaxation; scaled: True to scale the inertia of the nodes so that all nodes have
        the same stable step."""

    def relax(self, keep: float, gain: float, load_rate: float, gravity_share: float) -> None:
        """Set the damping for the coming step: the velocities of the nodes are multiplied by `keep`, and their velocity
        increments (acceleration times dt) by `gain`.

        load_rate: increment of the time of the loads over the length of the step; gravity_share: fraction of gravity that
        acts.
        """

    def springs(self) -> Springs:
        """Return the internal forces of the nodes in the last step [N], with the positions at which they were computed [m]
        and the masses of the nodes in the relaxation [kg], see `Springs`."""

    def unbalanced(self) -> tuple[float, float]:
        """Return two norms of the forces on the nodes, without constraint forces [N]: of their components along free
        directions, which vanish in equilibrium, and of internal and external forces, which balance each other."""
