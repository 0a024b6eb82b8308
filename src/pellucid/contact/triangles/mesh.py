"""Triangulated surfaces for contact: moving vertices, contact points, and images at planes of symmetry and seams.

The contact points of a surface are its vertices and the midpoints of its edges, each with a sixth of the area of the
adjacent triangles. Points on edges detect where edges of two surfaces cross. At a plane of symmetry or a seam of a periodic
grid, the surface continues in its images. A vertex and its images at the same position count as one vertex of the mesh, so
that the surface has no rim there.
"""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from pellucid.contact.boxes import Boxes, make_boxes
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Plane, Seam
from pellucid.contact.triangles.closest_point import TINY, Facets, find_normals
from pellucid.contact.triangles.slots import ContactPoints

SAME = 1e-9  # distance below which vertices coincide, relative to the extent of the surface
MARGIN = 0.25  # margin of the search distance beyond the contact distance, in median edges
SEARCHED = 0.8  # approach of the surfaces that requires a search, in margins
FORGETS = 2.5  # distance beyond the thickness at which a slot is emptied, in margins
ALONG = 1.5  # distance along a surface without self-contact, in thicknesses: half the circle of a fold
BATCH = 256  # number of points per batch of distances along the surface


class Image(NamedTuple):
    """Mapping from a surface to one of its images at planes of symmetry and seams: image position = position times `flip`,
    plus `shift`."""

    flip: np.ndarray  # -1 along the axes in which the image is mirrored, 1 along the others
    shift: np.ndarray  # displacement after mirroring [m]


def find_images(planes: Sequence[Plane], seams: Sequence[Seam]) -> list[Image]:
    """Return the mappings to the images of a surface at planes of symmetry and periodic seams, and at their intersections;
    the first is the identity."""
    along = []
    for axis in range(3):
        found = [(1.0, 0.0), *((-1.0, 2.0 * plane.place) for plane in planes if plane.axis == axis)]
        found += [(1.0, sign * seam.period) for seam in seams if seam.axis == axis for sign in (1.0, -1.0)]
        along.append(found)
    return [Image(np.array([f for f, _ in axes]), np.array([s for _, s in axes])) for axes in product(*along)]


class TriangleMesh:
    """Triangulated surface with its images, which follows the motion of its body.

    Attributes
    ----------
    points : ContactPoints
        Contact points of the surface.
    facets : Facets
        Triangles with which points of other surfaces come into contact.
    edge : float
        Median length of the edges [m].
    flips : np.ndarray
        Signs of the axes of the surface and of its images, shape (images, 3).
    mean_velocity, fastest
        Mean velocity of the vertices, shape (3,), and the largest speed relative to it [m/s].
    """

    def __init__(self, surface: ContactSurface, images: Sequence[Image]) -> None:
        if surface.triangles is None:
            raise ValueError("the surface has no triangles")
        self._moving, self._images = surface.triangles, images
        place, own = self._moving.places(), self._moving.triangles.astype(np.int64)
        n, T = len(place), len(own)
        triangle = np.concatenate([self._imaged(own, image, n, i) for i, image in enumerate(images)])
        place = self._all_places(place)
        corners = place[own]
        lengths = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        self.edge = float(np.median(lengths))
        self._number = _representatives(place, n, SAME * float(np.ptp(corners, axis=(0, 1)).max()))
        merged = self._number[triangle]
        incidence = sparse.csr_array(
            (np.ones(triangle.size), (np.repeat(np.arange(len(triangle)), 3), merged.ravel())),
            shape=(len(triangle), len(place)),
        )
        self._beside_by_vertex = _pattern(incidence @ incidence.T)
        beside = _across_edges(merged)
        self._on_rim = np.zeros(len(place), bool)
        for i in range(3):
            ends = merged[:, [i, (i + 1) % 3]][beside[:, i] < 0]
            self._on_rim[ends.ravel()] = True
        self.facets = Facets(
            triangle=triangle,
            place=np.zeros_like(place),
            velocity=np.zeros_like(place),
            normal=np.zeros((len(triangle), 3)),
            vertex_normal=np.zeros_like(place),
            beside=beside,
            first=self._beside_by_vertex.indptr.astype(np.int64),
            neighbour=self._beside_by_vertex.indices.astype(np.int64),
        )
        # vertices and midpoints of edges, once each
        ends = np.sort(own[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, edge_of = np.unique(ends, axis=0, return_inverse=True)
        area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        area *= self._moving.depth
        used = np.unique(own)
        at_vertices = np.bincount(own.ravel(), np.repeat(area / 6.0, 3), minlength=n)[used]
        at_edges = np.bincount(edge_of.ravel(), np.repeat(area / 6.0, 3), minlength=len(edges))
        corner = np.concatenate([np.repeat(used[:, None], 3, axis=1), edges[:, [0, 1, 1]]])
        share = np.concatenate([np.tile((1.0, 0.0, 0.0), (len(used), 1)), np.tile((0.5, 0.5, 0.0), (len(edges), 1))])
        m = len(corner)
        self.points = ContactPoints(
            place=np.zeros((m, 3)),
            velocity=np.zeros((m, 3)),
            normal=np.zeros((m, 3)),
            corner=corner,
            share=share,
            area=np.concatenate([at_vertices, at_edges]),
            first=np.zeros(m + 1, np.int64),
            excluded=np.zeros(0, np.int64),
        )
        self.n_vertices, self._T = n, T
        whole = np.bincount(own.ravel(), np.repeat(area / 3.0, 3), minlength=n)
        self._mobility = np.zeros(n) if surface.is_hard else 1.0 / np.sqrt(np.maximum(surface.mass_per_area * whole, TINY))
        response, self._of_nodes = self._moving.response, None
        if response is not None and response.shares.nnz > n:
            self._of_nodes = sparse.csr_array(sparse.kron(response.shares, sparse.eye_array(3), format="csr"))
        self.flips = np.array([image.flip for image in images])
        self.follow()
        one, edge = np.nonzero(beside[:T] > np.arange(T)[:, None])
        self._hinges = np.stack([one, beside[one, edge]], axis=1)
        self._hinges = self._hinges[self._fold_cosines() > 0.0]  # without edges at which the surface is folded at the start

    def _fold_cosines(self) -> np.ndarray:
        one, two = (self.facets.normal[triangle] for triangle in self._hinges.T)
        sizes = np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1)
        return np.asarray(np.einsum("ij,ij->i", one, two) / np.maximum(sizes, TINY))

    def find_sharpest_fold(self) -> tuple[float, np.ndarray]:
        """Return the largest angle between the normals of two neighbouring triangles [degrees], and the centroid of one of
        these two triangles [m], shape (3,).

        Edges at which the surface was folded by more than 90 degrees at the start do not count.
        """
        if not len(self._hinges):
            return 0.0, np.zeros(3)
        cosines = self._fold_cosines()
        sharpest = int(np.argmin(cosines))
        corners = self.facets.triangle[self._hinges[sharpest, 0]]
        return float(np.degrees(np.arccos(np.clip(cosines[sharpest], -1.0, 1.0)))), self.facets.place[corners].mean(axis=0)

    def points_of_itself(self, thickness: float) -> ContactPoints:
        """Return the points for self-contact of the surface with a thickness [m].

        A point does not touch triangles that contain it, nor triangles that are initially closer than `ALONG` thicknesses
        along the surface.
        """
        excluded = self._find_excluded(ALONG * thickness)
        return self.points._replace(first=excluded.indptr.astype(np.int64), excluded=excluded.indices.astype(np.int64))

    def _find_excluded(self, limit: float) -> sparse.csr_array:
        """Return the triangles that contain each contact point, or whose distance from the point along the surface is
        smaller than `limit` [m].

        Distances are lengths of the shortest path through the triangles between vertices and midpoints of edges. The result
        is a sparsity pattern of shape (points, triangles).
        """
        triangle, n = self._number[self.facets.triangle], len(self.facets.place)
        ends = np.sort(triangle[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, edge_of = np.unique(ends, axis=0, return_inverse=True)
        node = np.concatenate([triangle, n + edge_of.reshape(-1, 3)], axis=1)  # corners and midpoints of each triangle
        place = self._all_places(self._moving.places())
        place = np.concatenate([place, place[edges].mean(axis=1)])
        first, second = np.triu_indices(6, 1)
        ways = np.unique(np.sort(np.stack([node[:, first], node[:, second]], axis=-1).reshape(-1, 2), axis=1), axis=0)
        length = np.linalg.norm(place[ways[:, 0]] - place[ways[:, 1]], axis=1)
        graph = sparse.csr_array((np.maximum(length, TINY), (ways[:, 0], ways[:, 1])), shape=(len(place), len(place)))
        number = {(int(a), int(b)): n + i for i, (a, b) in enumerate(edges)}
        corner = np.sort(self._number[self.points.corner[:, :2]], axis=1)
        at = np.array([a if a == b else number[int(a), int(b)] for a, b in corner])
        points, near = [], []
        order = np.lexsort(np.floor(place[at] / (8.0 * self.edge)).T)
        for i in range(0, len(at), BATCH):
            ours = order[i : i + BATCH]
            low, high = place[at[ours]].min(axis=0) - limit, place[at[ours]].max(axis=0) + limit
            around = np.flatnonzero(((place >= low) & (place <= high)).all(axis=1))  # other nodes are further away
            nodes = np.searchsorted(around, at[ours])
            distance = dijkstra(graph[around][:, around], directed=False, indices=nodes, limit=limit)
            row, column = np.nonzero(distance <= limit)
            points.append(ours[row])
            near.append(around[column])
        row, column = np.concatenate(points), np.concatenate(near)
        reached = sparse.csr_array((np.ones(len(row)), (row, column)), shape=(len(at), len(place)))
        of_triangles = sparse.csr_array(
            (np.ones(node.size), (node.ravel(), np.repeat(np.arange(len(node)), 6))), shape=(len(place), len(node))
        )
        about = (np.ones(2 * len(at)), (np.repeat(np.arange(len(at)), 2), corner.ravel()))
        return _pattern(reached @ of_triangles + sparse.csr_array(about, shape=(len(at), n)) @ of_triangles[:n])

    def follow(self) -> None:
        """Update the positions, velocities and normals of the vertices, of their images and of the points from the body."""
        facets, points, n = self.facets, self.points, self.n_vertices
        facets.place[:] = self._all_places(self._moving.places())
        velocity = self._moving.velocities()
        for i, image in enumerate(self._images):
            facets.velocity[i * n : (i + 1) * n] = image.flip * velocity
        self.mean_velocity = velocity.mean(axis=0)
        self.fastest = float(np.sqrt(((velocity - self.mean_velocity) ** 2).sum(axis=1).max()))
        find_normals(facets.triangle, facets.place, self._number, self._on_rim, facets.normal, facets.vertex_normal)
        for target, values in ((points.place, facets.place), (points.velocity, facets.velocity)):
            np.einsum("mc,mcd->md", points.share, values[points.corner], out=target)
        # on a rim, closest points need no normal; points use the normal of the adjacent triangles
        of_points = np.zeros((n, 3))
        for c in range(3):
            for d in range(3):
                of_points[:, d] += np.bincount(facets.triangle[: self._T, c], facets.normal[: self._T, d], minlength=n)
        np.einsum("mc,mcd->md", points.share, of_points[points.corner], out=points.normal)

    def boxes(self, far: float, lower: np.ndarray, upper: np.ndarray) -> Boxes:
        """Return the triangles sorted by the boxes of a lattice between the corners `lower` and `upper` [m]; each triangle
        is in all boxes within the distance `far` [m]."""
        corners = self.facets.place[self.facets.triangle]
        low, high = corners.min(axis=1) - far, corners.max(axis=1) + far
        return make_boxes(low, high, lower, upper, max(far, self.edge))

    def speed_against(self, velocity: np.ndarray) -> float:
        """Return the largest magnitude of the difference between a velocity, shape (3,), and the mean velocity of the
        surface or one of its images [m/s]."""
        means = np.array([image.flip * self.mean_velocity for image in self._images])
        return float(np.linalg.norm(velocity - means, axis=1).max())

    def add_forces(self, force: np.ndarray) -> None:
        """Apply forces to the vertices of the surface for this step [N], shape (n, 3)."""
        self._moving.add_forces(force)

    def response(self, column: np.ndarray, share: np.ndarray, dt: float) -> tuple[np.ndarray, sparse.csr_array]:
        """Return the response of n contacts to nodal forces in a step dt [s]: velocities and compliance.

        The result contains the contact velocities at the end of the step without contact forces [m/s], shape (n,), and a
        matrix C. Contact forces f change the contact displacements by C Cᵀ f. column, share: weights of the vertex velocity
        components in the n contact velocities; the column of a component is 3 vertex + axis. If the motion is not known
        before contact, the vertices keep their velocities and have their own masses.
        """
        response, column, n = self._moving.response, column.reshape(len(share), -1), 3 * self.n_vertices
        rows = share.ravel(), column.ravel(), np.arange(0, column.size + 1, column.shape[1])
        shares = sparse.csr_array(rows, shape=(len(share), n))
        if response is None:
            return shares @ self._moving.velocities().ravel(), sparse.csr_array(shares * np.repeat(dt * self._mobility, 3))
        root = np.sqrt(dt * response.answers(dt)).ravel()
        if self._of_nodes is None:
            factor = sparse.csr_array((rows[0] * root[rows[1]], *rows[1:]), shape=(len(share), n))
        else:
            factor = sparse.csr_array((shares @ self._of_nodes) * root)
        return shares @ response.velocities(dt, None).ravel(), factor

    def _all_places(self, place: np.ndarray) -> np.ndarray:
        return np.concatenate([image.flip * place + image.shift for image in self._images])

    @staticmethod
    def _imaged(triangle: np.ndarray, image: Image, n: int, i: int) -> np.ndarray:
        """Return the triangles of image number i of a surface with n vertices; triangles of mirror images are reversed."""
        return i * n + (triangle[:, ::-1] if np.prod(image.flip) < 0.0 else triangle)


def _pattern(matrix: sparse.csr_array) -> sparse.csr_array:
    matrix = sparse.csr_array(matrix)
    matrix.data[:] = 1.0
    matrix.sort_indices()
    return matrix


def _representatives(place: np.ndarray, n: int, same: float) -> np.ndarray:
    """Return, for each vertex and each image of a vertex, the number of the vertex or image that represents all vertices
    and images at the same position, shape (images · n,).

    The representative is the first of the coinciding images of one vertex, or a vertex of the surface itself if an image of
    another vertex coincides with it. place: positions of the n vertices and then of their images [m]. same: distance below
    which positions coincide [m].
    """
    number = np.arange(len(place))
    copies = place.reshape(-1, n, 3)
    for i in range(1, len(copies)):
        for j in range(i - 1, -1, -1):
            at = np.flatnonzero(np.linalg.norm(copies[i] - copies[j], axis=1) <= same)
            number[i * n + at] = j * n + at
    if len(copies) > 1:
        away = np.flatnonzero(number[n:] == np.arange(n, len(place))) + n
        distance, found = map(np.asarray, cKDTree(place[:n]).query(place[away], distance_upper_bound=same))
        number[away[np.isfinite(distance)]] = found[np.isfinite(distance)]
    while not np.array_equal(number, number[number]):
        number = number[number]
    return number


def _across_edges(triangle: np.ndarray) -> np.ndarray:
    """Return the number of the neighbour triangle at each of the three edges of each triangle, shape (T, 3); -1 at edges
    without a neighbour. triangle: vertices, shape (T, 3)."""
    ends = np.sort(triangle[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    order = np.argsort(ends[:, 0] * (int(triangle.max()) + 1) + ends[:, 1], kind="stable")
    same = (ends[order[1:]] == ends[order[:-1]]).all(axis=1)
    beside = np.full(len(ends), -1)
    first, second = order[:-1][same], order[1:][same]
    beside[first], beside[second] = second // 3, first // 3
    return beside.reshape(-1, 3)
