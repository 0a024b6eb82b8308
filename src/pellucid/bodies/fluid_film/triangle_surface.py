"""The base class of closed surfaces of triangles in space, independent of the interpolation, and their operators, computed
from the shape functions of the nodes.

Definitions: tangents a_α, metric g, Christoffel symbols Γ, second derivatives x,αβ of the position, frame e₁ along a₁ and e₂ =
n × e₁; a bar denotes derivatives along the frame. The rate of deformation D, the curvature tensor κ and its trace J are 2D_ij =
e_i·v|j + e_j·v|i, κ_ij = -n·x|ij, J = κ₁₁ + κ₂₂. The exact change of J at a material point is

    δJ = -g^αβ n·(v,αβ - Γ^γ_αβ v,γ) - 2 κ_ij D_ij(v).

(Capovilla & Guven 2002, J. Phys. A 35, 6233; with signs for which the curvature of a sphere is positive.)
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.film_geometry import Operators, Redistributed, Shares
from pellucid.bodies.fluid_film.mesh_smoothing import WELL_SPREAD, CellFluxes, check_quality, places_along, way_along
from pellucid.geometry.checks.quality import triangle_qualities
from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.meshes.quadrature import TRIANGLE, TRIANGLE_WEIGHTS
from pellucid.geometry.meshes.triangulation import rings, vertex_normals
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_loop

CHUNK = 256  # triangles


class SurfaceTables(NamedTuple):
    """Shape functions of the m nodes of each triangle at its q quadrature points, and their derivatives with respect to the
    barycentric coordinates of corners 1 and 2."""

    kind: np.ndarray  # (e,) index of the table of each triangle
    value: np.ndarray  # (kinds, q, m) functions
    first: np.ndarray  # (kinds, q, 2, m) first derivatives
    second: np.ndarray  # (kinds, q, 3, m) second derivatives 11, 12, 22
    weight: np.ndarray  # (q,) quadrature weights; their sum is 1/2


class TriangleRule(NamedTuple):
    """Quadrature rule on a triangle: points as barycentric coordinates, shape (q, 3), and weights with the sum 1, shape
    (q,).
    """

    shares: np.ndarray  # (q, 3) barycentric coordinates of the points
    weights: np.ndarray  # (q,) weights, fractions of the area of the triangle


THREE = TriangleRule(np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3), np.full(3, 1.0 / 3.0))  # exact to degree 2
SIX = TriangleRule(TRIANGLE, TRIANGLE_WEIGHTS)  # exact to degree 4


class TriangleSurface(ABC):
    """A closed surface of triangles (e, 3) between n nodes, counterclockwise seen from outside, with a quadrature rule.

    The parts of the film with a mass of their own are the cells (areas) around the nodes: the barycentric coordinates
    distribute the area of each quadrature point among the corners.
    """

    axes: tuple[int, ...] = (0, 1, 2)
    nodes: np.ndarray
    tables: SurfaceTables

    def __init__(self, triangles: np.ndarray, n: int, rule: TriangleRule) -> None:
        self.rings = rings(triangles, n)
        self.held = np.zeros((n, 3), bool)
        self.shares = Shares(triangles, rule.shares)
        self._fluxes = CellFluxes(self.rings)

    @abstractmethod
    def places(self, x: np.ndarray) -> np.ndarray:
        """Interpolate a field with nodal values x, shape (n, k), to the points of the surface that belong to its nodes, shape
        (n, k). For positions x [m] these are the points through which the surface passes.
        """

    @abstractmethod
    def through(self, places: np.ndarray) -> np.ndarray:
        """Return the nodes (or control points) [m], shape (n, 3), of the surface that passes through the points `places`, shape
        (n, 3); the inverse of the method `places`."""

    @abstractmethod
    def at(self, x: np.ndarray, triangle: np.ndarray, share: np.ndarray) -> np.ndarray:
        """Return points of the surface [m], shape (k, 3), with nodes at x [m], shape (n, 3), in triangles (k,) at barycentric
        coordinates `share`, shape (k, 3).
        """

    def operators(self, x: np.ndarray) -> Operators:
        """Return the geometry of the film at its quadrature points and the operators that map nodal velocities to strain rate,
        slope and change of curvature (see `Operators`), for nodes at x [m], shape (n, 3).
        """
        return surface_operators(x, self.nodes, self.tables)

    def normals(self, x: np.ndarray) -> np.ndarray:
        """Return the outward unit normals of the surface at its nodes, shape (n, 3), with nodes at x [m], shape (n, 3)."""
        return vertex_normals(self.places(x), self.rings.triangles)

    def spacing(self, x: np.ndarray) -> np.ndarray:
        """Return the distance of each node from its nearest neighbour [m], shape (n,), with nodes at x [m], shape (n, 3)."""
        return np.asarray(np.linalg.norm(x[self.rings.neighbours] - x[:, None], axis=2).min(axis=1))

    def cells(self) -> Cells:
        """Return the triangles of the surface, which the results contain as cells."""
        return Cells(triangles=self.rings.triangles)

    def redistributed(self, x: np.ndarray, mass: np.ndarray, moved: np.ndarray) -> Redistributed:
        before, areas = self.places(x), self._cell_areas(x)
        after = self._along(x, before, way_along(self.rings, before, self.places(moved)))
        check_quality(self.rings.triangles, after)
        new = self.through(after)
        self.renew(new)
        return Redistributed(new, self._fluxes.moved(before, after, areas, self._cell_areas(new), mass))

    def can_wait(self, x: np.ndarray) -> bool:
        return bool(triangle_qualities(self.places(x), self.rings.triangles).min() >= WELL_SPREAD)

    def smoothed(self, x: np.ndarray, sweeps: int = 10) -> np.ndarray:
        """Return the nodes [m], shape (n, 3), after a number of sweeps that move them along the surface towards the centroids
        of the triangles around them. x: nodes before [m], shape (n, 3).
        """
        for _ in range(sweeps):
            places = self.places(x)
            x = self.through(self._along(x, places, way_along(self.rings, places, np.zeros_like(x))))
            self.renew(x)
        return x

    @abstractmethod
    def renew(self, x: np.ndarray) -> None:
        """Recompute the shape functions for nodes at x [m], shape (n, 3), if they depend on the nodal positions."""

    @abstractmethod
    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays for checkpoints on which the shape functions depend, in addition to the nodal positions."""

    @abstractmethod
    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the shape functions from the arrays of a checkpoint (see `state_arrays`)."""

    def _along(self, x: np.ndarray, places: np.ndarray, way: np.ndarray) -> np.ndarray:
        return places_along(self.rings, places, way, lambda triangle, share: self.at(x, triangle, share))

    def _cell_areas(self, x: np.ndarray) -> np.ndarray:
        areas = np.einsum("eq,qc->ec", surface_areas(x, self.nodes, self.tables), self.shares.share)
        return np.bincount(self.shares.part.ravel(), areas.ravel())


class Filled(NamedTuple):
    """The arrays of `Operators` that a kernel (`_fill`) computes: areas, positions, normals and curvatures at the
    quadrature points, and the coefficients of strain rate, slope and change of curvature; shapes and units as in
    `Operators`."""

    area: np.ndarray
    position: np.ndarray
    normal: np.ndarray
    strain: np.ndarray
    slope: np.ndarray
    curvature: np.ndarray
    bending: np.ndarray


@kernel(inner=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(inner=True)
def _sum(functions, x, nodes):
    a, b, c = 0.0, 0.0, 0.0
    for k in range(len(nodes)):
        f, i = functions[k], nodes[k]
        a, b, c = a + f * x[i, 0], b + f * x[i, 1], c + f * x[i, 2]
    return a, b, c


@parallel_loop()
def _fill(chunk, x, nodes, tables, filled):
    q, m = tables.value.shape[1], nodes.shape[1]
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(nodes))):
        kind, mine = tables.kind[e], nodes[e]
        for p in range(q):
            first, second = tables.first[kind, p], tables.second[kind, p]
            place = _sum(tables.value[kind, p], x, mine)
            a, b = _sum(first[0], x, mine), _sum(first[1], x, mine)
            aa, ab, bb = _sum(second[0], x, mine), _sum(second[1], x, mine), _sum(second[2], x, mine)
            cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
            jacobian, length = np.sqrt(_dot(cross, cross)), np.sqrt(_dot(a, a))
            n = (cross[0] / jacobian, cross[1] / jacobian, cross[2] / jacobian)
            e1 = (a[0] / length, a[1] / length, a[2] / length)
            e2 = (n[1] * e1[2] - n[2] * e1[1], n[2] * e1[0] - n[0] * e1[2], n[0] * e1[1] - n[1] * e1[0])
            t11, t22 = 1.0 / length, length / jacobian  # e₁ = t11 a₁, e₂ = t21 a₁ + t22 a₂
            t21 = -_dot(a, b) / (length * jacobian)
            f11, f12, f22 = t11 * t11 + t21 * t21, t21 * t22, t22 * t22  # g^αβ
            h = (
                f11 * aa[0] + 2.0 * f12 * ab[0] + f22 * bb[0],
                f11 * aa[1] + 2.0 * f12 * ab[1] + f22 * bb[1],
                f11 * aa[2] + 2.0 * f12 * ab[2] + f22 * bb[2],
            )
            h1, h2 = _dot(h, e1), _dot(h, e2)
            naa, nab, nbb = -_dot(n, aa), -_dot(n, ab), -_dot(n, bb)
            k11 = t11 * t11 * naa
            k12 = t11 * (t21 * naa + t22 * nab)
            k22 = t21 * t21 * naa + 2.0 * t21 * t22 * nab + t22 * t22 * nbb
            filled.area[e, p] = jacobian * tables.weight[p]
            filled.curvature[e, p] = k11 + k22
            for i in range(3):
                filled.position[e, p, i] = place[i]
                filled.normal[e, p, i] = n[i]
            for k in range(m):
                n1 = t11 * first[0, k]
                n2 = t21 * first[0, k] + t22 * first[1, k]
                laplacian = f11 * second[0, k] + 2.0 * f12 * second[1, k] + f22 * second[2, k] - h1 * n1 - h2 * n2
                along1, along2 = 2.0 * (k11 * n1 + k12 * n2), 2.0 * (k12 * n1 + k22 * n2)
                for i in range(3):
                    filled.strain[e, p, 0, k, i] = e1[i] * n1
                    filled.strain[e, p, 1, k, i] = e2[i] * n2
                    filled.strain[e, p, 2, k, i] = e1[i] * n2 + e2[i] * n1
                    filled.slope[e, p, 0, k, i] = n[i] * n1
                    filled.slope[e, p, 1, k, i] = n[i] * n2
                    filled.bending[e, p, k, i] = -n[i] * laplacian - e1[i] * along1 - e2[i] * along2


def surface_operators(x: np.ndarray, nodes: np.ndarray, tables: SurfaceTables) -> Operators:
    """Return the geometry and strain operators, at the quadrature points, of a surface with nodes at x [m], shape (n, 3).

    nodes: the m nodes on which each of the e triangles depends, shape (e, m); tables: shape functions of these nodes at the
    quadrature points.
    """
    e, m = nodes.shape
    q = len(tables.weight)
    filled = Filled(
        np.empty((e, q)),
        np.empty((e, q, 3)),
        np.empty((e, q, 3)),
        np.empty((e, q, 3, m, 3)),
        np.empty((e, q, 2, m, 3)),
        np.empty((e, q)),
        np.empty((e, q, m, 3)),
    )
    _fill(-(-e // CHUNK), np.ascontiguousarray(x, dtype=float), nodes, tables, filled)
    value = np.broadcast_to(tables.value[tables.kind][..., None], (e, q, m, 3))
    return Operators(
        filled.area, filled.position, filled.normal, value, filled.strain, filled.slope, filled.curvature, filled.bending
    )


@parallel_loop()
def _find_areas(chunk, x, nodes, tables, areas):
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(nodes))):
        for p in range(tables.value.shape[1]):
            first = tables.first[tables.kind[e], p]
            a, b = _sum(first[0], x, nodes[e]), _sum(first[1], x, nodes[e])
            cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
            areas[e, p] = np.sqrt(_dot(cross, cross)) * tables.weight[p]


def surface_areas(x: np.ndarray, nodes: np.ndarray, tables: SurfaceTables) -> np.ndarray:
    """Return the areas that belong to the q quadrature points of each of the e triangles of a surface [m²], shape (e, q).

    x: nodal positions [m], shape (n, 3); nodes: the m nodes on which each triangle depends, shape (e, m); tables: shape
    functions of these nodes at the quadrature points.
    """
    areas = np.empty((len(nodes), len(tables.weight)))
    _find_areas(-(-len(nodes) // CHUNK), np.ascontiguousarray(x, dtype=float), nodes, tables, areas)
    return areas
