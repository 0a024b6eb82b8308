"""Stencils of nearest neighbours along a curve, and on scattered points of a surface, in tangential coordinates."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from pellucid.approximants.radial.stencils import StencilError

FOLDED = "is too wide for the curvature of the {what}: projected along the normal, the stencil overlaps itself; use more nodes"


class Stencils(NamedTuple):
    """Stencils of m nodes around each of n points in k dimensions, with coordinates of the nodes along d tangents at the
    point."""

    nodes: np.ndarray  # (n, m) numbers of the points; on a surface the nearest first, on a curve in their order along it
    tangents: np.ndarray  # (n, d, k) orthonormal tangents at the points
    coordinates: np.ndarray  # (n, m, d) coordinates of the nodes along the tangents, relative to the point [m]


def along_curve(points: np.ndarray, size: int, closed: bool) -> Stencils:
    """Return stencils of `size` neighbours along a curve through ordered points, shape (n, k) [m]; closed: True if the last
    point is a neighbour of the first.

    Stencils are centred, except at the ends of an open curve. Raises StencilError if there are too few points, or if a
    stencil bends back.
    """
    n = len(points)
    if n < size:
        raise StencilError(0, f"needs {size} points, but the curve has {n}; use more points, or decrease `neighbours`")
    first = np.arange(n) - size // 2
    if not closed:
        first = np.clip(first, 0, n - size)
    nodes = (first[:, None] + np.arange(size)) % n
    number = np.arange(n)
    back, on = number - 1, (number + 1) % n
    if not closed:
        back, on = np.maximum(number - 1, 0), np.minimum(number + 1, n - 1)
    secant = points[on] - points[back]
    tangents = (secant / np.linalg.norm(secant, axis=1)[:, None])[:, None]
    coordinates = _coordinates(points, nodes, tangents)
    folded = np.flatnonzero((np.diff(coordinates[:, :, 0], axis=1) <= 0.0).any(axis=1))
    if folded.size:
        raise StencilError(int(folded[0]), FOLDED.format(what="curve"))
    return Stencils(nodes, tangents, coordinates)


def on_surface(points: np.ndarray, normals: np.ndarray, size: int) -> Stencils:
    """Return stencils of the `size` nearest points on a surface through points [m] with unit normals, shape (n, 3) each.

    Points whose normals differ by more than a right angle lie on another part of the surface, and are not neighbours. Raises
    StencilError if too few are left.
    """
    tree, n, wanted = cKDTree(points), len(points), size
    if n < size:
        raise StencilError(0, f"needs {size} points, but the surface has {n}; use more points, or decrease `neighbours`")
    while True:
        found = tree.query(points, wanted)[1].reshape(n, wanted)
        alike = np.einsum("nmk,nk->nm", normals[found], normals) > 0.0
        lacking = np.flatnonzero(alike.sum(axis=1) < size)
        if not lacking.size:
            break
        if wanted == n:
            raise StencilError(int(lacking[0]), FOLDED.format(what="surface"))
        wanted = min(2 * wanted, n)
    order = np.argsort(~alike, axis=1, kind="stable")[:, :size]
    nodes = np.take_along_axis(found, order, axis=1)
    tangents = tangents_across(normals)
    return Stencils(nodes, tangents, _coordinates(points, nodes, tangents))


def tangents_across(normals: np.ndarray) -> np.ndarray:
    """Return two unit vectors, perpendicular to each unit normal, that form a right-handed frame with it, shape (n, 2, 3);
    normals: shape (n, 3)."""
    least = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    one = np.cross(normals, least)
    one /= np.linalg.norm(one, axis=1)[:, None]
    return np.stack([one, np.cross(normals, one)], axis=1)


def _coordinates(points: np.ndarray, nodes: np.ndarray, tangents: np.ndarray) -> np.ndarray:
    return np.einsum("nmk,ndk->nmd", points[nodes] - points[:, None], tangents)
