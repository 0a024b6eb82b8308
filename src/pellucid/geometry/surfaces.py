"""Surfaces of membranes; a new one is one class in a file of its own and one line here."""

from functools import cached_property
from typing import ClassVar

from pellucid.geometry.choice import Choice
from pellucid.geometry.disc import Disc
from pellucid.geometry.icosphere import Icosphere
from pellucid.geometry.lid import Lid
from pellucid.geometry.sheets import Rectangle
from pellucid.geometry.surface_file import SurfaceFile
from pellucid.geometry.triangulation import Triangulation
from pellucid.geometry.tube import Tube

__all__ = ["Disc", "Icosphere", "Lid", "Rectangle", "Surface", "SurfaceFile", "Triangulation", "Tube"]


class Surface(Choice):
    """A table with one key that names the surface."""

    what: ClassVar[str] = "a surface"

    rectangle: Rectangle | None = None
    icosphere: Icosphere | None = None
    tube: Tube | None = None
    disc: Disc | None = None
    lid: Lid | None = None
    file: SurfaceFile | None = None

    def triangulate(self) -> Triangulation:
        """Vertices and triangles; the arrays are the caller's own."""
        return Triangulation(*(array.copy() for array in self._triangulation))

    @cached_property
    def _triangulation(self) -> Triangulation:
        triangulation: Triangulation = self.chosen().triangulate()
        return triangulation

    @property
    def closed(self) -> bool:
        """Whether it encloses a volume."""
        return bool(self.chosen().closed)
