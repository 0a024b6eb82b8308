"""Flat lids over the rims of a surface, which close it."""

import numpy as np

from pellucid.geometry.meshes.triangulation import directed_edges, pieces


class Lids:
    """Triangles between the edges of each rim and the mean of its points: flat where the rim is."""

    def __init__(self, triangles: np.ndarray) -> None:
        """triangles: of the surface, shape (m, 3), counterclockwise about the normals."""
        edges = directed_edges(triangles)
        n = int(triangles.max(initial=0)) + 1
        _, place, count = np.unique(np.sort(edges, axis=1) @ (n, 1), return_index=True, return_counts=True)
        self.edges = edges[np.sort(place[count == 1])]
        """Of the rims, shape (k, 2), in the sense of the triangles."""
        self._rim = np.unique(pieces(self.edges, n)[self.edges[:, 0]], return_inverse=True)[1].ravel()

    def centres(self, places: np.ndarray) -> np.ndarray:
        """The mean of the points of each rim [m], shape (rims, 3); places [m], (n, 3)."""
        first = places[self.edges[:, 0]]
        sums = np.stack([np.bincount(self._rim, first[:, axis]) for axis in range(3)], axis=1)
        return np.asarray(sums / np.bincount(self._rim)[:, None])

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
