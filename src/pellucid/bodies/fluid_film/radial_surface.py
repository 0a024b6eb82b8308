"""Closed surfaces in space by radial point interpolation on the tangent planes of their nodes (Benet 2015, chapter 5).

The stencils of nearest nodes change from triangle to triangle, and a single interpolant would jump. The interpolants of the
three corners are therefore blended: N_I = Σ_a b_a N_I^(a), with the barycentric coordinates b_a, over a parameter triangle
whose edges are curved like the surface; with flat edges the areas would be only as accurate as the areas of the triangles. The
surface passes through its nodes. The functions do not change while the nodes move, as in the mesh of an isoparametric element:
a rigid motion has no strain rate. They are recomputed when nodes have moved far relative to each other.
"""

from collections.abc import Mapping

import numpy as np

from pellucid.approximants.radial.blending import BlendedRows, Simplices, blended
from pellucid.approximants.radial.functions import RadialModel
from pellucid.approximants.radial.stencils import (
    Interpolants,
    Stencils,
    functions_at,
    interpolants,
    on_surface,
    tangents_across,
)
from pellucid.bodies.fluid_film.triangle_surface import SIX, SurfaceTables, TriangleRule, TriangleSurface
from pellucid.errors import RunStopped
from pellucid.geometry.meshes.triangulation import vertex_normals

CHUNK = 1024  # triangles
FAR = 0.05  # relative displacement of neighbours, in node spacings, after which functions are recomputed


class RadialSurface(TriangleSurface):
    """A closed surface through its nodes, initially at x (n, 3) [m]; six quadrature points per triangle are required."""

    def __init__(self, triangles: np.ndarray, x: np.ndarray, radial: RadialModel, rule: TriangleRule = SIX) -> None:
        super().__init__(triangles, len(x), rule)
        self._radial, self._rule = radial, rule
        around = on_surface(x, vertex_normals(x, triangles), radial.stencil_size(2)).nodes
        self._around = around  # stays, as the matrices of the film have places for these neighbours
        self.nodes, self._slots = _union(around[triangles])
        self._fit(np.array(x, dtype=float))

    def places(self, x: np.ndarray) -> np.ndarray:
        """Return x, the nodal values of a field: the surface passes through its nodes."""
        return np.array(x)

    def through(self, places: np.ndarray) -> np.ndarray:
        return np.array(places)

    def at(self, x: np.ndarray, triangle: np.ndarray, share: np.ndarray) -> np.ndarray:
        result = np.zeros((len(triangle), 3))
        for start in range(0, len(triangle), CHUNK):
            some = slice(start, start + CHUNK)
            result[some] = self._blended(triangle[some], share[some, None], 1).at_points(x)[:, 0]
        return result

    def renew(self, x: np.ndarray) -> None:
        moved = x - self._reference
        against = np.linalg.norm(moved[self.rings.neighbours] - moved[:, None], axis=2).max(axis=1)
        if (against > FAR * self.spacing(self._reference)).any():
            self._fit(x.copy())

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {"reference": self._reference}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        if not np.array_equal(arrays["reference"], self._reference):
            self._fit(np.array(arrays["reference"]))

    def _fit(self, x: np.ndarray) -> None:
        self._reference = x
        triangles = self.rings.triangles
        normal = vertex_normals(x, triangles)
        _check_not_folded(x, normal, self._around)
        tangents = tangents_across(normal)
        coordinates = np.einsum("nmi,ndi->nmd", x[self._around] - x[:, None], tangents)
        self._near = Stencils(self._around, tangents, coordinates)
        self._found: Interpolants = interpolants(coordinates, self._radial)
        along = np.einsum("nkm,nmi->nki", self._functions_at_nodes(), x[self._around])
        fitted = np.cross(along[:, 0], along[:, 1])
        fitted /= np.linalg.norm(fitted, axis=1)[:, None]
        self._simplices = Simplices(x, triangles, fitted)
        chunks = [np.arange(start, min(start + CHUNK, len(triangles))) for start in range(0, len(triangles), CHUNK)]
        parts = [self._blended(chunk, self._rule.shares, 2)[1:] for chunk in chunks]
        value, first, second = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        self.tables = SurfaceTables(np.arange(len(triangles)), value, first, second, 0.5 * self._rule.weights)

    def _functions_at_nodes(self) -> np.ndarray:
        """Return the first derivatives of the shape functions of each stencil at its own node, shape (n, 2, m)."""
        n = len(self._around)
        return functions_at(self._found, np.zeros((n, 1, 2)), derivatives=1).first[:, 0]

    def _blended(self, triangle: np.ndarray, share: np.ndarray, derivatives: int) -> BlendedRows:
        """Return the shape functions, blended from the functions of the stencils of the three corners, and their
        derivatives up to order `derivatives`, in triangles (k,) at barycentric coordinates `share`, shape (q, 3) for all
        triangles or (k, q, 3)."""
        part = self._simplices._replace(corners=self._simplices.corners[triangle])
        return blended(part, self._near, self._found, share, derivatives).united(self.nodes[triangle], self._slots[triangle])


def _check_not_folded(x: np.ndarray, normal: np.ndarray, around: np.ndarray) -> None:
    """Raise RunStopped if the surface in a stencil is bent by more than a right angle.

    x: nodal positions [m], shape (n, 3); normal: unit normals at the nodes, shape (n, 3); around: nodes of each stencil, (n,
    m).
    """
    alike = np.einsum("nmi,ni->nm", normal[around], normal).min(axis=1)
    worst = int(alike.argmin())
    if alike[worst] <= 0.0:
        place = ", ".join(f"{value:.6g}" for value in x[worst])
        text = f"the surface bends so much at node {worst} that its stencil folds over itself"
        advice = 'use more nodes, or interpolation = "loop"'
        raise RunStopped(f"{text}, near ({place}) m: {advice}", node=worst, position=tuple(x[worst].tolist()))


def _union(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the distinct nodes of each element, shape (e, m), and the positions among them of the nodes of its three stencils
    (e, 3, s). nodes: nodes of the stencils, shape (e, 3, s).

    If an element has fewer than m nodes, the last one is repeated; its functions are stored at its first position.
    """
    e, _, s = nodes.shape
    flat = nodes.reshape(e, -1)
    order = np.argsort(flat, axis=1, kind="stable")
    ranked = np.take_along_axis(flat, order, axis=1)
    rank = np.cumsum(np.diff(ranked, axis=1, prepend=ranked[:, :1]) > 0, axis=1).astype(np.int64)
    m = int(rank.max()) + 1
    union = np.repeat(ranked[:, -1:], m, axis=1)
    np.put_along_axis(union, rank, ranked, axis=1)
    slots = np.empty_like(flat)
    np.put_along_axis(slots, order, rank, axis=1)
    return union, slots.reshape(e, 3, s)
