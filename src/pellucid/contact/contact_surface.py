"""Contact surface of a body: points with positions, areas and velocities, on which contact forces act."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from math import sqrt
from typing import NamedTuple, Protocol

import numpy as np
from scipy import sparse

from pellucid.jit import kernel

FULL, NONE = 0.75, 0.25  # of the weights of a plane that goes on: from when a point counts wholly, and down to when at all


class Response(Protocol):
    """Motion of the m points of a surface in a step, by n nodes."""

    shares: sparse.csr_array
    """Shares of the nodes in the points, shape (m, n)."""

    def velocities(self, dt: float, pushed: np.ndarray | None) -> np.ndarray:
        """Return the velocities of the points at the end of a step dt [s] [m/s], shape (m, 3).

        pushed: forces of contact on the points [N], shape (m, 3).
        """

    def answers(self, dt: float) -> np.ndarray:
        """Return the changes of nodal velocities over a step dt [s] by unit forces on the nodes [m/s/N], shape (n, 3)."""


class MovingTriangles(NamedTuple):
    """Triangles between n vertices that move, for contact of surfaces of triangles."""

    triangles: np.ndarray  # (T, 3) vertices, counterclockwise as seen from outside
    places: Callable[[], np.ndarray]  # of the vertices [m], (n, 3)
    velocities: Callable[[], np.ndarray]  # [m/s], (n, 3)
    add_forces: Callable[[np.ndarray], None]  # adds forces on the vertices over a step [N], (n, 3)
    depth: float = 1.0  # area of what they stand for, over their own: in a plane of a slice, over that of a cell
    response: Response | None = None  # motion of the vertices in a step, where it is known before contact


class ContactSurface(ABC):
    """m points on the surface of a body.

    place [m], area (vectors, outwards) [m²], velocity [m/s]: shape (m, 3), of the state as a step begins. slip: how far each
    is carried from where it stuck to another surface [m], shape (m, 3). reach: how far along the surface a point stands for it
    [m], shape (m,).
    """

    body = ""
    """Name of the body."""
    two_sided = False
    """True if other bodies can touch it from both sides: a membrane."""
    half_width: float | np.ndarray = 0.0
    """Distance by which the body extends beyond its points, or beyond each of them [m]."""
    mass_per_area: float
    """Mass per area that moves with the surface at once [kg/m²]."""
    rate: float
    """Largest oscillation rate: the inverse of the largest step of the body [1/s]."""
    is_plane = False
    """True in a plane problem, where nothing varies across the slice."""
    follows_steps = True
    """True if contact springs may be as stiff as the steps of the case can resolve; False if only at its rate."""
    rigid_mass = np.inf
    """Mass of a rigid body [kg]; infinite if its motion is prescribed."""
    is_hard = False
    """True if it does not deform: it is rigid, or its motion is prescribed."""
    serves_deformed = False
    """True if a deforming body uses it for contact; otherwise contact is on the nodes."""
    least_rate, swings = 0.0, 0.0
    """How fast a rigid body swings that lies or falls on others by itself [1/s]; the square of that where it is now [1/s²]."""
    stands = False
    """True if it has not moved since the start of the previous step."""
    pushed_along: list[np.ndarray]
    """Unit vectors along which the overlaps push a rigid body in which it is in this step, (3,) each."""
    n_edge_points = 0
    """Of the points the last ones, which lie on sharp edges and corners of a body that does not deform. They have no area, and
    count in contact with others that do not deform alone, whichever way their faces look."""
    edge_tangent = np.zeros((0, 3))
    """Unit vectors along the edges at these points, zero at corners, shape (n_edge_points, 3)."""
    on_flat_side: np.ndarray
    """Mask of points on flat sides, shape (m,); of bodies with edge points."""
    faces: np.ndarray | None = None
    """Three points of each plane that bounds the body, counterclockwise as seen from outside, in a plane two and -1; None where
    it is not convex, or not bounded by planes alone. Shape (k, 3)."""
    thin_axis: np.ndarray
    """Unit vector of the axis that is thin in a plane, (3,); for planes of `faces` there."""
    stops_at_once = False
    """True if all contacts of a rigid body use one damper for each point in this step, so that they are solved together."""
    pushed: np.ndarray
    """Change of the push of these contacts on the body in this step, in the terms of `mobility_rows`, (6,)."""
    drag: np.ndarray | None = None
    """Of a fluid, whose points do not know how far they were carried: how each resists sliding as long as friction does not
    limit it [kg/s], shape (m,)."""
    response: Response | None = None
    """Motion of the points in a step by the forces on the nodes, where these are known before contact; None elsewhere."""
    triangles: MovingTriangles | None = None
    """Triangles of the surface; None of one that is known by points alone."""
    of_itself: Mapping[str, np.ndarray] = {}
    """Arrays of the contact of the surface with itself, by name, which belong to the state of its body."""
    place: np.ndarray
    area: np.ndarray
    velocity: np.ndarray
    reach: np.ndarray
    slip: np.ndarray

    @property
    def is_sheet(self) -> bool:
        """True for a membrane that deforms."""
        return self.two_sided and not self.is_hard

    def corner_shares(self) -> sparse.csr_array | None:
        """Return the shares of the corners in the points, shape (m, corners); None where each point is a corner."""
        return None

    def begin(self) -> None:  # noqa: B027
        """Update the points from the state of the body. Called before contact of a step is found."""

    def end_at(self, faces: Sequence[tuple[int, float]]) -> None:  # noqa: B027
        """Have no surface on faces of the grid through which points leave, each across an axis at a place [m]: there what it
        touches goes on, and it does so itself."""

    def sizes(self) -> np.ndarray:
        """The areas of the points [m²], shape (m,)."""
        return np.asarray(np.linalg.norm(self.area, axis=1))

    def weights(self) -> np.ndarray:
        """The areas by which the points count in forces [m²], shape (m,): where a body deforms those of the start, so that the
        energy of an overlap does not change as areas do."""
        return self.sizes()

    def normals(self) -> np.ndarray:
        """Unit normals of the points, shape (m, 3), zero where they have no area; at edges the means of both faces."""
        normal = np.empty_like(self.area)
        self.find_directions(normal, np.empty(len(normal)))
        return normal

    def find_directions(self, normal: np.ndarray, size: np.ndarray) -> None:
        """Find the `normals` and `sizes` of the points."""
        _find_directions(self.area, normal, size)

    def side(self) -> float:
        """The area of the largest of its sides along the axes [m²]."""
        return float(max(np.maximum(sign * self.area, 0.0).sum(axis=0).max() for sign in (1.0, -1.0)))

    def bearing_area(self) -> float:
        """The area by which it counts as it lies on its largest side [m²], with half of its edges."""
        n = len(self.place) - self.n_edge_points
        return self.side() + 0.5 * float(self.weights()[n:].sum())

    def planes(self) -> tuple[np.ndarray, np.ndarray]:
        """The outward unit normals of its `faces`, shape (k, 3), and their places along these [m], shape (k,)."""
        if self.faces is None:
            raise ValueError("planes do not bound the body")
        first, second, third = (self.place[self.faces[:, column]] for column in range(3))
        across = third - first
        in_plane = self.faces[:, 2] < 0
        across[in_plane] = self.thin_axis
        normal = np.cross(second - first, across)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        return normal, np.einsum("ij,ij->i", normal, first)

    def edges(self) -> np.ndarray:
        """Longest edges of the elements about each point of a sheet [m], shape (m,)."""
        return np.zeros(len(self.place))

    def speed(self) -> float:
        """The largest of its points [m/s]."""
        return float(np.linalg.norm(self.velocity, axis=1).max())

    def contact_rate(self) -> float:
        """Return the oscillation rate of a rigid body on its contacts, which limits the step [1/s]. It is larger than the
        body's own rate if others press it or if it rotates in an impact; the step has room for half of such a stiffness."""
        return max(self.least_rate, sqrt(0.5 * self.swings))

    def mobility_along(self, place: np.ndarray, force: np.ndarray) -> float:
        """Σ f·a for the accelerations a at places [m] that forces f there give a rigid body, shape (m, 3) each [N²/kg]; of one
        whose motion is prescribed, none."""
        return 0.0

    def mobility_rows(self, place: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Return rows z of shape (m, 6) for forces at places [m], shape (m, 3) each.

        z_i·z_j is the change of the velocity along force i that force j causes in a unit of time [N²/kg].
        """
        return np.zeros((len(place), 6))

    def turning(self, place: np.ndarray) -> np.ndarray:
        """Velocities at places [m] by the rotation of a rigid body [m/s], shape (m, 3) each; of others none."""
        return np.zeros_like(place)

    def contact_warning(self, places: np.ndarray) -> str | None:
        """Return a warning if it is too coarse where its points overlap with others, at places [m], shape (n, 3), or None."""
        return None

    @abstractmethod
    def add_forces(self, force: np.ndarray) -> None:
        """Forces on the points over this step [N], shape (m, 3)."""

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        """Return the arrays for a checkpoint."""
        return {"surface/slip": self.slip} | {f"surface/itself/{name}": array for name, array in self.of_itself.items()}

    def go_on(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Begin as an earlier run ended, where that had this surface; else from where the body is, without friction."""
        own = self.state_arrays()
        if all(name in arrays and arrays[name].shape == array.shape for name, array in own.items()):
            self.restore(arrays)

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore a checkpoint."""
        for name, array in self.state_arrays().items():
            array[...] = arrays[name]


@kernel()
def _find_directions(area, normal, size):
    for p in range(len(area)):
        a, b, c = area[p, 0], area[p, 1], area[p, 2]
        size[p] = sqrt(a * a + b * b + c * c)
        scale = 1.0 / size[p] if size[p] > 0.0 else 0.0
        normal[p, 0], normal[p, 1], normal[p, 2] = scale * a, scale * b, scale * c
