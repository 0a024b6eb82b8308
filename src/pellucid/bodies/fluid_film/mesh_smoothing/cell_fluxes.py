"""Masses of the cells around the nodes of a surface after the nodes have moved along it.

A cell extends to the midpoints of the edges and triangles around its node. The mass that passes a side of a cell is the area
that the side sweeps, times the density there. The swept areas do not add up exactly to the area changes of the cells;
differences of a potential between the cells correct them, so that a film of uniform density stays uniform.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from pellucid.geometry.meshes.triangulation import Rings, vertex_normals


class CellFluxes:
    """Computes the mass fluxes between the cells (areas) around the n nodes of a closed triangulation that moves along a
    surface.
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
