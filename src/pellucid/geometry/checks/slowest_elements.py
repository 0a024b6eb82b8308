"""A few elements that make the stable step of a mesh much smaller than the others would."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.meshes.surface_mesh import Mesh

MUCH = 5.0  # times smaller
FEW = 0.01  # of the elements


class Slowest(NamedTuple):
    """The fewest elements, the worst first, without which the stable step is more than `MUCH` times larger."""

    elements: np.ndarray
    times: float  # larger


def rates_of_surface(mesh: Mesh) -> np.ndarray:
    """Half the largest eigenfrequency of each quadrilateral, then triangle, over the speed c of waves in it [1/m], shape (m,):
    each bounds the step by its own, c √Σ|∇N_K|² but for a factor."""
    quads, triangles = mesh.vertices[mesh.quads], mesh.vertices[mesh.triangles]
    one, other = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
    edges = triangles - np.roll(triangles, 1, axis=1)
    of_quads = 2.0 * (_squares(one) + _squares(other)) / _squares(np.cross(one, other))
    of_triangles = 0.75 * _squares(edges).sum(axis=1) / _squares(np.cross(edges[:, 0], edges[:, 1]))
    return np.sqrt(np.concatenate([of_quads, of_triangles]))


def slowest_of_surface(mesh: Mesh) -> Slowest | None:
    """The slowest quadrilaterals and triangles, by their own frequencies."""
    rates = rates_of_surface(mesh)
    worst = np.argsort(-rates, kind="stable")
    return _fewest(worst, lambda count: float(rates[worst[count]]))


def slowest_of_solid(mesh: SimplexMesh) -> Slowest | None:
    """Tetrahedra with linear functions, by the bound on the frequencies of the nodes a, Σ_e V |∇N_a| Σ_b |∇N_b| / V_a."""
    corners, volumes, n = mesh.nodes[mesh.cells], np.abs(mesh.volumes), len(mesh.nodes)
    slopes = np.empty((len(corners), 4))  # |∇N_a|, the area of the face across over three volumes
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
    """worst: elements, the worst first; without: the rate that bounds the step [1/s] without so many, which falls with them."""
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
    """The warning about body `name`; centres: of all its elements [m], shape (m, 3)."""
    first = int(found.elements[0])
    place = ", ".join(f"{value:.4g}" for value in centres[first])
    count = len(found.elements)
    which = f"element {first}" if count == 1 else f"{count} elements, the worst of which is"
    number = "" if count == 1 else f" number {first}"
    return (
        f"the stable step of body {name} is {found.times:.2g} times smaller than without {which}{number} (counted from 0, of "
        f"{len(centres)}), at ({place}) m: it is very flat or short; mend the mesh there, or make it coarser"
    )


def _squares(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(np.sum(vectors * vectors, axis=-1))
