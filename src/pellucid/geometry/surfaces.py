"""Surfaces of membranes; a new one is one class in a file of its own and one line here."""

from functools import lru_cache
from typing import Any, ClassVar

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
        chosen = self.chosen()
        if isinstance(chosen, SurfaceFile):  # which may change, and keeps what it read
            return chosen.triangulate()
        return Triangulation(*(array.copy() for array in _made(chosen)))

    @property
    def closed(self) -> bool:
        """Whether it encloses a volume."""
        return bool(self.chosen().closed)


@lru_cache(maxsize=8)
def _made(surface: Any) -> Triangulation:
    """Made once: reading a case asks for it several times."""
    triangulation: Triangulation = surface.triangulate()
    return triangulation
