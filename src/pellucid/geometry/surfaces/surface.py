"""Selection of the surface of a membrane in a case by one key, and the region inside a closed surface. To add a surface, define
its class in a module of this folder and add a field with its key to `Surface`."""

from functools import lru_cache
from typing import Any, ClassVar, Literal

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.checks.surface_checks import faults
from pellucid.geometry.choice import Choice
from pellucid.geometry.meshes.enclosure import enclosed_volume, inside
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import Triangulation, bounding_box
from pellucid.geometry.shapes.contract import ActiveAxes, Geometry, SharpEdges, edges_of_triangles
from pellucid.geometry.shapes.rotation import Rotations, rotate_parameter, turn_about
from pellucid.geometry.surfaces.file import SurfaceFile
from pellucid.geometry.surfaces.quadrilaterals import (
    BoxSurface,
    CushionSurface,
    CylinderSurface,
    Lid,
    Rectangle,
    SphereSurface,
    Tube,
)
from pellucid.geometry.surfaces.triangles import Biconcave, Disc, EllipsoidSurface, Icosphere
from pellucid.model import check, parameter

Elements = Literal["quads", "triangles"]
"""Elements of a surface: "quads" keeps its quadrilaterals; "triangles" divides them into triangles."""


class Surface(Choice):
    """A table with exactly one key, which selects the surface."""

    what: ClassVar[str] = "a surface"
    beside: ClassVar[tuple[str, ...]] = ("rotate",)

    rectangle: Rectangle | None = None
    icosphere: Icosphere | None = None
    ellipsoid: EllipsoidSurface | None = None
    biconcave: Biconcave | None = None
    tube: Tube | None = None
    disc: Disc | None = None
    lid: Lid | None = None
    box: BoxSurface | None = None
    cylinder: CylinderSurface | None = None
    sphere: SphereSurface | None = None
    cushion: CushionSurface | None = None
    file: SurfaceFile | None = None
    rotate: Rotations = rotate_parameter("the surface")

    def mesh(self, elements: Elements = "quads") -> Mesh:
        """Return the mesh in new arrays; with elements = "triangles", quadrilaterals are divided into triangles."""
        chosen = self.chosen()
        # not cached here for a file, which may change and has its own cache
        mesh = chosen.mesh() if isinstance(chosen, SurfaceFile) else Mesh(*(array.copy() for array in _made(chosen)))
        if self.rotate is not None:
            middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
            mesh = mesh._replace(vertices=turn_about(self.rotate, middle).forth(mesh.vertices))
        return mesh if elements == "quads" else Mesh(mesh.vertices, triangles=mesh.triangulated().triangles)

    def triangulate(self) -> Triangulation:
        """Return the triangulation of the mesh, with the same vertices."""
        return self.mesh().triangulated()

    def sets(self) -> dict[str, np.ndarray]:
        """Return the vertex numbers of each named set of the mesh file, by name; empty for a generated surface."""
        chosen = self.chosen()
        return chosen.sets() if isinstance(chosen, SurfaceFile) else {}

    @property
    def closed(self) -> bool:
        """True if the surface encloses a volume."""
        return bool(self.chosen().closed)


@lru_cache(maxsize=8)
def _made(surface: Any) -> Mesh:
    """Return the mesh of the selected surface; it is cached, because reading a case uses it several times."""
    mesh: Mesh = surface.mesh()
    return mesh


class Inside(Geometry):
    """The region inside a closed triangulated surface, for grids without thin axes; a piece inside another piece is a hole."""

    surface: Surface = parameter(
        "", "closed surface: a sphere, a box, a cylinder with lids, an icosphere, or a closed mesh file"
    )

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return self._bounds_of_surface()

    def _bounds_of_surface(self) -> tuple[np.ndarray, np.ndarray]:
        return bounding_box(self.surface.triangulate().vertices)

    def reach(self, direction: np.ndarray) -> float:
        return float((self.surface.triangulate().vertices @ direction).max())

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        lower, upper = self._bounds_of_surface()
        found = np.all((points >= lower) & (points <= upper), axis=1)
        found[found] = inside(points[found], *self.surface.triangulate())
        return found

    def measure(self, active: ActiveAxes) -> float:
        return enclosed_volume(*self.surface.triangulate())

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        return edges_of_triangles(self.surface.triangulate())


class Outside(Inside):
    """The region outside a closed triangulated surface, such as that of a channel, for grids without thin axes. On a grid with
    periodic axes the surface must extend beyond the grid along these axes."""

    @check
    def _is_closed(self) -> None:
        closed_triangles(self.surface)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return np.full(3, -np.inf), np.full(3, np.inf)

    def centre(self) -> np.ndarray:
        lower, upper = self._bounds_of_surface()
        return np.asarray(0.5 * (lower + upper))

    def reach(self, direction: np.ndarray) -> float:
        return np.inf

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        return ~super().contains(points, active)

    def measure(self, active: ActiveAxes) -> float:
        return np.inf


def closed_triangles(surface: Surface) -> Triangulation:
    """Return the triangulation of a surface, with outward normals. Raises ValueError with the first fault of the mesh if the
    surface is not closed."""
    triangulation = surface.triangulate()
    if not surface.closed:
        raise Refusal(
            "the surface is open, so it has no inside", "use a closed surface; for a closed mesh file, set `closed = true`"
        )
    for text, remedy in faults(*triangulation, closed=True):
        raise Refusal(f"the surface cannot be filled: {text}", remedy)
    return triangulation
