"""Element quality: dihedral angles, a quality number for each element, and the few elements that limit the time step."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.meshes.surface_mesh import Mesh

_EDGES = ((0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 2, 0), (2, 3, 0, 1))  # an edge, the opposite corners


def dihedral_angles(nodes: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return the angles between the faces of tetrahedra at their six edges [degrees], shape (c, 6); 70.53 if regular.
    nodes: positions, shape (n, 3); cells: node numbers, shape (c, 4)."""
    x = nodes[cells]
    angles = []
    for a, b, c, d in _EDGES:
        along = x[:, b] - x[:, a]
        one, other = np.cross(along, x[:, c] - x[:, a]), np.cross(along, x[:, d] - x[:, a])
        across = np.linalg.norm(np.cross(one, other), axis=1)
        angles.append(np.degrees(np.arctan2(across, np.einsum("ij,ij->i", one, other))))
    return np.stack(angles, axis=1)


def triangle_qualities(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return for each triangle its area divided by its mean squared side length, scaled to 1 if equilateral (0 if flat),
    shape (m,)."""
    x = vertices[triangles]
    area = 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
    return np.asarray(4.0 / np.sqrt(3.0) * area / _mean_square(x, ((0, 1), (1, 2), (2, 0))))


def quad_qualities(vertices: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Return for each quadrilateral twice the smallest triangle area at a corner, divided by the mean squared side length: 1
    for squares, shape (m,)."""
    x = vertices[quads]
    sides = np.roll(x, -1, axis=1) - x
    corners = np.linalg.norm(np.cross(np.roll(sides, 1, axis=1), sides), axis=2).min(axis=1, initial=np.inf)
    return np.asarray(corners / _mean_square(x, ((0, 1), (1, 2), (2, 3), (3, 0))))


def tetrahedron_qualities(nodes: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return for each tetrahedron its volume to the power 2/3 divided by its mean squared edge length, scaled to 1 for
    regular and 0 for flat tetrahedra, shape (c,). nodes: positions, shape (n, 3); cells: node numbers, shape (c, 4)."""
    x = nodes[cells]
    volume = np.abs(np.einsum("ij,ij->i", np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), x[:, 3] - x[:, 0])) / 6.0
    edges = tuple((a, b) for a, b, _, _ in _EDGES)
    return np.asarray((6.0 * np.sqrt(2.0) * volume) ** (2.0 / 3.0) / _mean_square(x, edges))


def _mean_square(places: np.ndarray, sides: tuple[tuple[int, int], ...]) -> np.ndarray:
    """Return the mean squared side length of each element, shape (m,), at least the smallest positive number, so that it
    can be a divisor. places: corner positions, shape (m, corners, 3); sides: pairs of corner indices."""
    squares = [np.square(places[:, a] - places[:, b]).sum(axis=1) for a, b in sides]
    return np.maximum(np.mean(squares, axis=0), np.finfo(float).tiny)


MUCH = 5.0  # factor by which the bad elements must reduce the time step
FEW = 0.01  # largest fraction of bad elements


class Slowest(NamedTuple):
    """The smallest set of elements without which the stable time step is more than five times (`MUCH`) as long."""

    elements: np.ndarray  # indices of the elements, worst first
    times: float  # ratio of the stable time step without these elements to the actual one


def rates_of_surface(mesh: Mesh) -> np.ndarray:
    """Return half the largest angular eigenfrequency of each element divided by its wave speed c [1/m], shape (m,):
    quadrilaterals, then triangles.

    An element limits the time step by a frequency proportional to c √Σ|∇N_K|², with the shape functions N_K of its nodes.
    """
    quads, triangles = mesh.vertices[mesh.quads], mesh.vertices[mesh.triangles]
    one, other = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
    edges = triangles - np.roll(triangles, 1, axis=1)
    of_quads = 2.0 * (_squares(one) + _squares(other)) / _squares(np.cross(one, other))
    of_triangles = 0.75 * _squares(edges).sum(axis=1) / _squares(np.cross(edges[:, 0], edges[:, 1]))
    return np.sqrt(np.concatenate([of_quads, of_triangles]))


def slowest_of_surface(mesh: Mesh) -> Slowest | None:
    """Return the few quadrilaterals and triangles without which the stable time step would be more than five times (`MUCH`) as
    long, found from their eigenfrequencies; None if there are no such elements."""
    rates = rates_of_surface(mesh)
    worst = np.argsort(-rates, kind="stable")
    return _fewest(worst, lambda count: float(rates[worst[count]]))


def slowest_of_solid(mesh: SimplexMesh) -> Slowest | None:
    """Return the few linear tetrahedra without which the stable time step would be more than five times (`MUCH`) as long; None
    if there are no such elements.

    The squared frequency of node a is bounded by a multiple of Σ_e V |∇N_a| Σ_b |∇N_b| / V_a over its elements e with volumes V
    and nodes b, with the shape functions N; V_a is the volume of the node.
    """
    corners, volumes, n = mesh.nodes[mesh.cells], np.abs(mesh.volumes), len(mesh.nodes)
    slopes = np.empty((len(corners), 4))  # |∇N_a|: area of the opposite face over three times the volume
    for a in range(4):
        b, c, d = (corners[:, (a + k) % 4] for k in (1, 2, 3))
        slopes[:, a] = 0.5 * np.linalg.norm(np.cross(c - b, d - b), axis=1) / (3.0 * volumes)
    rows = volumes[:, None] * slopes * slopes.sum(axis=1)[:, None]
    about = np.bincount(mesh.cells.ravel(), np.repeat(0.25 * volumes, 4), n)
    own = rows / about[mesh.cells]
    worst = np.argsort(-own.max(axis=1), kind="stable")

    def without(count: int) -> float:
        kept = worst[count:]
        sums = np.bincount(mesh.cells[kept].ravel(), rows[kept].ravel(), n)
        return float(np.sqrt((sums / about).max()))

    return _fewest(worst, without)


def _fewest(worst: np.ndarray, without: Callable[[int], float]) -> Slowest | None:
    """Return the fewest elements without which the stable time step is more than five times (`MUCH`) as long, found by
    bisection; None if there are no such elements.

    worst: elements, worst first; without: returns the rate that limits the time step (up to a constant factor) if the given
    number of worst elements is removed.
    """
    most = min(max(1, int(FEW * len(worst))), len(worst) - 1)
    whole = without(0)
    if most < 1 or whole <= MUCH * without(most):
        return None
    low, high = 0, most
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if whole > MUCH * without(middle) else (middle, high)
    return Slowest(worst[:high], whole / without(high))


def step_warning(name: str, found: Slowest, centres: np.ndarray) -> str:
    """Return the warning that the few elements in `found` reduce the stable time step of body `name`. centres: centres of
    all elements [m], shape (m, 3)."""
    first = int(found.elements[0])
    place = ", ".join(f"{value:.4g}" for value in centres[first])
    count = len(found.elements)
    which = f"element {first}" if count == 1 else f"{count} elements, the worst of which is"
    number = "" if count == 1 else f" number {first}"
    return (
        f"the stable time step of body {name} is {found.times:.2g} times smaller than without {which}{number} (counted from 0, "
        f"of {len(centres)}), at ({place}) m, which is very flat or short; improve the mesh there, or make it coarser"
    )


def _squares(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(np.sum(vectors * vectors, axis=-1))
