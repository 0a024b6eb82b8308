"""Radial point interpolation over segments or triangles: the functions of their corners' stencils, blended.

At a point of a simplex with shares b_a of its corners, N_I = Σ_a b_a N_I^(a), where N^(a) are the functions of the stencil of
corner a. Without blending the stencil would change abruptly from one simplex to the next, and a patch test would fail.
"""

from typing import NamedTuple

import numpy as np

from pellucid.approximants.radial.neighbourhoods import Stencils
from pellucid.approximants.radial.stencils import Interpolants, functions_at


class Rows(NamedTuple):
    """Shape functions at q points of each of t simplices in d dimensions; a node may stand several times in a row."""

    nodes: np.ndarray  # (t, r)
    value: np.ndarray  # (t, q, r)
    first: np.ndarray  # (t, q, d, r) derivatives by the shares of the corners but the first

    def at_points(self, of_nodes: np.ndarray) -> np.ndarray:
        """A field at the points, shape (t, q, k), from its values at the nodes, shape (n, k)."""
        return self.value @ of_nodes[self.nodes]

    def slopes(self, of_nodes: np.ndarray) -> np.ndarray:
        """Its derivatives, shape (t, q, d, k)."""
        return self.first @ of_nodes[self.nodes][:, None]


class Simplices(NamedTuple):
    """Segments of a curve or triangles of a surface between points."""

    points: np.ndarray  # (n, k) [m]
    corners: np.ndarray  # (t, d + 1) numbers of the points
    normals: np.ndarray | None  # (n, k) units at the points; None where all simplices lie in one line or plane


def blended(simplices: Simplices, near: Stencils, found: Interpolants, shares: np.ndarray) -> Rows:
    """Shape functions at the points of each simplex with these shares of its corners, shape (q, d + 1).

    near, found: the stencils of all points in their order, and the interpolants on these.
    """
    corners, d = simplices.corners, simplices.corners.shape[1] - 1
    slopes = np.concatenate([-np.ones((1, d)), np.eye(d)])  # of the shares
    place, along = _places(simplices, shares, slopes)
    values, firsts = [], []
    for a in range(d + 1):
        tangents = near.tangents[corners[:, a]]
        coordinates = np.einsum("tqk,tdk->tqd", place - simplices.points[corners[:, a]][:, None], tangents)
        local = functions_at(found, coordinates, corners[:, a], derivatives=1)
        turned = np.einsum("tqbk,tdk->tqbd", along, tangents)
        values.append(shares[:, a, None] * local.value)
        share = shares[:, a, None, None] * (turned @ local.first)
        firsts.append(share + slopes[a][:, None] * local.value[:, :, None])
    nodes = near.nodes[corners].reshape(len(corners), -1)
    return Rows(nodes, np.concatenate(values, axis=2), np.concatenate(firsts, axis=3))


def _places(simplices: Simplices, shares: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points over simplices, whose edges are bowed to meet the normals, and their derivatives, (t, q, k) and (t, q, d, k).

    The middle of an edge is lifted by (x_j - x_i)·(n_j - n_i)/8 along the mean normal: flat ones give areas of order h² only.
    """
    corner = simplices.points[simplices.corners]
    place = np.einsum("qa,tak->tqk", shares, corner)
    along = np.broadcast_to(
        np.einsum("ab,tak->tbk", slopes, corner)[:, None], (*place.shape[:2], slopes.shape[1], place.shape[2])
    )
    if simplices.normals is None:
        return place, along
    normal = simplices.normals[simplices.corners]
    for i in range(corner.shape[1]):
        for j in range(i):
            mean = normal[:, i] + normal[:, j]
            mean = mean / np.linalg.norm(mean, axis=1)[:, None]
            height = 0.125 * np.einsum("tk,tk->t", corner[:, j] - corner[:, i], normal[:, j] - normal[:, i])
            bow = 4.0 * (height[:, None] * mean)[:, None]
            place = place + (shares[:, i] * shares[:, j])[:, None] * bow
            change = shares[:, i, None] * slopes[j] + shares[:, j, None] * slopes[i]  # (q, d)
            along = along + change[:, :, None] * bow[:, :, None]
    return place, along
