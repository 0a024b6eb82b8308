"""Lids that close the rims of a surface: flat lids, or planes of symmetry that contain a rim."""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.triangulation import directed_edges, pieces

LEVEL = 1e-6  # of the longest edge of a rim: tolerance by which an edge lies in a plane perpendicular to an axis
FLAT = 1e-3  # of the extent of a rim: deviation of its points from a plane up to which it is flat
BENT = 0.1  # of the extent of a rim: deviation above which a lid to the mean of its points gives no meaningful volume


class Rims(NamedTuple):
    """The boundary edges of a surface (edges of only one triangle), each in the direction in which its triangle traverses
    the edge."""

    edges: np.ndarray  # (k, 2) vertex numbers of the ends of each edge
    beside: np.ndarray  # (k,) vertex number of the third corner of the triangle at each edge
    number: np.ndarray  # (k,) index of the rim to which each edge belongs


def rims_of(triangles: np.ndarray) -> Rims:
    """Return the boundary edges of triangles, shape (m, 3), grouped into rims. The corners of a triangle are
    counterclockwise about its normal."""
    edges, n = directed_edges(triangles), int(triangles.max(initial=0)) + 1
    _, place, count = np.unique(np.sort(edges, axis=1) @ (n, 1), return_index=True, return_counts=True)
    open_ones = np.sort(place[count == 1])
    edges, beside = edges[open_ones], np.roll(triangles, 1, axis=1).T.ravel()[open_ones]
    return Rims(edges, beside, np.unique(pieces(edges, n)[edges[:, 0]], return_inverse=True)[1].ravel())


class Lids:
    """The lids over the rims of a surface, chosen from the initial positions.

    A flat rim is closed by triangles to the mean of its points. A bent rim whose edges lie in planes perpendicular to axes,
    such as the rim of a quarter sphere in two planes of symmetry, is closed by these planes: component a of the normal is zero
    in planes perpendicular to other axes, so the volume is V = ∫(x_a - c_a) n_a dA, where c_a is the position of the plane
    perpendicular to axis a. There may be only one such plane.
    """

    def __init__(self, places: np.ndarray, triangles: np.ndarray) -> None:
        """Choose the lids of a surface. places: initial positions of its vertices [m], shape (n, 3); triangles: shape (m,
        3)."""
        self.rims = rims_of(triangles)
        number = self.rims.number
        bends = np.array([_bend(places[self.rims.edges[number == rim]]) for rim in range(number.max(initial=-1) + 1)])
        across = self._planes(places)
        in_planes = np.array([bool((across[number == rim] >= 0).all()) for rim in range(len(bends))], dtype=bool)
        by_planes = (bends > FLAT) & in_planes
        counts = [self._number_of_planes(places, across, by_planes[number], axis) for axis in range(3)]
        self._axis = int(np.argmin(counts))
        """Axis a of the volume integral V (see the class)."""
        if min(counts) > 1:
            by_planes[:] = False
        self.bend = float(bends[~by_planes].max(initial=0.0))
        """Largest deviation of the points of a rim from the plane of its lid, divided by the extent of the rim."""
        self._capped = ~by_planes[number]
        self._at_plane = self.rims.edges[~self._capped & (across == self._axis)]

    def _planes(self, places: np.ndarray) -> np.ndarray:
        """Return for each rim edge the axis perpendicular to a coordinate plane that contains the edge, -1 if there is none.
        places: initial positions of the vertices [m], shape (n, 3).

        If there are several, the axis is chosen along which the triangle at the edge extends farthest.
        """
        first, second = (places[self.rims.edges[:, end]] for end in (0, 1))
        lengths = np.linalg.norm(second - first, axis=1)
        longest = np.zeros(self.rims.number.max(initial=-1) + 1)
        np.maximum.at(longest, self.rims.number, lengths)
        level = np.abs(second - first) <= LEVEL * longest[self.rims.number][:, None]
        leaves = np.where(level, np.abs(places[self.rims.beside] - first), -1.0)
        return np.where(level.any(axis=1), np.argmax(leaves, axis=1), -1)

    def _number_of_planes(self, places: np.ndarray, across: np.ndarray, chosen: np.ndarray, axis: int) -> int:
        """Count the different planes perpendicular to an axis that contain the rim edges of the mask `chosen`. places:
        initial positions [m]; across: result of `_planes`."""
        heights = np.sort(places[self.rims.edges[chosen & (across == axis), 0], axis])
        extent = float(np.ptp(places, axis=0).max(initial=0.0))
        return int(np.count_nonzero(np.diff(heights, prepend=-np.inf) > FLAT * extent)) if len(heights) else 0

    def volume(self, places: np.ndarray, areas: np.ndarray) -> float:
        """Return the volume inside the surface and its lids [m³], negative if the normals point inward.

        places: positions of the vertices [m]; areas: vector area of the surface that belongs to each vertex [m²], shape
        (n, 3) each.
        """
        axes = [0, 1, 2] if self._capped.all() else [self._axis]
        at_plane = places[self._at_plane].reshape(-1, 3)
        about = places - (at_plane if len(at_plane) else places).mean(axis=0)  # reduces rounding errors far from the origin
        found = float(np.sum((about * areas)[:, axes]))
        if self._capped.any():
            corners, caps = _caps(self.rims, about)
            caps = caps[self._capped]
            found += float(np.sum((corners[caps].mean(axis=1) * vector_areas(corners, caps))[:, axes]))
        return found / len(axes)


def capped(places: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices [m] and triangles of a surface after each rim is closed by triangles to the mean of its points.
    places: vertices [m], shape (n, 3); triangles: shape (m, 3)."""
    corners, caps = _caps(rims_of(triangles), places)
    return corners, np.concatenate([triangles, caps])


def _caps(rims: Rims, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions `places` followed by the mean point of each rim [m], and for each edge of a rim its triangle
    with the mean point, as indices of these positions, shape (k, 3)."""
    first = places[rims.edges[:, 0]]
    sums = np.stack([np.bincount(rims.number, first[:, axis]) for axis in range(3)], axis=1)
    means = sums / np.bincount(rims.number)[:, None]
    return np.concatenate([places, means]), np.column_stack([rims.edges[:, 1], rims.edges[:, 0], len(places) + rims.number])


def _bend(edges: np.ndarray) -> float:
    """Return the RMS distance of the points of a rim from the plane that fits them, divided by the extent of the rim; edges:
    their end points [m], shape (k, 2, 3)."""
    sizes = np.linalg.svd(edges[:, 0] - edges[:, 0].mean(axis=0), compute_uv=False)
    return float(sizes[-1] / sizes[0]) if len(sizes) == 3 and sizes[0] > 0.0 else 0.0
