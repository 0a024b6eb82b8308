"""Selection of the surface of a membrane in a case by one key. To add a surface, define its class in its own file and add a
field with its key to `Surface`."""

from functools import lru_cache
from typing import Any, ClassVar, Literal

import numpy as np

from pellucid.geometry.choice import Choice
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import Triangulation
from pellucid.geometry.shapes.rotation import Rotations, rotate_parameter, turn_about
from pellucid.geometry.surfaces.biconcave import Biconcave
from pellucid.geometry.surfaces.box import BoxSurface
from pellucid.geometry.surfaces.cushion import CushionSurface
from pellucid.geometry.surfaces.cylinder import CylinderSurface
from pellucid.geometry.surfaces.disc import Disc
from pellucid.geometry.surfaces.file import SurfaceFile
from pellucid.geometry.surfaces.icosphere import EllipsoidSurface, Icosphere
from pellucid.geometry.surfaces.rectangle import Lid, Rectangle
from pellucid.geometry.surfaces.sphere import SphereSurface
from pellucid.geometry.surfaces.tube import Tube

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
