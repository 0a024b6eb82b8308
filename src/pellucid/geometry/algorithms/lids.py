"""Lids over the rims of a surface, which close it."""

import numpy as np

from pellucid.geometry.meshes.triangulation import directed_edges, pieces

LEVEL = 1e-6  # of the longest edge of a rim: within this all points of a plane across an axis have one coordinate


class Lids:
    """Triangles between the edges of each rim and a point that they share: flat where the rim is.

    It is the mean of the points of the rim. Of a rim that runs through several planes across axes, as that of a quarter of a
    ball in two planes of symmetry, it is where these planes meet: then the triangles lie in them.
    """

    def __init__(self, triangles: np.ndarray) -> None:
        """triangles: of the surface, shape (m, 3), counterclockwise about the normals."""
        edges = directed_edges(triangles)
        n = int(triangles.max(initial=0)) + 1
        _, place, count = np.unique(np.sort(edges, axis=1) @ (n, 1), return_index=True, return_counts=True)
        self.edges = edges[np.sort(place[count == 1])]
        """Of the rims, shape (k, 2), in the sense of the triangles."""
        self._rim = np.unique(pieces(self.edges, n)[self.edges[:, 0]], return_inverse=True)[1].ravel()

    def centres(self, places: np.ndarray) -> np.ndarray:
        """The point that the lid over each rim shares [m], shape (rims, 3); places [m], (n, 3)."""
        first, second = places[self.edges[:, 0]], places[self.edges[:, 1]]
        sums = np.stack([np.bincount(self._rim, first[:, axis]) for axis in range(3)], axis=1)
        centres = np.asarray(sums / np.bincount(self._rim)[:, None])
        for number in range(len(centres)):
            along = self._rim == number
            _move_into_planes(centres[number], first[along], second[along])
        return centres

    def closing(self, places: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Vertices and triangles of the surface with its lids."""
        if not len(self.edges):
            return places, triangles
        lids = np.column_stack([self.edges[:, 1], self.edges[:, 0], len(places) + self._rim])
        return np.concatenate([places, self.centres(places)]), np.concatenate([triangles, lids])

    def volume(self, places: np.ndarray) -> float:
        """Of the cones from the origin over the lids, whose normals point away from the surface [m³]; places [m], (n, 3)."""
        if not len(self.edges):
            return 0.0
        first, second = places[self.edges[:, 0]], places[self.edges[:, 1]]
        return float(np.sum(self.centres(places)[self._rim] * np.cross(second, first)) / 6.0)


def _move_into_planes(centre: np.ndarray, first: np.ndarray, second: np.ndarray) -> None:
    """Move a point to where planes across axes meet in which all of these edges lie; without such planes it stays."""
    lengths = np.linalg.norm(second - first, axis=1)
    near = LEVEL * lengths.max()
    level, meeting = np.abs(second - first) <= near, centre.copy()
    for axis in np.flatnonzero(level.any(axis=0)):
        heights, weights = first[level[:, axis], axis], lengths[level[:, axis]]
        shares = np.unique(np.round(heights / near), return_inverse=True)[1].ravel()
        meeting[axis] = np.median(heights[shares == np.argmax(np.bincount(shares, weights))])
        level[:, axis] &= np.abs(first[:, axis] - meeting[axis]) <= near
    if level.any(axis=1).all():
        centre[:] = meeting
