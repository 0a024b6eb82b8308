"""The triangles of a surface that encloses a volume."""

from pellucid.findings import Refusal
from pellucid.geometry.surface_checks import faults
from pellucid.geometry.surfaces import Surface
from pellucid.geometry.triangulation import Triangulation


def closed_triangles(surface: Surface) -> Triangulation:
    """The surface in triangles, normals outward. Raises ValueError with its first fault where it does not enclose a volume."""
    triangulation = surface.triangulate()
    if not surface.closed:
        raise Refusal(
            "the surface is open: it has no inside", "use one that encloses a volume; of files, `closed = true` says so"
        )
    for text, remedy in faults(*triangulation, closed=True):
        raise Refusal(f"of the surface: {text}; only a whole closed surface can be filled", remedy)
    return triangulation
