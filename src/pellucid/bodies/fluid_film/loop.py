"""Closed surfaces in space by Loop's subdivision: functions with square-integrable curvature, as bending needs them.

The nodes are control points; the surface runs near them.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from pellucid.bodies.fluid_film import loop_patch as patch
from pellucid.bodies.fluid_film.cell_fluxes import CellFluxes, normals
from pellucid.bodies.fluid_film.geometry import Redistributed, Shares
from pellucid.bodies.fluid_film.operators import Operators
from pellucid.bodies.fluid_film.spreading import check_quality, way_along
from pellucid.bodies.fluid_film.surface_rows import SurfaceTables, surface_areas, surface_operators
from pellucid.geometry.cells import Cells
from pellucid.geometry.quadrature import TRIANGLE, TRIANGLE_WEIGHTS
from pellucid.geometry.rings import Rings, rings
from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for

CHUNK = 128  # nodes
APPROACHES = 3  # to a place at a distance along the surface, whose parameters are not even


class TriangleRule(NamedTuple):
    """Points on a triangle as shares of its corners, shape (q, 3), and weights that add up to 1, shape (q,)."""

    shares: np.ndarray
    weights: np.ndarray


THREE = TriangleRule(np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3), np.full(3, 1.0 / 3.0))  # exact to degree 2
SIX = TriangleRule(TRIANGLE, TRIANGLE_WEIGHTS)  # exact to degree 4


class LoopSurface:
    """Triangles (e, 3) between n nodes that enclose a volume, counterclockwise seen from outside."""

    axes = (0, 1, 2)

    def __init__(self, triangles: np.ndarray, n: int, rule: TriangleRule = THREE) -> None:
        self.rings = rings(triangles, n)
        valences = self.rings.valence[triangles]
        if ((valences == 3) & (np.roll(valences, 1, axis=1) == 3)).any():
            raise ValueError("two nodes with three neighbours each lie side by side: the surface is a tetrahedron; refine it")
        kinds, kind = np.unique(valences, axis=0, return_inverse=True)
        kind = kind.reshape(-1)
        m = int(kinds.sum(axis=1).max()) - 6
        self.nodes = _slot_nodes(self.rings, kinds, kind, m)
        functions = np.stack([_functions(valence, rule.shares, m) for valence in kinds])
        self.tables = SurfaceTables(
            kind, functions[:, :, 0].copy(), functions[:, :, 1:3].copy(), functions[:, :, 3:].copy(), 0.5 * rule.weights
        )
        self.held = np.zeros((n, 3), bool)
        self.shares = Shares(triangles, rule.shares)
        self._limit = limit_matrix(self.rings)
        self._inverse = splu(self._limit.tocsc())
        self._fluxes = CellFluxes(self.rings)

    def operators(self, x: np.ndarray) -> Operators:
        """Rows for nodes at x [m], shape (n, 3)."""
        return surface_operators(x, self.nodes, self.tables)

    def places(self, x: np.ndarray) -> np.ndarray:
        """Values on the surface at the nodes, shape (n, k), of a field with these values x of the nodes."""
        return np.asarray(self._limit @ x)

    def through(self, places: np.ndarray) -> np.ndarray:
        """Nodes of the surface that runs through places, shape (n, k); the inverse of `places`."""
        return np.asarray(self._inverse.solve(np.array(places, dtype=float)))

    def spacing(self, x: np.ndarray) -> np.ndarray:
        """Distance of each node from its nearest neighbour [m], shape (n,)."""
        return np.asarray(np.linalg.norm(x[self.rings.neighbours] - x[:, None], axis=2).min(axis=1))

    def cells(self) -> Cells:
        """The triangles."""
        return Cells(triangles=self.rings.triangles)

    def redistributed(self, x: np.ndarray, mass: np.ndarray, moved: np.ndarray) -> Redistributed:
        """See `pellucid.bodies.fluid_film.geometry`."""
        before = self.places(x)
        after = self._along(x, before, way_along(self.rings, before, self.places(moved)))
        check_quality(self.rings.triangles, after)
        new = self.through(after)
        new_mass = self._fluxes.moved(before, after, self._cell_areas(x), self._cell_areas(new), mass)
        return Redistributed(new, new_mass)

    def smoothed(self, x: np.ndarray, sweeps: int = 10) -> np.ndarray:
        """Nodes of the same surface that are spread more evenly, as its curvature needs them; after so many sweeps."""
        for _ in range(sweeps):
            places = self.places(x)
            x = self.through(self._along(x, places, way_along(self.rings, places, np.zeros_like(x))))
        return x

    def _along(self, x: np.ndarray, places: np.ndarray, way: np.ndarray) -> np.ndarray:
        """Places on the surface at ways (n, 3) from those of the nodes [m]."""
        result = np.empty_like(places)
        normal, chunks = normals(self.rings.triangles, places), -(-len(places) // CHUNK)
        _walk(chunks, np.ascontiguousarray(x), self.rings, places, normal, way, patch.BOX_SPLINES, patch.POWERS, result)
        return result

    def _cell_areas(self, x: np.ndarray) -> np.ndarray:
        areas = np.einsum("eq,qc->ec", surface_areas(x, self.nodes, self.tables), self.shares.share)
        return np.bincount(self.shares.part.ravel(), areas.ravel())


def limit_matrix(mesh: Rings) -> csr_array:
    """What takes control points to their places on the surface, shape (n, n)."""
    n = len(mesh.valence)
    share = np.array([patch.limit_share(int(valence)) if valence else 0.0 for valence in range(mesh.valence.max() + 1)])
    turn = np.arange(mesh.ring.shape[1])
    row, column = np.nonzero(turn < mesh.valence[:, None])
    neighbour = mesh.neighbours[row, column]
    own = 1.0 - share[mesh.valence] * mesh.valence
    rows, columns = np.concatenate([row, np.arange(n)]), np.concatenate([neighbour, np.arange(n)])
    return csr_array((np.concatenate([share[mesh.valence[row]], own]), (rows, columns)), shape=(n, n))


def _slot_nodes(mesh: Rings, kinds: np.ndarray, kind: np.ndarray, m: int) -> np.ndarray:
    """The nodes of each triangle, shape (e, m): its corners; then of each corner's ring those across and beyond; then padding."""
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
    """The slots of the rings of the three corners."""
    first = [3, valences[0], valences[0] + valences[1] - 3]
    rings_of: list[list[int]] = []
    for c in range(3):
        after = (c + 1) % 3
        across = after if valences[after] > 3 else (c + 2) % 3  # with three neighbours it shares its only one with the next
        own = range(first[c], first[c] + valences[c] - 3)
        rings_of.append([after, (c + 2) % 3, *own, first[across]])
    return rings_of


def _functions(valences: np.ndarray, shares: np.ndarray, m: int) -> np.ndarray:
    """Values and derivatives of m functions on a triangle with these valences, shape (q, COUNT, m)."""
    slots = _slots(valences.tolist())
    ring = np.zeros((3, max(patch.REGULAR, int(valences.max())), m))
    for c, own in enumerate(slots):
        ring[c, np.arange(len(own)), own] = 1.0
    result = np.zeros((len(shares), patch.COUNT, m))
    for number, share in enumerate(shares):
        evaluate(np.eye(3, m), ring.copy(), valences.copy(), share.copy(), patch.BOX_SPLINES, patch.POWERS, result[number])
    return result


@kernel()
def evaluate(corner, ring, count, share, factors, powers, out):
    """See `loop_patch.evaluate`."""
    patch.evaluate(corner, ring, count, share, factors, powers, out)


@kernel(inner=True)
def _patch(triangle, x, mesh, corner, ring, count):
    """Fill in the nodes of a triangle and the rings about them."""
    for c in range(3):
        half = 3 * triangle + c
        count[c] = mesh.valence[mesh.triangles[triangle, c]]
        for i in range(3):
            corner[c, i] = x[mesh.triangles[triangle, c], i]
            for k in range(count[c]):
                ring[c, k, i] = x[mesh.ring[half, k], i]


@kernel(inner=True)
def _locate(i, d, mesh, places, n, share):
    """The triangle about node i that lies along d [m], seen along the normal n, and the shares of its corners there."""
    half, best, a, b = mesh.out[i], -np.inf, 0.0, 0.0
    found = half
    for _ in range(mesh.valence[i]):
        triangle, c = half // 3, half % 3
        u = places[mesh.triangles[triangle, (c + 1) % 3]] - places[i]
        v = places[mesh.triangles[triangle, (c + 2) % 3]] - places[i]
        whole = _triple(u, v, n)
        s, t = _triple(d, v, n) / whole, _triple(u, d, n) / whole  # d = s u + t v
        if min(s, t) > best:
            best, found, a, b = min(s, t), half, s, t
        half = mesh.twin[3 * triangle + (c + 2) % 3]
    a, b = max(a, 0.0), max(b, 0.0)
    if a + b > 1.0:
        a, b = a / (a + b), b / (a + b)
    c = found % 3
    share[c], share[(c + 1) % 3], share[(c + 2) % 3] = 1.0 - a - b, a, b
    return found // 3


@kernel(inner=True)
def _walk_chunk(chunk, x, mesh, places, normal, way, factors, powers, result):
    ring, corner = np.zeros((3, max(mesh.ring.shape[1], patch.REGULAR), 3)), np.zeros((3, 3))
    count, share, out = np.zeros(3, np.int64), np.zeros(3), np.zeros((patch.COUNT, 3))
    for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(places))):
        aim = way[i].copy()
        for _ in range(APPROACHES):
            triangle = _locate(i, aim, mesh, places, normal[i], share)
            _patch(triangle, x, mesh, corner, ring, count)
            patch.evaluate(corner, ring, count, share, factors, powers, out)
            missed = way[i] - (out[patch.VALUE] - places[i])
            aim += missed
        result[i] = out[patch.VALUE]


@kernel(inner=True)
def _triple(a, b, c):
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    return x * c[0] + y * c[1] + z * c[2]


@kernel()
def _walk(chunks, x, mesh, places, normal, way, factors, powers, result):
    parallel_for(_walk_chunk, chunks, x, mesh, places, normal, way, factors, powers, result)
