"""What a body may offer beside what every body does: each class here is what conditions, contact or the clock ask for.

A kind of body declares what it offers by the classes that it derives from, whose methods it has to define then; one of a
user's own need only have the methods. The model of a body says before a run which conditions of a case it takes, so that those
who ask here find what they need.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

import numpy as np

if TYPE_CHECKING:  # light, for the models of conditions
    from pellucid.contact.contact_surface import ContactSurface
    from pellucid.contact.wall_plane import WallPlane
    from pellucid.energy import Passed
    from pellucid.geometry.meshes.face_shares import FaceShares
    from pellucid.grid.velocity_transfer import VelocityTransfer
    from pellucid.parts.surface_load import Traction


# loads and drag


@runtime_checkable
class TakesExternalForces(Protocol):
    """Inertia on which external forces act."""

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces on the points [N], shape (n, 3), in the order in which they are stored, over this step.

        column: that of their channel in a row of works, see `pellucid.energy`.
        """


@runtime_checkable
class TakesPressure(Protocol):
    """A membrane along whose normals a pressure acts."""

    def add_pressure(self, pressure: float, column: int) -> None:
        """Add the forces of a pressure [Pa] along the normals over this step."""


@runtime_checkable
class TakesTractions(Protocol):
    """A surface that evaluates loads on it itself, at the instants that it needs within a step."""

    def add_traction(self, traction: "Traction", column: int, label: str) -> None:
        """Add forces on the surface over this step. label: what users know the load by."""


@runtime_checkable
class TakesDrag(Protocol):
    """Inertia that a drag slows."""

    def damp(self, rate: float, dt: float) -> tuple[float, np.ndarray]:
        """Let a drag act over this step dt [s], at a rate [1/s].

        Returns what it took that the body does not count itself: energy [J] and impulse on the body [N s], shape (3,).
        """


@runtime_checkable
class TakesGravity(Protocol):
    """Own nodes on which gravity acts; that on points on the grid acts on the nodes of the grid."""

    def share_gravity(self, share: float) -> None:
        """Let a share of gravity act over this step; all of it where this is never called."""


# supports and prescribed motions of own nodes


class NodalSupport(NamedTuple):
    """A support on nodes of a body that has its own."""

    nodes: np.ndarray  # (n,) whether it constrains a node
    axes: tuple[bool, bool, bool]  # constrained directions
    velocity: tuple[float, float, float]  # [m/s]
    wall: tuple[int, int] | None  # axis and end (0 lower, 1 upper) of the face of the grid that it makes a wall
    label: str = "a support"  # for messages
    friction: float = 0.0  # coefficient of the wall
    face: tuple[int, int] | None = None  # axis and end of the face of the grid on which it is, if it is on one
    until: float = inf  # time at which it ends [s]


@runtime_checkable
class TakesSupports(Protocol):
    """Own nodes that supports constrain."""

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """Let supports constrain its nodes."""


@runtime_checkable
class ReleasesSupports(Protocol):
    """A body to which it matters that supports let nodes go in a run, its own or those of the grid."""

    def let_go(self, supports: Collection[int]) -> None:
        """Let the supports of these numbers hold none of its nodes any more, and all others theirs."""


@runtime_checkable
class HeldInRegions(Protocol):
    """Points on the grid that supports at rest hold within their regions, in addition to the nodes of the grid."""

    def hold_in_regions(self, rows: np.ndarray) -> None:
        """Take the supports that hold points in all directions: their numbers, counted from 1 face by face, and 0 for other
        points, shape (n,), by number."""


@runtime_checkable
class TakesMotions(Protocol):
    """Own nodes that follow prescribed motions along axes."""

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Let nodes follow prescribed motions.

        numbers, shape (n,): 1 + that of a point's motion, else 0; axes, shape (motions, 3): 1 where a motion prescribes it.
        """

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """The velocities of the prescribed motions over this step [m/s], shape (motions, 3)."""


@runtime_checkable
class TakesNormalMotions(Protocol):
    """Own nodes of a surface that follow prescribed motions along its normal."""

    def add_normal_motions(self, names: Sequence[str], numbers: np.ndarray) -> None:
        """Let nodes follow prescribed motions along the normal. numbers, shape (n,): 1 + that of a node's motion, else 0."""

    def set_normal_velocities(self, rates: np.ndarray) -> None:
        """The velocities of these motions over this step [m/s], shape (motions,)."""


# shape


@runtime_checkable
class Membrane(Protocol):
    """A surface with two sides, in the order of the numbers of its points."""

    def pressed_areas(self) -> np.ndarray:
        """The vector areas by which a pressure pushes its points [m²], shape (n, 3); in plane problems those of the slice."""

    def surface_areas(self) -> np.ndarray:
        """The shares of its points in its area [m²], shape (n,)."""


@runtime_checkable
class HasMesh(Protocol):
    """Nodes of a mesh, whose faces carry loads by shape functions."""

    @property
    def node_sets(self) -> Mapping[str, np.ndarray]:
        """The sets of nodes that its mesh names, by the numbers of the nodes."""

    def face_shares(self, faces: np.ndarray) -> "FaceShares":
        """How what acts on triangles of its surface, shape (f, 3), of those that are selectable, goes to its nodes.

        It is asked for when all conditions are known: its functions may depend on them.
        """


# contact between surfaces; that on the nodes of the grid is in `pellucid.contact.contact_body`


@runtime_checkable
class HasContactSurface(Protocol):
    """A body that others can touch by its surface."""

    has_surface: bool = True
    """True if it has one of its own; fluids have none."""

    def make_contact_surface(self, column: int) -> "ContactSurface | None":
        """Make the surface by which others touch it, whose forces do work in this column; None where it has none."""

    def encloses(self, places: np.ndarray) -> bool:
        """Return True if its surface is closed and all of these places [m], shape (n, 3), lie inside."""
        return False


@runtime_checkable
class BoundByContact(Protocol):
    """A body on whose steps its contact surface has a bearing."""

    def bound_by_contact(self, touching: "Sequence[ContactSurface]") -> None:
        """All surfaces that touch are known: leave its own where it touches nothing; bound the first step by how fast the body
        swings on others."""


@runtime_checkable
class HasPointsAtWalls(Protocol):
    """A body without a surface whose points walls push."""

    def make_points_at(self, plane: "WallPlane", column: int) -> "ContactSurface | None":
        """Make what a wall touches of it, its points beside a plane; None where it touches none."""


# on the grid alone


@runtime_checkable
class LosesPoints(Protocol):
    """Points that can leave through faces of the grid."""

    def open_faces(self, faces: Sequence[tuple[int, int]]) -> None:
        """Let points leave through faces of the grid, each an axis and an end, 0 lower and 1 upper."""

    def let_leave(self) -> "Passed | None":
        """After a step: remove the points that left through these faces; None where there are none."""


@runtime_checkable
class GainsPoints(Protocol):
    """Points that can come in through faces of the grid."""

    def make_room(self, rows: int, place: np.ndarray) -> None:
        """Let so many points come in besides those of the start; until then they are without mass at a place [m].

        From now on each process has all points of the body.
        """

    def state_at(self, position: np.ndarray, volume: np.ndarray) -> dict[str, np.ndarray]:
        """The arrays of points with these positions [m], shape (n, 3), and volumes [m³], shape (n,), as the body starts."""

    def stresses_of(self, sets: Callable[[np.ndarray], Sequence[np.ndarray]]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Stresses [Pa], shape (n, 6), and volumes [m³], shape (n,), of sets of its points.

        sets: the numbers of those in each set among some positions [m], shape (n, 3).
        """

    def pressed(self, arrays: Mapping[str, np.ndarray], more: float) -> Mapping[str, np.ndarray]:
        """Arrays of points of a liquid under a pressure larger by `more` [Pa]; those of other materials as they are."""

    def let_in(self, arrays: Mapping[str, np.ndarray], n_steps: int, time: float) -> "Passed":
        """Take in points with such arrays after a step: what they bring along."""


@runtime_checkable
class SpreadsPoints(Protocol):
    """Points that processes spread among them where they share a simulation (`pellucid.ranks`)."""

    def keep_whole(self) -> None:
        """Let each process have all points, since they are asked for as a whole in the steps."""


@runtime_checkable
class CarriesRotation(Protocol):
    """Points that may carry the rotation of a rigid body to the nodes."""

    @property
    def transfer(self) -> "VelocityTransfer":
        """Transfer of velocities from the nodes to the points of the run."""

    def carry_rotation(self) -> None:
        """Let the points have affine velocity fields, which what leads them sets, and take no velocity from the nodes."""


@runtime_checkable
class KeepsHeat(Protocol):
    """Points that may take up what transfers and internal forces take from the kinetic energy."""

    def use_separate_force_buffer(self) -> None:
        """Add internal forces to the buffer that its velocity field keeps for bodies that keep heat."""

    def return_heat(self, share: float) -> None:
        """Give up this share of the heat that it kept in this step."""


# own steps


@runtime_checkable
class ShowsStart(Protocol):
    """A body whose velocities follow from what acts on it."""

    def show_start(self, dt: float) -> None:
        """Before the first step dt [s], whose conditions are set: show the velocities at the start."""
