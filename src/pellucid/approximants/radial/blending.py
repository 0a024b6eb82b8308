"""Radial point interpolation over segments or triangles: the shape functions of the corners' stencils are blended.

At a point of a simplex with barycentric coordinates b_a, N_I = Σ_a b_a N_I^(a), where N^(a) are the functions of the stencil of
corner a. Without blending the stencil would change abruptly from one simplex to the next, and a patch test would fail.
"""

from typing import NamedTuple

import numpy as np

from pellucid.approximants.radial.stencils import Interpolants, Stencils, functions_at


class BlendedRows(NamedTuple):
    """Shape functions and derivatives at q points of each of t simplices in d dimensions, in r entries per point; several
    entries may belong to the same node, and their sum is then the function of the node."""

    nodes: np.ndarray  # (t, r) numbers of the nodes
    value: np.ndarray  # (t, q, r) shape functions
    first: np.ndarray  # (t, q, d, r) derivatives by the barycentric coordinates of all corners except the first
    second: np.ndarray  # (t, q, p, r) second derivatives: 11; or 11, 12, 22; (t, q, 0, r) if not requested

    def at_points(self, of_nodes: np.ndarray) -> np.ndarray:
        """Return the values of a field at the points, shape (t, q, k), from its nodal values, shape (n, k)."""
        return self.value @ of_nodes[self.nodes]

    def slopes(self, of_nodes: np.ndarray) -> np.ndarray:
        """Return the derivatives of a field at the points by the barycentric coordinates of all corners except the first, shape
        (t, q, d, k), from its nodal values, shape (n, k)."""
        return self.first @ of_nodes[self.nodes][:, None]

    def united(self, nodes: np.ndarray, slots: np.ndarray) -> "BlendedRows":
        """Return the shape functions with one entry per node of a simplex: entries of the same node are added.

        nodes: numbers of the m nodes of each simplex, shape (t, m). slots: index in `nodes` of each node in the stencils of
        the corners, shape (t, d + 1, s), with s nodes per stencil.
        """
        here, parts = np.arange(len(slots))[:, None], []
        for functions in self[1:]:
            whole = np.zeros((*functions.shape[:-1], nodes.shape[1]))
            own = np.split(np.moveaxis(functions, -1, 1), slots.shape[1], axis=1)
            for corner, of_corner in enumerate(own):  # each node occurs once in a stencil
                np.moveaxis(whole, -1, 1)[here, slots[:, corner]] += of_corner
            parts.append(whole)
        return BlendedRows(nodes, *parts)


class Simplices(NamedTuple):
    """Segments of a curve or triangles of a surface: positions of the points, and the numbers of the points at the corners."""

    points: np.ndarray  # (n, k) positions [m]
    corners: np.ndarray  # (t, d + 1) numbers of the points
    normals: np.ndarray | None  # (n, k) unit normals at the points; None if all simplices lie in one line or plane


class Places(NamedTuple):
    """Points on simplices, and derivatives of their positions by the barycentric coordinates of all corners except the
    first."""

    place: np.ndarray  # (t, q, k) positions [m]
    first: np.ndarray  # (t, q, d, k) first derivatives [m]
    second: np.ndarray  # (t, p, k) second derivatives [m] by p pairs of coordinates, the same at all points


def blended(simplices: Simplices, near: Stencils, found: Interpolants, shares: np.ndarray, derivatives: int = 1) -> BlendedRows:
    """Return the shape functions at q points of each of t simplices, blended from the shape functions of the stencils of
    their corners.

    near: stencils of all points, in the order of the points; found: interpolants of these stencils; shares: barycentric
    coordinates of the q points, shape (q, d + 1) or (t, q, d + 1); derivatives: 1 or 2, order of the highest derivatives.
    """
    corners, d = simplices.corners, simplices.corners.shape[1] - 1
    slopes = np.concatenate([-np.ones((1, d)), np.eye(d)])  # of the barycentric coordinates
    pairs = [(i, j) for i in range(d) for j in range(i, d)] if derivatives > 1 else []
    shares = np.broadcast_to(shares, (len(corners), *shares.shape[-2:]))
    over = _places(simplices, shares, slopes, pairs)
    parts = []
    for a in range(d + 1):
        tangents, share = near.tangents[corners[:, a]], shares[:, :, a, None]
        coordinates = np.einsum("tqk,tdk->tqd", over.place - simplices.points[corners[:, a]][:, None], tangents)
        local = functions_at(found, coordinates, corners[:, a], derivatives)
        turned = np.einsum("tqbk,tdk->tqbd", over.first, tangents)
        first = turned @ local.first
        own = [share * local.value, share[..., None] * first + slopes[a][:, None] * local.value[:, :, None]]
        own.append(np.zeros((*local.value.shape[:2], len(pairs), local.value.shape[2])))
        if pairs:
            bent = np.stack([turned[:, :, i, :, None] * turned[:, :, j, None] for i, j in pairs], axis=2)
            second = np.einsum("tqdgm,tqpdg->tqpm", local.second, bent)
            second += np.einsum("tqdm,tpd->tqpm", local.first, np.einsum("tpk,tdk->tpd", over.second, tangents))
            mixed = np.stack([slopes[a, i] * first[:, :, j] + slopes[a, j] * first[:, :, i] for i, j in pairs], axis=2)
            own[2] += share[..., None] * second + mixed
        parts.append(own)
    value, first, second = (np.concatenate(arrays, axis=-1) for arrays in zip(*parts, strict=True))
    return BlendedRows(near.nodes[corners].reshape(len(corners), -1), value, first, second)


def _places(simplices: Simplices, shares: np.ndarray, slopes: np.ndarray, pairs: list[tuple[int, int]]) -> Places:
    """Return points on simplices, whose edges are first curved to match the normals, and derivatives of the positions.

    shares: barycentric coordinates, shape (t, q, d + 1); slopes: derivatives of the barycentric coordinates by the
    coordinates of all corners except the first, shape (d + 1, d); pairs: indices of the two coordinates of each second
    derivative. The middle of an edge is shifted by (x_j - x_i)·(n_j - n_i)/8 along the mean normal; flat simplices give
    areas only of order h².
    """
    corner = simplices.points[simplices.corners]
    place = np.einsum("tqa,tak->tqk", shares, corner)
    flat = np.einsum("ab,tak->tbk", slopes, corner)[:, None]
    first = np.broadcast_to(flat, (*place.shape[:2], slopes.shape[1], place.shape[2]))
    second = np.zeros((len(corner), len(pairs), place.shape[2]))
    if simplices.normals is None:
        return Places(place, first, second)
    normal = simplices.normals[simplices.corners]
    for i in range(corner.shape[1]):
        for j in range(i):
            mean = normal[:, i] + normal[:, j]
            mean = mean / np.linalg.norm(mean, axis=1)[:, None]
            height = 0.125 * np.einsum("tk,tk->t", corner[:, j] - corner[:, i], normal[:, j] - normal[:, i])
            bow = 4.0 * height[:, None] * mean
            place = place + (shares[..., i] * shares[..., j])[..., None] * bow[:, None]
            change = shares[..., i, None] * slopes[j] + shares[..., j, None] * slopes[i]  # (t, q, d)
            first = first + change[..., None] * bow[:, None, None]
            turn = np.array([slopes[i, p] * slopes[j, r] + slopes[j, p] * slopes[i, r] for p, r in pairs])
            second += turn.reshape(-1, 1) * bow[:, None]
    return Places(place, first, second)
