"""Closed surfaces in space by Loop's subdivision: functions with square-integrable curvature, as required for bending.

The nodes are control points; the surface passes near them.

If all corners have six neighbours, it is a box spline of degree 4. Otherwise the triangle is subdivided into four until the
point lies in a triangle whose corners all have six neighbours. Source: Loop 1987 (thesis, University of Utah); Stam 1998,
Evaluation of Loop subdivision surfaces; as finite elements: Cirak, Ortiz & Schröder 2000, Int. J. Numer. Methods Eng. 47,
2039. The ring of a corner begins with the next corner and the previous one, and ends with the node opposite the previous
one.
"""

from collections.abc import Mapping
from math import cos, pi

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from pellucid.bodies.fluid_film.triangle_surface import THREE, SurfaceTables, TriangleRule, TriangleSurface
from pellucid.geometry.meshes.triangulation import Rings
from pellucid.jit import kernel, pointwise
from pellucid.jit.loops import parallel_loop

REGULAR = 6  # neighbours of a regular node
DEEPEST = 30  # subdivisions after which a point counts as the corner
VALUE, FIRST_1, FIRST_2, SECOND_11, SECOND_12, SECOND_22, COUNT = range(7)  # derivatives in the coordinates of corners 1, 2


def _corner_terms() -> list[dict[tuple[int, int, int], float]]:
    """Return the polynomials (times 12) of the box splines of a corner and of three nodes of its ring (the nodes around the
    corner), starting with the node opposite the next corner.

    Keys are the powers of the barycentric coordinates of the corner, the next corner and the previous corner; values are the
    coefficients.
    """
    corner = {(4, 0, 0): 6.0, (2, 1, 1): 60.0, (0, 2, 2): 12.0}
    for a, b in ((1, 2), (2, 1)):
        for powers, factor in (
            ((3, 1, 0), 24),
            ((2, 2, 0), 24),
            ((1, 3, 0), 8),
            ((0, 4, 0), 1),
            ((1, 2, 1), 36),
            ((0, 3, 1), 6),
        ):
            corner[powers[0], powers[a], powers[b]] = float(factor)
    across = {(4, 0, 0): 1.0, (0, 0, 4): 1.0, (2, 0, 2): 12.0, (3, 0, 1): 6.0, (1, 0, 3): 6.0}
    across |= {(3, 1, 0): 2.0, (0, 1, 3): 2.0, (2, 1, 1): 6.0, (1, 1, 2): 6.0}
    return [corner, across, {(4, 0, 0): 1.0, (3, 0, 1): 2.0}, {(4, 0, 0): 1.0, (3, 1, 0): 2.0}]


POWERS = np.array([(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)])


def _box_splines() -> np.ndarray:
    factors = np.zeros((12, len(POWERS)))
    place = {tuple(powers): k for k, powers in enumerate(POWERS.tolist())}
    for c in range(3):
        for k, terms in enumerate(_corner_terms()):
            for powers, factor in terms.items():
                factors[c if k == 0 else 2 + 3 * c + k, place[tuple(np.roll(powers, c).tolist())]] = factor / 12.0
    return factors


BOX_SPLINES = _box_splines()


@pointwise
def share_of_neighbour(valence):
    """Return the weight of each neighbour in the new position of a node in one step of Loop subdivision; valence: number of
    neighbours of the node.
    """
    inner = 0.375 + 0.25 * cos(2.0 * pi / valence)
    return (0.625 - inner * inner) / valence


@pointwise
def limit_share(valence):
    """Return the weight of each neighbour in the limit position of a node on the Loop surface; valence: number of neighbours
    of the node.
    """
    return 1.0 / (0.375 / share_of_neighbour(valence) + valence)


@kernel(inner=True)
def _cut(corner, ring, count, moved, middle):
    """Subdivide a triangle of a Loop surface once: compute the new values at its corners and at the midpoints of the edges from
    the corners to their neighbours.

    corner, ring: values of k components at the corners, shape (3, k), and at the nodes around each corner, shape (3, v, k);
    count: numbers of these nodes, shape (3,); moved, middle: receive the new values at the corners, shape (3, k), and at the
    midpoints, shape (3, v, k).
    """
    k = corner.shape[1]
    for c in range(3):
        n = count[c]
        share = share_of_neighbour(n)
        for i in range(k):
            total = 0.0
            for j in range(n):
                total += ring[c, j, i]
                sides = ring[c, (j + 1) % n, i] + ring[c, (j + n - 1) % n, i]
                middle[c, j, i] = 0.375 * (corner[c, i] + ring[c, j, i]) + 0.125 * sides
            moved[c, i] = (1.0 - n * share) * corner[c, i] + share * total


@kernel(inner=True)
def _child_at_corner(c, corner, ring, count, moved, middle):
    """Replace a triangle of a Loop surface, in place, by the child triangle at corner c, one of four; this corner becomes
    its first one.

    corner, ring, count: values at the corners, (3, k), values at the nodes around each corner, (3, v, k), and numbers of
    these nodes, (3,), which are overwritten; moved, middle: values after one subdivision, from `_cut`.
    """
    d, p = (c + 1) % 3, (c + 2) % 3
    n = count[c]
    for i in range(corner.shape[1]):
        corner[0, i], corner[1, i], corner[2, i] = moved[c, i], middle[c, 0, i], middle[c, 1, i]
        for j in range(n):
            ring[0, j, i] = middle[c, j, i]
        ring[1, 0, i], ring[1, 1, i], ring[1, 2, i] = middle[c, 1, i], moved[c, i], middle[c, n - 1, i]
        ring[1, 3, i], ring[1, 4, i], ring[1, 5, i] = middle[d, 2, i], moved[d, i], middle[d, 0, i]
        ring[2, 0, i], ring[2, 1, i], ring[2, 2, i] = moved[c, i], middle[c, 0, i], middle[d, 0, i]
        ring[2, 3, i], ring[2, 4, i], ring[2, 5, i] = moved[p, i], middle[p, count[p] - 1, i], middle[c, 2, i]
    count[0], count[1], count[2] = n, REGULAR, REGULAR


@kernel(inner=True)
def _child_in_middle(corner, ring, count, moved, middle):
    """Replace a triangle of a Loop surface, in place, by the child triangle between the midpoints of its edges, one of
    four. The first corner of the child is the midpoint of the edge from corner 0 to corner 1.

    corner, ring, count: values at the corners, (3, k), values at the nodes around each corner, (3, v, k), and numbers of
    these nodes, (3,), which are overwritten; moved, middle: values after one subdivision, from `_cut`.
    """
    for i in range(corner.shape[1]):
        for c in range(3):
            d, p = (c + 1) % 3, (c + 2) % 3
            corner[c, i] = middle[c, 0, i]
            ring[c, 0, i], ring[c, 1, i], ring[c, 2, i] = middle[d, 0, i], middle[p, 0, i], moved[c, i]
            ring[c, 3, i], ring[c, 4, i], ring[c, 5, i] = middle[c, count[c] - 1, i], middle[d, 2, i], moved[d, i]
    count[0], count[1], count[2] = REGULAR, REGULAR, REGULAR


@kernel(inner=True, allocates=True)
def _spline(corner, ring, share, along, factors, powers, out):
    """Evaluate the Loop surface and its derivatives on a triangle whose corners have six neighbours, at barycentric coordinates
    `share`, shape (3,). The result is written to `out`, shape (6, k): value, 2 first and 3 second derivatives of k components.

    corner, ring: values at the corners, (3, k), and at the nodes around each corner, (3, v, k); along: two directions of the
    derivatives in barycentric coordinates, shape (2, 3); factors, powers: coefficients and powers of the polynomials of the box
    splines (`BOX_SPLINES`, `POWERS`).
    """
    k = corner.shape[1]
    weight = np.zeros((12, COUNT))
    for t in range(powers.shape[0]):
        base = np.zeros((3, 3))  # x^a, a x^(a-1), a (a-1) x^(a-2) of each share
        for axis in range(3):
            a, x = powers[t, axis], share[axis]
            base[0, axis] = x**a
            base[1, axis] = a * x ** max(a - 1, 0)
            base[2, axis] = a * (a - 1) * x ** max(a - 2, 0)
        u, v, w = base[0, 0], base[0, 1], base[0, 2]
        du, dv, dw = base[1, 0] * v * w, u * base[1, 1] * w, u * v * base[1, 2]
        duu, dvv, dww = base[2, 0] * v * w, u * base[2, 1] * w, u * v * base[2, 2]
        duv, dvw, dwu = base[1, 0] * base[1, 1] * w, u * base[1, 1] * base[1, 2], base[1, 0] * v * base[1, 2]
        term = np.zeros(COUNT)
        term[0] = u * v * w
        for a in range(2):
            term[1 + a] = du * along[a, 0] + dv * along[a, 1] + dw * along[a, 2]
            for b in range(a, 2):
                f, g = along[a], along[b]
                term[3 + a + b] = duu * f[0] * g[0] + dvv * f[1] * g[1] + dww * f[2] * g[2]
                term[3 + a + b] += duv * (f[0] * g[1] + f[1] * g[0]) + dvw * (f[1] * g[2] + f[2] * g[1])
                term[3 + a + b] += dwu * (f[2] * g[0] + f[0] * g[2])
        for node in range(12):
            for j in range(COUNT):
                weight[node, j] += factors[node, t] * term[j]
    for j in range(COUNT):
        for i in range(k):
            total = 0.0
            for c in range(3):
                total += weight[c, j] * corner[c, i]
            for c in range(3):
                for s in range(3):
                    total += weight[3 + 3 * c + s, j] * ring[c, 2 + s, i]
            out[j, i] = total


@kernel(inner=True, allocates=True)
def evaluate(corner, ring, count, share, factors, powers, out):
    """Evaluate the Loop surface and its derivatives on a triangle at barycentric coordinates `share`, shape (3,).

    corner: values of k components at the corners, (3, k); ring: values at the nodes around each corner, (3, v, k), v >= 6;
    count: numbers of these nodes, (3,); factors, powers: coefficients and powers of the polynomials of the box splines
    (`BOX_SPLINES`, `POWERS`); out: the result, (6, k): value, 2 first and 3 second derivatives with respect to the
    barycentric coordinates of corners 1 and 2. `corner`, `ring`, `count` and `share` are overwritten. At a corner without
    six neighbours the derivatives are zero.
    """
    moved, middle = np.zeros_like(corner), np.zeros_like(ring)
    along = np.zeros((2, 3))
    along[0, 0], along[0, 1], along[1, 0], along[1, 2] = -1.0, 1.0, -1.0, 1.0
    for _ in range(DEEPEST):
        if count[0] == REGULAR and count[1] == REGULAR and count[2] == REGULAR:
            _spline(corner, ring, share, along, factors, powers, out)
            return
        _cut(corner, ring, count, moved, middle)
        largest = 0
        for c in range(1, 3):
            if share[c] > share[largest]:
                largest = c
        a, d, p = largest, (largest + 1) % 3, (largest + 2) % 3
        if share[a] >= 0.5:
            _child_at_corner(a, corner, ring, count, moved, middle)
            share[0], share[1], share[2] = 1.0 - 2.0 * (share[d] + share[p]), 2.0 * share[d], 2.0 * share[p]
            for j in range(2):
                along[j, 0], along[j, 1], along[j, 2] = 2.0 * along[j, a], 2.0 * along[j, d], 2.0 * along[j, p]
        else:
            _child_in_middle(corner, ring, count, moved, middle)
            share[0], share[1], share[2] = 1.0 - 2.0 * share[2], 1.0 - 2.0 * share[0], 1.0 - 2.0 * share[1]
            for j in range(2):
                along[j, 0], along[j, 1], along[j, 2] = -2.0 * along[j, 2], -2.0 * along[j, 0], -2.0 * along[j, 1]
    nearest = 0
    for c in range(1, 3):
        if share[c] > share[nearest]:
            nearest = c
    weight = limit_share(count[nearest])
    out[:] = 0.0
    for i in range(corner.shape[1]):
        total = 0.0
        for j in range(count[nearest]):
            total += ring[nearest, j, i]
        out[VALUE, i] = (1.0 - count[nearest] * weight) * corner[nearest, i] + weight * total


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
        _evaluate(chunks, np.ascontiguousarray(x), self.rings, triangle, share, BOX_SPLINES, POWERS, result)
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
    share = np.array([limit_share(int(valence)) if valence else 0.0 for valence in range(mesh.valence.max() + 1)])
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
    ring = np.zeros((3, max(REGULAR, int(valences.max())), m))
    for c, own in enumerate(slots):
        ring[c, np.arange(len(own)), own] = 1.0
    result = np.zeros((len(shares), COUNT, m))
    for number, share in enumerate(shares):
        _evaluate_one(np.eye(3, m), ring.copy(), valences.copy(), share.copy(), BOX_SPLINES, POWERS, result[number])
    return result


@kernel()
def _evaluate_one(corner, ring, count, share, factors, powers, out):
    evaluate(corner, ring, count, share, factors, powers, out)


@parallel_loop(allocates=True)
def _evaluate(chunk, x, mesh, triangle, share, factors, powers, result):
    ring, corner = np.zeros((3, max(mesh.ring.shape[1], REGULAR), 3)), np.zeros((3, 3))
    count, out = np.zeros(3, np.int64), np.zeros((COUNT, 3))
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(triangle))):
        for c in range(3):
            node = mesh.triangles[triangle[p], c]
            count[c], corner[c] = mesh.valence[node], x[node]
            for k in range(count[c]):
                ring[c, k] = x[mesh.ring[3 * triangle[p] + c, k]]
        evaluate(corner, ring, count, share[p].copy(), factors, powers, out)
        result[p] = out[VALUE]
