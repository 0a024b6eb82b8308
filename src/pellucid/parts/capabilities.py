"""Optional capabilities of bodies; conditions, contact and the clock test for each of these classes.

A kind of body declares its capabilities as base classes, whose methods it must then define; a user-defined kind only needs the
methods. The model of a body checks before a run which conditions of a case it supports, so that the tests here succeed.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

import numpy as np

if TYPE_CHECKING:  # keeps the import fast for the models of conditions
    from pellucid.contact.contact_surface import ContactSurface
    from pellucid.contact.wall_plane import WallPlane
    from pellucid.energy import Passed
    from pellucid.geometry.meshes.face_shares import FaceShares
    from pellucid.grid.velocity_transfer import VelocityTransfer
    from pellucid.parts.surface_load import Traction


# loads and drag


@runtime_checkable
class TakesExternalForces(Protocol):
    """A body with inertia on which external forces act."""

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces on the points [N], shape (n, 3), in storage order, over this step.

        column: column of their channel in a row of works, see `pellucid.energy`.
        """


@runtime_checkable
class TakesPressure(Protocol):
    """A membrane on which a pressure acts along the normals."""

    def add_pressure(self, pressure: float, column: int) -> None:
        """Add the forces of a pressure [Pa] along the normals over this step; column: column of their work in a row of
        works."""


@runtime_checkable
class TakesTractions(Protocol):
    """A surface that evaluates its loads itself, at the times that it needs within a step."""

    def add_traction(self, traction: "Traction", column: int, label: str) -> None:
        """Add the forces of a traction on the surface over this step.

        column: column of their work in a row of works; label: name of the load for users.
        """


@runtime_checkable
class TakesDrag(Protocol):
    """A body with inertia that a drag can slow."""

    def damp(self, rate: float, dt: float) -> tuple[float, np.ndarray]:
        """Apply a drag with a rate [1/s] over this step dt [s].

        Returns the energy [J] and the impulse on the body [N s], shape (3,), that the body does not count itself.
        """


@runtime_checkable
class TakesGravity(Protocol):
    """A body with its own nodes, on which gravity acts. For points on the grid, gravity acts on the nodes of the grid."""

    def share_gravity(self, share: float) -> None:
        """Set the fraction of gravity that acts on the body over this step; the default is 1."""


# supports and prescribed motions of own nodes


class NodalSupport(NamedTuple):
    """A support on nodes of a body with its own nodes."""

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
        """Add supports that constrain its nodes."""


@runtime_checkable
class ReleasesSupports(Protocol):
    """A body that must be notified when supports release nodes of the body or of the grid during a run."""

    def let_go(self, supports: Collection[int]) -> None:
        """Deactivate the supports with these numbers; all other supports of the body are active."""


@runtime_checkable
class HeldInRegions(Protocol):
    """A body whose points on the grid are also held by supports at rest within their regions, in addition to the grid nodes."""

    def hold_in_regions(self, rows: np.ndarray) -> None:
        """Set for each point the support that holds it in all directions: its number in the list of supports, counted from
        1; 0 for none; shape (n,), in the order of the point numbers."""


@runtime_checkable
class TakesMotions(Protocol):
    """A body with its own nodes that can follow prescribed motions along axes."""

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Prescribe motions of nodes.

        numbers, shape (n,): 1 + the number of the motion of a node, 0 for none; axes, shape (motions, 3): 1 if a motion
        prescribes the axis.
        """

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """Set the velocities of the prescribed motions over this step [m/s], shape (motions, 3)."""


@runtime_checkable
class TakesNormalMotions(Protocol):
    """A surface with its own nodes that can follow prescribed motions along its normal."""

    def add_normal_motions(self, names: Sequence[str], numbers: np.ndarray) -> None:
        """Prescribe motions of nodes along the normal. numbers, shape (n,): 1 + the number of the motion of a node, 0 for
        none."""

    def set_normal_velocities(self, rates: np.ndarray) -> None:
        """Set the velocities of the motions along the normal over this step [m/s], shape (motions,)."""


# shape


@runtime_checkable
class Membrane(Protocol):
    """A surface with two sides; its points are in the order of their numbers."""

    def pressed_areas(self) -> np.ndarray:
        """Return the vector areas of the points on which a pressure acts [m²], shape (n, 3); in plane problems, for the
        thickness of the slice."""

    def surface_areas(self) -> np.ndarray:
        """Return the area that belongs to each point [m²], shape (n,)."""


@runtime_checkable
class HasMesh(Protocol):
    """A body with a mesh, whose faces distribute loads to nodes by shape functions."""

    @property
    def node_sets(self) -> Mapping[str, np.ndarray]:
        """Node numbers of the named node sets of the mesh, by name."""

    def face_shares(self, faces: np.ndarray) -> "FaceShares":
        """Return the distribution of loads on triangles of its surface, shape (f, 3), to its nodes.

        Called when all conditions are known, as its shape functions may depend on them.
        """


# contact between surfaces; for contact on the nodes of the grid see `pellucid.contact.contact_body`


@runtime_checkable
class HasContactSurface(Protocol):
    """A body with which others can have contact by its surface."""

    has_surface: bool = True
    """True if the body has a surface of its own; False for fluids."""

    def make_contact_surface(self, column: int) -> "ContactSurface | None":
        """Create the contact surface of the body, or return None if the body has none; column: column of the work of
        contact forces."""

    def encloses(self, places: np.ndarray) -> bool:
        """Return True if the surface is closed and contains all positions [m], shape (n, 3)."""
        return False


@runtime_checkable
class BoundByContact(Protocol):
    """A body whose time step depends on its contact surface."""

    def bound_by_contact(self, touching: "Sequence[ContactSurface]") -> None:
        """Remove the contact surface of the body if there is no contact partner, and limit the first step by the
        oscillation of the body on its contacts.

        touching: all surfaces with contact.
        """


@runtime_checkable
class HasPointsAtWalls(Protocol):
    """A body without a contact surface whose points have contact with walls."""

    def make_points_at(self, plane: "WallPlane", column: int) -> "ContactSurface | None":
        """Create the contact surface of the body's points at a plane; return None without contact at the plane."""


# only for bodies on the grid


@runtime_checkable
class LosesPoints(Protocol):
    """A body whose points can leave through faces of the grid."""

    def open_faces(self, faces: Sequence[tuple[int, int]]) -> None:
        """Allow points to leave through faces of the grid, each an axis and an end (0 lower, 1 upper)."""

    def let_leave(self) -> "Passed | None":
        """Remove the points that left through the open faces in the last step, and return their number, mass, momentum and
        energies; None if no point left."""


@runtime_checkable
class GainsPoints(Protocol):
    """A body into which points can enter through faces of the grid."""

    def make_room(self, rows: int, place: np.ndarray) -> None:
        """Reserve array rows for points that enter later. Until then these points have no mass and are at position `place`
        [m].

        After this call each process stores all points of the body.
        """

    def state_at(self, position: np.ndarray, volume: np.ndarray) -> dict[str, np.ndarray]:
        """Return the initial arrays of points with these positions [m], shape (n, 3), and volumes [m³], shape (n,)."""

    def stresses_of(self, sets: Callable[[np.ndarray], Sequence[np.ndarray]]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return stresses [Pa], shape (n, 6), and volumes [m³], shape (n,), of several sets of points of the body.

        sets: function that returns the indices of the points of each set for positions [m], shape (n, 3).
        """

    def pressed(self, arrays: Mapping[str, np.ndarray], more: float) -> Mapping[str, np.ndarray]:
        """Return arrays of points of a liquid with the pressure increased by `more` [Pa]; other materials are unchanged."""

    def let_in(self, arrays: Mapping[str, np.ndarray], n_steps: int, time: float) -> "Passed":
        """Insert points with these arrays after a step, and return their number, mass, momentum and energies."""


@runtime_checkable
class SpreadsPoints(Protocol):
    """A body whose points are distributed over processes that share a simulation (`pellucid.ranks`)."""

    def keep_whole(self) -> None:
        """Store all points of the body on each process, since conditions access all of them in each step."""


@runtime_checkable
class CarriesRotation(Protocol):
    """A body whose points can transfer the rotation of a rigid body to the nodes."""

    @property
    def transfer(self) -> "VelocityTransfer":
        """The transfer of velocities between nodes and points in this run."""

    def carry_rotation(self) -> None:
        """Use affine velocity fields of the points, which a constraint sets, in transfers to the nodes; do not update
        velocities of points from the nodes."""


@runtime_checkable
class KeepsHeat(Protocol):
    """A body whose points can store the kinetic energy lost by transfers and internal forces as heat."""

    def use_separate_force_buffer(self) -> None:
        """Add the internal forces of the body to a separate buffer of its velocity field, which is for bodies that store
        heat."""

    def return_heat(self, share: float) -> None:
        """Release a fraction (`share`) of the heat that the body stored in this step."""


# own steps


@runtime_checkable
class ShowsStart(Protocol):
    """A body whose velocities are determined by the loads."""

    def show_start(self, dt: float) -> None:
        """Compute the initial velocities before the first step dt [s], whose conditions are set."""
