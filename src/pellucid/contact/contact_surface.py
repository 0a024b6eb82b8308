"""Contact surface of a body: points with positions, areas and velocities, on which contact forces act."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from math import sqrt
from typing import NamedTuple, Protocol

import numpy as np
from scipy import sparse

from pellucid.jit import kernel

FULL_CONTACT, NO_CONTACT = 0.75, 0.25  # ratio of the weights to those of an unlimited plane: full contact above, none below


class Response(Protocol):
    """Model of the motion of m surface points under contact forces in a step, for implicit contact forces. The motion of
    the points follows from n nodes, whose nodal forces are known before contact."""

    shares: sparse.csr_array
    """Weights of the nodes in the motion of the points, shape (m, n)."""

    def velocities(self, dt: float, pushed: np.ndarray | None) -> np.ndarray:
        """Return the velocities of the points at the end of a step of length dt [s], shape (m, 3) [m/s].

        pushed: contact forces on the points [N], shape (m, 3); None for no forces.
        """

    def answers(self, dt: float) -> np.ndarray:
        """Return the change of each nodal velocity over a step dt [s] per unit force on the node [m/s/N], shape (n, 3)."""


class MovingTriangles(NamedTuple):
    """Moving triangles with n vertices, for contact between triangulated surfaces."""

    triangles: np.ndarray  # (T, 3) vertices, counterclockwise as seen from outside
    places: Callable[[], np.ndarray]  # returns the positions of the vertices [m], (n, 3)
    velocities: Callable[[], np.ndarray]  # returns the velocities of the vertices [m/s], (n, 3)
    add_forces: Callable[[np.ndarray], None]  # applies forces to the vertices for a step [N], (n, 3)
    depth: float = 1.0  # ratio of contact area to triangle area: in a plane problem, slice thickness over cell size
    response: Response | None = None  # response of the vertices to forces; None if unknown before contact


class ContactSurface(ABC):
    """Contact surface of a body: m points, with data at the start of a step.

    Arrays of shape (m, 3): `place`, positions [m]; `area`, outward area vectors [m²]; `velocity` [m/s]; `slip`,
    displacement of each point from the position where friction holds it on another surface [m]. `reach`: radius along the
    surface that each point represents [m], shape (m,).
    """

    body = ""
    """Name of the body."""
    two_sided = False
    """True if other bodies can be in contact on both sides: a membrane."""
    half_width: float | np.ndarray = 0.0
    """Distance by which the body extends beyond its points, one value or one per point [m]."""
    mass_per_area: float
    """Mass per area of the surface layer that moves with the surface without delay [kg/m²]."""
    rate: float
    """Largest oscillation rate: the inverse of the largest step of the body [1/s]."""
    is_plane = False
    """True in a plane problem, i.e. all fields are constant across the slice."""
    follows_steps = True
    """True if contact springs may be as stiff as the step size of the case allows; False if `rate` defines their stiffness."""
    damping = 0.1
    """Damping ratio of contact, for the mass of the layer that moves with the surface."""
    stiffness_range = (0.0, np.inf)
    """Smallest and largest stiffness of explicit contact springs that follow the step size [Pa/m]."""
    rigid_mass = np.inf
    """Mass of a rigid body [kg]; infinite if its motion is prescribed."""
    is_hard = False
    """True if the body does not deform: it is rigid or its motion is fully prescribed."""
    serves_deformed = False
    """True if a deforming body uses this surface for contact; False if contact is on the nodes of the grid."""
    least_rate, swings = 0.0, 0.0
    """`least_rate`: oscillation rate of a rigid body that rests on or falls onto others without other forces [1/s].
    `swings`: square of the current oscillation rate [1/s²]."""
    stands = False
    """True if the surface has not moved since the start of the previous step."""
    pushed_along: list[np.ndarray]
    """Unit vectors along which the overlaps of this step push a rigid body, each of shape (3,)."""
    n_edge_points = 0
    """Number of points on sharp edges and corners of a body that does not deform; they are the last points.

    Edge points have no area. They are used only for contact with another body that does not deform, regardless of the
    direction of the adjacent faces.
    """
    edge_tangent = np.zeros((0, 3))
    """Unit vectors along the edges at the edge points, shape (n_edge_points, 3); zero at corners."""
    on_flat_side: np.ndarray
    """Mask of points on flat sides, shape (m,); defined only for bodies with edge points."""
    faces: np.ndarray | None = None
    """Indices of three points on each bounding plane, counterclockwise as seen from outside, shape (k, 3).

    In a plane problem: two points and -1. None if the body is not convex or not bounded by planes alone.
    """
    thin_axis: np.ndarray
    """Unit vector along the thin axis of a plane problem, shape (3,); used to construct the planes of `faces`."""
    stops_at_once = False
    """True if, in this step, every contact of a rigid body has one damper per point; these contacts are solved together."""
    pushed: np.ndarray
    """Sum Σ f z of the changes f of forces on the body in this step by contacts with one damper per point, with the vectors
    z of `mobility_rows`, shape (6,)."""
    drag: np.ndarray | None = None
    """Drag coefficients of a fluid surface [kg/s], shape (m,); None for other bodies.

    The points of a fluid do not store a slip. Each one resists sliding with this coefficient, up to the friction limit.
    """
    response: Response | None = None
    """Response of the points to forces in a step; None if the nodal forces are not known before contact."""
    triangles: MovingTriangles | None = None
    """Triangles of the surface; None if the surface consists of points only."""
    of_itself: Mapping[str, np.ndarray] = {}
    """Arrays of self-contact by name; they are stored with the state of the body."""
    place: np.ndarray
    area: np.ndarray
    velocity: np.ndarray
    reach: np.ndarray
    slip: np.ndarray

    @property
    def is_sheet(self) -> bool:
        """True if the body is a membrane that deforms."""
        return self.two_sided and not self.is_hard

    def corner_shares(self) -> sparse.csr_array | None:
        """Return the weights of the corners (mesh vertices) in the position of each point, shape (m, corners); None if
        each point is a corner."""
        return None

    def node_shares(self) -> sparse.csr_array:
        """Return the weights of the n nodes of a body with its own nodes in the motion of the points, shape (m, n).

        Raises ValueError for other bodies.
        """
        raise ValueError(f"body {self.body} has no own nodes")

    def begin(self) -> None:  # noqa: B027
        """Update the points from the state of the body. Called before contact detection in each step."""

    def end_at(self, faces: Sequence[tuple[int, float]]) -> None:  # noqa: B027
        """Exclude the surface points at faces of the grid through which material points leave, since the body, and bodies
        in contact with it, continue beyond these faces.

        faces: axis and position [m] of each face.
        """

    def sizes(self) -> np.ndarray:
        """Return the areas of the points [m²], shape (m,)."""
        return np.asarray(np.linalg.norm(self.area, axis=1))

    def weights(self) -> np.ndarray:
        """Return the areas that weight the contact forces [m²], shape (m,).

        For a deforming body the initial areas are returned, so that the energy of an overlap does not change when areas
        change.
        """
        return self.sizes()

    def normals(self) -> np.ndarray:
        """Return the unit normals of the points, shape (m, 3): zero at points without area, the mean normal of both faces
        at an edge."""
        normal = np.empty_like(self.area)
        self.find_directions(normal, np.empty(len(normal)))
        return normal

    def find_directions(self, normal: np.ndarray, size: np.ndarray) -> None:
        """Write the unit normals to `normal`, shape (m, 3), and the areas to `size` [m²], shape (m,)."""
        _find_directions(self.area, normal, size)

    def side(self) -> float:
        """Return the largest of the areas of the body's projections along the three coordinate axes [m²]."""
        return float(max(np.maximum(sign * self.area, 0.0).sum(axis=0).max() for sign in (1.0, -1.0)))

    def bearing_area(self) -> float:
        """Return the effective contact area of a body that rests on its largest side [m²], including half of its edge
        points."""
        n = len(self.place) - self.n_edge_points
        return self.side() + 0.5 * float(self.weights()[n:].sum())

    def planes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return, for each plane of `faces`, the outward unit normal, shape (k, 3), and the position of the plane along
        this normal [m], shape (k,).

        Raises
        ------
        ValueError
            If the body has no `faces`.
        """
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
        """Return the longest element edge at each point of a membrane [m], shape (m,); zeros for other bodies."""
        return np.zeros(len(self.place))

    def speed(self) -> float:
        """Return the largest speed of the points [m/s]."""
        return float(np.linalg.norm(self.velocity, axis=1).max())

    def contact_rate(self) -> float:
        """Return the oscillation rate of a rigid body on its contact springs [1/s], which limits the time step.

        The rate exceeds `least_rate` if other bodies press on the body or if the body rotates in an impact. Only half of
        the current squared rate counts, because the step size has a margin for the rest.
        """
        return max(self.least_rate, sqrt(0.5 * self.swings))

    def mobility_along(self, place: np.ndarray, force: np.ndarray) -> float:
        """Return Σ f·a for the accelerations a that forces f cause at their points of application [N²/kg].

        place: points of application [m], shape (m, 3). force: forces f [N], shape (m, 3). The result is 0 if the motion of
        the body is prescribed.
        """
        return 0.0

    def mobility_rows(self, place: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Return a vector z for each force, shape (m, 6). The product z_i·z_j is the change per unit time that force j
        causes in the velocity along force i, times the magnitude of force i [N²/kg].

        place: points of application [m], shape (m, 3). force: forces [N], shape (m, 3).
        """
        return np.zeros((len(place), 6))

    def turning(self, place: np.ndarray) -> np.ndarray:
        """Return the velocities due to the rotation of a rigid body at points of the body with the positions `place` [m],
        shape (m, 3) [m/s]; zeros for other bodies."""
        return np.zeros_like(place)

    def contact_warning(self, places: np.ndarray) -> str | None:
        """Return a warning if the surface is too coarse at its overlapping points; otherwise None.

        places: positions of the overlapping points [m], shape (n, 3).
        """
        return None

    @abstractmethod
    def add_forces(self, force: np.ndarray) -> None:
        """Apply contact forces to the points for this step.

        force: forces [N], shape (m, 3).
        """

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        """Return the arrays of the surface that a checkpoint stores, by name: the slip of the points and the arrays of
        self-contact."""
        return {"surface/slip": self.slip} | {f"surface/itself/{name}": array for name, array in self.of_itself.items()}

    def go_on(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Continue the surface from `arrays`, the arrays of the body in an earlier run by name. If the arrays of the
        surface are missing there, or differ in shape, the slip stays zero."""
        own = self.state_arrays()
        if all(name in arrays and arrays[name].shape == array.shape for name, array in own.items()):
            self.restore(arrays)

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the surface from the arrays of a checkpoint, named as in the result of `state_arrays`."""
        for name, array in self.state_arrays().items():
            array[...] = arrays[name]


@kernel()
def _find_directions(area, normal, size):
    for p in range(len(area)):
        a, b, c = area[p, 0], area[p, 1], area[p, 2]
        size[p] = sqrt(a * a + b * b + c * c)
        scale = 1.0 / size[p] if size[p] > 0.0 else 0.0
        normal[p, 0], normal[p, 1], normal[p, 2] = scale * a, scale * b, scale * c
