"""Contact points on the sharp edges and corners of a body that does not deform.

The contact points on a face lie half a spacing inside its edges. With these points alone, a block would tip about a line
inside the face.
The edges therefore have their own points: one at each corner, and a row along each edge from end to end. For a box at rest
on one of its sides, their total area is one and a half times the area with which rim and interior of that side carry equal
loads.
"""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.shapes.boundary_points import Contains
from pellucid.geometry.shapes.contract import SharpEdges
from pellucid.grid.model import GridCase

CORNER, EDGE = 0.125, 0.125
"""CORNER: area of a corner divided by the area of a side of the body. EDGE: area of an edge divided by its length times the
square root of the area of a side. The corners and edges of a square together carry as much load as the square."""
IN_PLANE = 0.5  # area of a corner of a plane body divided by the area of a side
ON_A_FACE = 1e-6  # tolerance of the distance of a point from a face of the grid, in cells


class EdgePoints(NamedTuple):
    """n points on the edges of a body; the c corners of its `SharpEdges` are the first.

    Attributes
    ----------
    place, normal : ndarray, shape (n, 3)
        Initial positions [m], and normalised means of the outward normals around them.
    tangent : ndarray, shape (n, 3)
        Unit vectors along the edges; zero at corners.
    weight : ndarray, shape (n,)
        Areas for contact forces [m²]; zero for corners that carry no load and only define the positions of planes.
    face : ndarray, shape (k, 3)
        See `SharpEdges.face`.
    thin : tuple of bool
        Axes that are one cell thick.
    """

    place: np.ndarray
    normal: np.ndarray
    tangent: np.ndarray
    weight: np.ndarray
    face: np.ndarray
    thin: tuple[bool, bool, bool]


def edge_points(
    found: SharpEdges,
    grid: GridCase,
    bounds: tuple[np.ndarray, np.ndarray],
    spacing: float,
    side: float,
    left_out: Contains | None,
) -> EdgePoints:
    """Return contact points on the edges of a body within the grid, at most a spacing [m] apart.

    found: edges and corners of the shape; bounds: corners of the bounding box of the body [m]; side: area of its largest side
    [m²]; left_out: function that returns a mask of the positions, shape (n, 3), that other bodies exclude from its shape.
    """
    thin, periodic = np.array(grid.thin()), np.array(grid.is_periodic())
    low, high = np.array(grid.lower, float), np.array(grid.extent_upper(), float)
    goes_on = periodic & (bounds[1] - bounds[0] > (1.0 - ON_A_FACE) * (high - low))  # across the seam, where it has no end
    ends = np.stack([np.where(goes_on, bounds[0], low), np.where(goes_on, bounds[1], high)])
    counts = ~thin & (~periodic | goes_on)
    slack = ON_A_FACE * grid.cell

    def is_out(places: np.ndarray) -> np.ndarray:
        out = (((places < ends[0] - slack) | (places > ends[1] + slack)) & counts).any(axis=1)
        return out if left_out is None else out | left_out(places)

    def on_faces(places: np.ndarray) -> np.ndarray:
        """Return a mask of the faces of the grid on which each position [m], shape (n, 3), lies, shape (n, 2, 3): end, axis."""
        return (np.abs(places[:, None] - ends) < slack) & counts

    bears = ~is_out(found.corner) & ~on_faces(found.corner).any(axis=(1, 2)) & np.any(found.corner_normal, axis=1)
    corner_weight = bears * side * (CORNER if len(found.edge) else IN_PLANE)
    places, normals, weights = [found.corner], [found.corner_normal], [corner_weight]
    tangents = [np.zeros_like(found.corner)]
    for corners, normal in zip(found.edge, found.edge_normal, strict=True):
        first, last = found.corner[corners]
        if on_faces(found.corner[corners]).all(axis=0).any():
            continue  # in a face of the grid, beyond which the body goes on or nothing is
        length = float(np.linalg.norm(last - first))
        n = max(1, int(np.ceil(length / spacing * (1.0 - 1e-9))))
        along = first + np.linspace(0.0, 1.0, n + 1)[:, None] * (last - first)
        share = np.full(n + 1, 1.0 / n)
        share[[0, -1]] *= 0.5
        kept = ~is_out(along)
        places.append(along[kept])
        normals.append(np.tile(normal, (int(np.count_nonzero(kept)), 1)))
        tangents.append(np.tile((last - first) / length, (len(normals[-1]), 1)))
        weights.append(EDGE * np.sqrt(side) * length * share[kept])
    place = np.concatenate(places)
    place[:, thin] = (0.5 * (low + high))[thin]
    faces = [face for face in found.face if not on_faces(found.corner[face[face >= 0]]).all(axis=0).any()]
    face = np.array(faces if left_out is None else [], int).reshape(-1, 3)
    normal, tangent, weight = (np.concatenate(values) for values in (normals, tangents, weights))
    return EdgePoints(place, normal, tangent, weight, face, grid.thin())
