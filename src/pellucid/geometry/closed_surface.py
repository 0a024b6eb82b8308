"""The triangles of a surface that encloses a volume."""

from pellucid.geometry.surface_checks import faults
from pellucid.geometry.surfaces import Surface
from pellucid.geometry.triangulation import Triangulation


def closed_triangles(surface: Surface) -> Triangulation:
    """The surface in triangles, normals outward. Raises ValueError with its first fault where it does not enclose a volume."""
    triangulation = surface.triangulate()
    if not surface.closed:
        raise ValueError("the surface is open: it has no inside; use one that encloses a volume, of files with `closed = true`")
    for text, _ in faults(*triangulation, closed=True):
        raise ValueError(f"of the surface: {text}; mend it, as only a whole closed surface can be filled")
    return triangulation
