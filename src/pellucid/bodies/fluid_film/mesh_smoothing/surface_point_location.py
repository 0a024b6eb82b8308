"""Point location on a surface of triangles: the positions at given displacements along the surface from its nodes."""

from collections.abc import Callable

import numpy as np

from pellucid.geometry.meshes.triangulation import Rings, vertex_normals
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_loop

CHUNK = 256  # nodes
APPROACHES = 3  # iterations: distances along a surface differ from those in its parameters


def places_along(
    mesh: Rings, places: np.ndarray, way: np.ndarray, at: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """Return the points of the surface at displacements `way` [m] along it from the nodes, shape (n, 3); no displacement may
    exceed the distance to a neighbour.

    mesh: triangles around the nodes; places: nodal positions [m], shape (n, 3); at: function that returns points of the
    surface [m], shape (n, 3), from triangle numbers, shape (n,), and barycentric coordinates, shape (n, 3).
    """
    n = len(places)
    normal, aim = vertex_normals(places, mesh.triangles), way
    triangle, share = np.zeros(n, np.int64), np.zeros((n, 3))
    found = places
    for _ in range(APPROACHES):
        _locate(-(-n // CHUNK), mesh, np.ascontiguousarray(places), normal, np.ascontiguousarray(aim), triangle, share)
        found = at(triangle, share)
        aim = aim + way - (found - places)
    return found


@kernel(inner=True)
def _triple(a, b, c):
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    return x * c[0] + y * c[1] + z * c[2]


@parallel_loop(allocates=True)
def _locate(chunk, mesh, places, normal, aim, triangle, share):
    """Find, for the nodes of a chunk, the triangle around each node that contains the end point of its displacement,
    projected along the normal, and the barycentric coordinates of this point.

    mesh: triangles around the nodes; places, normal: positions [m] and unit normals of the nodes, shape (n, 3); aim:
    displacements [m], shape (n, 3); triangle, share: the results, shape (n,) and (n, 3).
    """
    for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(places))):
        half, best, a, b = mesh.out[i], -np.inf, 0.0, 0.0
        found, n, d = half, normal[i], aim[i]
        for _ in range(mesh.valence[i]):
            here, c = half // 3, half % 3
            u = places[mesh.triangles[here, (c + 1) % 3]] - places[i]
            v = places[mesh.triangles[here, (c + 2) % 3]] - places[i]
            whole = _triple(u, v, n)
            s, t = _triple(d, v, n) / whole, _triple(u, d, n) / whole  # d = s u + t v
            if min(s, t) > best:
                best, found, a, b = min(s, t), half, s, t
            half = mesh.twin[3 * here + (c + 2) % 3]
        a, b = max(a, 0.0), max(b, 0.0)
        if a + b > 1.0:
            a, b = a / (a + b), b / (a + b)
        c = found % 3
        triangle[i] = found // 3
        share[i, c], share[i, (c + 1) % 3], share[i, (c + 2) % 3] = 1.0 - a - b, a, b
