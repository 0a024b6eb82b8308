"""Mesh smoothing on closed surfaces: moves nodes along the surface so that triangles stay well shaped, and computes the new
masses of the areas around the nodes.
"""

from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from pellucid.errors import RunStopped
from pellucid.geometry.checks.quality import triangle_qualities
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.triangulation import Rings, vertex_normals
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_loop

SMOOTHING = 0.3  # displacement of a node per step, relative to its distance from the centroid of its triangles
LONGEST = 0.4  # largest displacement of a node along the surface, relative to the distance to its nearest neighbour
WORST = 0.1  # lowest acceptable quality of a triangle; 1 is equilateral
WELL_SPREAD = 0.7  # lowest quality at which smoothing may be postponed if it would add energy


def check_quality(triangles: np.ndarray, places: np.ndarray) -> None:
    """Raise RunStopped if a triangle, shape (t, 3), with nodes at `places` [m], shape (n, 3), is too flat, or if its normal
    points against the normals of the surface.
    """
    quality = triangle_qualities(places, triangles)
    corner = places[triangles]
    along = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    turned = np.einsum("ei,ei->e", along, vertex_normals(places, triangles)[triangles].sum(axis=1)) <= 0.0
    quality = np.where(turned | ~np.isfinite(quality), 0.0, quality)
    worst = int(quality.argmin())
    if quality[worst] < WORST:
        node, place = int(triangles[worst, 0]), places[triangles[worst]].mean(axis=0)
        text = f"the triangle at node {node} has a quality of {quality[worst]:.2g}, below {WORST:g} (1 is equilateral)"
        where = ", ".join(f"{value:.6g}" for value in place)
        advice = 'set nodes = "even", use more nodes, or end the run earlier'
        raise RunStopped(f"{text}, near ({where}) m: {advice}", node=node, position=tuple(place.tolist()))


def way_along(mesh: Rings, places: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Return displacements along a surface that smooth the mesh [m], shape (n, 3), after the film moved the nodes by
    `moved` [m], shape (n, 3), to `places`.

    The displacements revert the tangential part of `moved`, except its rigid part, and move each node towards the centroids
    of the triangles around the node.
    """
    triangles, n = mesh.triangles, len(places)
    corner = places[triangles]
    area = np.linalg.norm(vector_areas(places, triangles), axis=1)
    weight = np.bincount(triangles.ravel(), np.repeat(area, 3), n)
    middles = np.repeat(area[:, None] * corner.mean(axis=1), 3, axis=0)
    centroid = np.stack([np.bincount(triangles.ravel(), middles[:, i], n) for i in range(3)], axis=1) / weight[:, None]
    way = SMOOTHING * (centroid - places) - (moved - rigid_part(places - moved, moved, weight))
    normal = vertex_normals(places, triangles)
    way -= np.einsum("ni,ni->n", way, normal)[:, None] * normal
    nearest = np.linalg.norm(places[mesh.neighbours] - places[:, None], axis=2).min(axis=1)
    length = np.linalg.norm(way, axis=1)
    return np.asarray(way * np.minimum(1.0, LONGEST * nearest / np.maximum(length, 1e-300))[:, None])


def rigid_part(places: np.ndarray, moved: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the displacements [m], shape (n, 3), of the small rigid motion of nodes at `places` [m] that fits the
    displacements `moved` [m] best, shape (n, 3) both, by weighted least squares with weights, shape (n,).
    """
    total = weight.sum()
    centre, mean = weight @ places / total, weight @ moved / total
    offset = places - centre
    inertia = (weight[:, None] * offset).T @ offset
    spin = (weight[:, None] * np.cross(offset, moved - mean)).sum(axis=0)
    turn = np.linalg.solve(np.trace(inertia) * np.eye(3) - inertia, spin)
    return np.asarray(mean + np.cross(turn, offset))


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


class CellFluxes:
    """Computes the mass fluxes between the cells (areas) around the n nodes of a closed triangulation that moves along a
    surface.

    A cell extends to the midpoints of the edges and triangles around its node. The mass that passes a side of a cell is the
    area that the side sweeps, times the density there. The swept areas do not add up exactly to the area changes of the
    cells; differences of a potential between the cells correct them, so that a film of uniform density stays uniform.
    """

    def __init__(self, mesh: Rings) -> None:
        self._mesh = mesh
        self._edge, self._back = mesh.edges()
        begin, end = mesh.begin[self._edge], mesh.begin[self._back]
        n, ones = len(mesh.valence), np.ones(len(begin))
        rows, columns = np.concatenate([begin, end, begin, end]), np.concatenate([end, begin, begin, end])
        laplacian = coo_array((np.concatenate([-ones, -ones, ones, ones]), (rows, columns)), shape=(n, n)).tocsc()
        self._potential = splu(laplacian[1:, 1:])  # the potential of node 0 is zero

    def moved(
        self, before: np.ndarray, after: np.ndarray, areas: np.ndarray, new_areas: np.ndarray, mass: np.ndarray
    ) -> np.ndarray:
        """Return the masses of the cells (areas around the nodes) [kg], shape (n,), after the nodes moved along the surface
        from `before` to `after` [m], shape (n, 3).

        areas, new_areas: areas of the cells before and after [m²], shape (n,); mass: masses of the cells before [kg], shape
        (n,).
        """
        begin, end = self._mesh.begin[self._edge], self._mesh.begin[self._back]
        swept = self._swept(before, after)
        gain = swept[self._edge] - swept[self._back]  # of the cell where the edge begins, from that where it ends
        lacking = new_areas * (areas.sum() / new_areas.sum()) - areas
        lacking -= np.bincount(begin, gain, len(mass)) - np.bincount(end, gain, len(mass))
        potential = np.concatenate([[0.0], self._potential.solve(lacking[1:])])
        gain += potential[begin] - potential[end]
        density = mass / areas
        slope = self._limited_slopes(before, density)
        middle = 0.25 * (before[begin] + before[end] + after[begin] + after[end])
        giver = np.where(gain > 0.0, end, begin)
        given = gain * (density[giver] + np.einsum("ei,ei->e", slope[giver], middle - before[giver]))
        return np.asarray(mass + np.bincount(begin, given, len(mass)) - np.bincount(end, given, len(mass)))

    def _swept(self, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """Return the area [m²] that one side of a cell sweeps while the nodes move from `before` to `after` [m], shape (n, 3).
        There is one value per half-edge: the side is the segment from the midpoint of the half-edge to the centroid of its
        triangle, and the area is positive away from the start of the half-edge.
        """
        triangles = self._mesh.triangles

        def ends(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            corner = places[triangles]
            return 0.5 * (corner + np.roll(corner, -1, axis=1)), corner.mean(axis=1, keepdims=True)

        (m0, c0), (m1, c1) = ends(before), ends(after)
        corner = before[triangles]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        return np.asarray(0.5 * np.einsum("eki,ei->ek", np.cross(c1 - m0, c0 - m1), normal).ravel())

    def _limited_slopes(self, places: np.ndarray, density: np.ndarray) -> np.ndarray:
        """Return the gradient of the surface density along the surface at the nodes [kg/m³], shape (n, 3), limited so that the
        density at the midpoints of the edges stays within the range of the neighbouring values (Barth & Jespersen 1989, AIAA
        paper 89-0366).

        places: nodal positions [m], shape (n, 3); density: at the nodes [kg/m²], shape (n,).
        """
        mesh = self._mesh
        neighbours, real = mesh.neighbours, np.arange(mesh.ring.shape[1]) < mesh.valence[:, None]
        normal = vertex_normals(places, mesh.triangles)
        offset = (places[neighbours] - places[:, None]) * real[..., None]
        offset -= np.einsum("nki,ni->nk", offset, normal)[..., None] * normal[:, None]
        jump = (density[neighbours] - density[:, None]) * real
        square = np.einsum("nki,nkj->nij", offset, offset)
        square += np.einsum("nii->n", square)[:, None, None] * normal[:, :, None] * normal[:, None, :]  # not along the normal
        slope = np.linalg.solve(square, np.einsum("nki,nk->ni", offset, jump)[..., None])[..., 0]
        rise = 0.5 * np.einsum("nki,ni->nk", offset, slope)
        highest, lowest = np.maximum(jump.max(axis=1), 0.0), np.minimum(jump.min(axis=1), 0.0)
        allowed = np.where(rise > 0.0, highest[:, None], lowest[:, None])
        share = np.where(np.abs(rise) > np.abs(allowed), allowed / np.where(rise == 0.0, 1.0, rise), 1.0)
        return np.asarray(slope * share.min(axis=1)[:, None])
