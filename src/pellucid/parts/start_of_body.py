"""The geometry and motion of a body at the start, as its model in a case states them."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Self

import numpy as np

from pellucid.findings import Reason
from pellucid.geometry.region import Selectable, within
from pellucid.geometry.shapes.contract import Geometry
from pellucid.grid.model import GridCase
from pellucid.model import Vector
from pellucid.parts.part import Part


class Standing(NamedTuple):
    """Initial positions of the n points of a body."""

    position: np.ndarray
    """Positions of the points [m], shape (n, 3)."""
    triangles: np.ndarray | None = None
    """Triangles of a membrane, shape (m, 3), as point numbers."""
    volume: np.ndarray | None = None
    """Volumes of the points [m³], shape (n,), if they are more accurate than the shape of the body."""


if TYPE_CHECKING:
    from pellucid.parts.body_model import BodyModel


class StartOfBody(Part):
    """Base class of the models of bodies: the state at the start."""

    place: ClassVar[str]
    """Name of the key that defines the initial geometry of the body."""
    start_only: ClassVar[tuple[str, ...]] = ("velocity", "initial")
    """Keys of the initial state, in addition to `place`; for a body that continues an earlier run, the state comes from
    that run."""
    strained_from_place: ClassVar[bool] = True
    """True if strains are measured from the geometry in the case, also for a body that continues an earlier run."""

    @abstractmethod
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lower and upper corner of the body's bounding box at the start [m], each of shape (3,)."""

    def standing(self, grid: GridCase) -> Standing:
        """Return the initial positions of the points on the grid; without points if the positions are known only when the
        body is built. Raises CaseError if the body cannot be placed."""
        return Standing(np.zeros((0, 3)))

    @abstractmethod
    def occupied(self) -> Geometry | None:
        """Return the initial region of the body, which other bodies can exclude from theirs; None if there is none."""

    @abstractmethod
    def n_points(self, grid: GridCase | None) -> float:
        """Return the number of points of the body, accurate to one layer of points; grid: None if the case has no grid."""

    @abstractmethod
    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        """Return the initial velocities [m/s], shape (n, 3), at positions [m], shape (n, 3)."""

    def touching_places(self, grid: GridCase, hard: bool) -> np.ndarray:
        """Return the initial positions at which other bodies can touch this body first [m], shape (m, 3); hard: True if this
        body does not deform; grid: table of the grid."""
        return self.standing(grid).position

    def faces_pressed(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Return centres [m], shape (m, 3), and outward vector areas [m²], shape (m, 3), and edge lengths [m], shape (m,), of
        the faces of the body on which pressure acts.

        Returns None if pressure acts on the body through cells of the grid instead.
        """
        return None

    def selectable(self) -> Selectable | None:
        """Return the initial nodes and faces from which regions in the case select; None if they are known only when the body
        is built."""
        return None

    @property
    def has_triangles(self) -> bool:
        """True if the body has a triangulated surface, whose area and enclosed volume probes can read."""
        return False

    def contains(self, places: np.ndarray, active: tuple[bool, bool, bool], periods: Vector = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Return a mask of the positions [m], shape (n, 3), that are inside the body at the start along the `active` axes,
        shape (n,).

        periods: periods of the grid [m], see `GridCase.periods`.
        """
        region = self.occupied()
        return np.zeros(len(places), bool) if region is None else within(region, places, active, periods)

    def excluded_bodies(self) -> tuple[str, ...]:
        """Return the names of the bodies whose regions this body excludes from its own."""
        return ()

    def why_not_excluded(self, grid: GridCase | None) -> Reason | None:
        """Return the reason why another body cannot exclude the region of this body from its own, or None; grid: None if the
        case has none."""
        return None

    def with_others(self, bodies: "Sequence[BodyModel]") -> Self:
        """Return the model with access to the other bodies of the case, whose regions it may exclude from its own."""
        return self

    def fastest_at_start(self, places: np.ndarray) -> float:
        """Return the largest initial speed of the body [m/s] at positions [m], shape (n, 3)."""
        velocity = self.initial_velocity(places)
        return float(np.sqrt(np.max(np.sum(velocity * velocity, axis=1))))

    def places_between_bounds(self) -> np.ndarray:
        """Return the points of a regular lattice that spans the bounding box of the body [m], 9 along each axis, shape
        (729, 3)."""
        lower, upper = self.bounds()
        share = np.stack(np.meshgrid(*3 * [np.linspace(0.0, 1.0, 9)], indexing="ij"), axis=-1).reshape(-1, 3)
        return np.asarray(lower + share * (upper - lower))
