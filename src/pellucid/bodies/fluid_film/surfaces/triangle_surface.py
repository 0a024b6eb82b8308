"""The base class of closed surfaces of triangles in space, independent of the interpolation."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.mesh_smoothing.cell_fluxes import CellFluxes
from pellucid.bodies.fluid_film.mesh_smoothing.smoothing import WELL_SPREAD, check_quality, way_along
from pellucid.bodies.fluid_film.mesh_smoothing.surface_point_location import places_along
from pellucid.bodies.fluid_film.surfaces.contract import Redistributed, Shares
from pellucid.bodies.fluid_film.surfaces.operators import Operators
from pellucid.bodies.fluid_film.surfaces.triangle_operators import SurfaceTables, surface_areas, surface_operators
from pellucid.geometry.checks.quality import triangle_qualities
from pellucid.geometry.meshes.cells import Cells
from pellucid.geometry.meshes.quadrature import TRIANGLE, TRIANGLE_WEIGHTS
from pellucid.geometry.meshes.triangulation import rings, vertex_normals


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
