"""Closed surfaces in space by Loop's subdivision: functions with square-integrable curvature, as required for bending.

The nodes are control points; the surface passes near them.
"""

from collections.abc import Mapping

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from pellucid.bodies.fluid_film.surfaces import loop_patch as patch
from pellucid.bodies.fluid_film.surfaces.triangle_operators import SurfaceTables
from pellucid.bodies.fluid_film.surfaces.triangle_surface import THREE, TriangleRule, TriangleSurface
from pellucid.geometry.meshes.triangulation import Rings
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_loop

CHUNK = 128  # points


class LoopSurface(TriangleSurface):
    """A closed surface by Loop's subdivision with n control points; three quadrature points per triangle (`rule`) are
    sufficient.
    """

    def __init__(self, triangles: np.ndarray, n: int, rule: TriangleRule = THREE) -> None:
        super().__init__(triangles, n, rule)
        valences = self.rings.valence[triangles]
        if ((valences == 3) & (np.roll(valences, 1, axis=1) == 3)).any():
            raise ValueError("two neighbouring nodes have three neighbours each: the surface is a tetrahedron; refine it")
        kinds, kind = np.unique(valences, axis=0, return_inverse=True)
        kind = kind.reshape(-1)
        m = int(kinds.sum(axis=1).max()) - 6
        self.nodes = _slot_nodes(self.rings, kinds, kind, m)
        functions = np.stack([_functions(valence, rule.shares, m) for valence in kinds])
        value, first, second = functions[:, :, 0].copy(), functions[:, :, 1:3].copy(), functions[:, :, 3:].copy()
        self.tables = SurfaceTables(kind, value, first, second, 0.5 * rule.weights)
        self._limit = limit_matrix(self.rings)
        self._inverse = splu(self._limit.tocsc())

    def places(self, x: np.ndarray) -> np.ndarray:
        return np.asarray(self._limit @ x)

    def through(self, places: np.ndarray) -> np.ndarray:
        return np.asarray(self._inverse.solve(np.array(places, dtype=float)))

    def at(self, x: np.ndarray, triangle: np.ndarray, share: np.ndarray) -> np.ndarray:
        result = np.empty((len(triangle), 3))
        chunks = -(-len(triangle) // CHUNK)
        _evaluate(chunks, np.ascontiguousarray(x), self.rings, triangle, share, patch.BOX_SPLINES, patch.POWERS, result)
        return result

    def renew(self, x: np.ndarray) -> None:
        """Do nothing: the functions depend on the triangles only."""

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Do nothing: the surface has no arrays."""


def limit_matrix(mesh: Rings) -> csr_array:
    """Return the matrix that maps control points to their limit positions on the Loop surface, shape (n, n). mesh: the
    triangles around each control point.
    """
    n = len(mesh.valence)
    share = np.array([patch.limit_share(int(valence)) if valence else 0.0 for valence in range(mesh.valence.max() + 1)])
    turn = np.arange(mesh.ring.shape[1])
    row, column = np.nonzero(turn < mesh.valence[:, None])
    neighbour = mesh.neighbours[row, column]
    own = 1.0 - share[mesh.valence] * mesh.valence
    rows, columns = np.concatenate([row, np.arange(n)]), np.concatenate([neighbour, np.arange(n)])
    return csr_array((np.concatenate([share[mesh.valence[row]], own]), (rows, columns)), shape=(n, n))


def _slot_nodes(mesh: Rings, kinds: np.ndarray, kind: np.ndarray, m: int) -> np.ndarray:
    """Return the nodes on whose positions the Loop surface on each of e triangles depends, shape (e, m): the corners of the
    triangle, then the other nodes around the corners, then repetitions of the first corner.

    mesh: the triangles and the nodes around each node; kinds: numbers of neighbours of the three corners for each kind of
    triangle, shape (kinds, 3); kind: kind of each triangle, shape (e,).
    """
    nodes = np.repeat(mesh.triangles[:, :1], m, axis=1)
    nodes[:, :3] = mesh.triangles
    for number, valences in enumerate(kinds):
        mine, slot = np.flatnonzero(kind == number), 3
        for corner, valence in enumerate(valences.tolist()):
            own = valence - 3
            nodes[mine, slot : slot + own] = mesh.ring[3 * mine + corner, 2 : 2 + own]
            slot += own
    return nodes


def _slots(valences: list[int]) -> list[list[int]]:
    """Return, for each corner of a triangle of a Loop surface, the positions of the nodes around the corner in the list of
    all nodes on which the surface on the triangle depends (see `_slot_nodes`). valences: numbers of neighbours of the
    corners."""
    first = [3, valences[0], valences[0] + valences[1] - 3]
    rings_of: list[list[int]] = []
    for c in range(3):
        after = (c + 1) % 3
        across = after if valences[after] > 3 else (c + 2) % 3  # with three neighbours it shares its only one with the next
        own = range(first[c], first[c] + valences[c] - 3)
        rings_of.append([after, (c + 2) % 3, *own, first[across]])
    return rings_of


def _functions(valences: np.ndarray, shares: np.ndarray, m: int) -> np.ndarray:
    """Return the values and derivatives of the m shape functions of a triangle of a Loop surface at barycentric coordinates
    `shares`, shape (q, 3), as an array of shape (q, 6, m): value, 2 first and 3 second derivatives with respect to the
    coordinates of corners 1 and 2. valences: numbers of neighbours of the corners, shape (3,).
    """
    slots = _slots(valences.tolist())
    ring = np.zeros((3, max(patch.REGULAR, int(valences.max())), m))
    for c, own in enumerate(slots):
        ring[c, np.arange(len(own)), own] = 1.0
    result = np.zeros((len(shares), patch.COUNT, m))
    for number, share in enumerate(shares):
        _evaluate_one(np.eye(3, m), ring.copy(), valences.copy(), share.copy(), patch.BOX_SPLINES, patch.POWERS, result[number])
    return result


@kernel()
def _evaluate_one(corner, ring, count, share, factors, powers, out):
    patch.evaluate(corner, ring, count, share, factors, powers, out)


@parallel_loop(allocates=True)
def _evaluate(chunk, x, mesh, triangle, share, factors, powers, result):
    ring, corner = np.zeros((3, max(mesh.ring.shape[1], patch.REGULAR), 3)), np.zeros((3, 3))
    count, out = np.zeros(3, np.int64), np.zeros((patch.COUNT, 3))
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(triangle))):
        for c in range(3):
            node = mesh.triangles[triangle[p], c]
            count[c], corner[c] = mesh.valence[node], x[node]
            for k in range(count[c]):
                ring[c, k] = x[mesh.ring[3 * triangle[p] + c, k]]
        patch.evaluate(corner, ring, count, share[p].copy(), factors, powers, out)
        result[p] = out[patch.VALUE]
