"""Surfaces of membranes; a new one is one class in a file of its own and one line here."""

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
"""Quadrilaterals where the surface has them, or triangles alone."""


class Surface(Choice):
    """A table with one key that names the surface."""

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
        """The elements, in arrays of the caller's own; where triangles alone are wanted, quadrilaterals are cut in two."""
        chosen = self.chosen()
        # a file may change, and keeps what it read
        mesh = chosen.mesh() if isinstance(chosen, SurfaceFile) else Mesh(*(array.copy() for array in _made(chosen)))
        if self.rotate is not None:
            middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
            mesh = mesh._replace(vertices=turn_about(self.rotate, middle).forth(mesh.vertices))
        return mesh if elements == "quads" else Mesh(mesh.vertices, triangles=mesh.triangulated().triangles)

    def triangulate(self) -> Triangulation:
        """Its mesh with every quadrilateral cut in two: the vertices are the same."""
        return self.mesh().triangulated()

    def sets(self) -> dict[str, np.ndarray]:
        """The sets of vertices that its file names, by their numbers."""
        chosen = self.chosen()
        return chosen.sets() if isinstance(chosen, SurfaceFile) else {}

    @property
    def closed(self) -> bool:
        """Whether it encloses a volume."""
        return bool(self.chosen().closed)


@lru_cache(maxsize=8)
def _made(surface: Any) -> Mesh:
    """The mesh of a surface, made once: reading a case asks for it several times."""
    mesh: Mesh = surface.mesh()
    return mesh
