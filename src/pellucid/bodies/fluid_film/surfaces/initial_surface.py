"""Geometry and nodes of a film that is initially a given closed surface in space."""

from typing import Literal

import numpy as np

from pellucid.approximants.radial.contract import RadialModel
from pellucid.bodies.fluid_film.surfaces.loop_surface import LoopSurface
from pellucid.bodies.fluid_film.surfaces.radial_surface import RadialSurface
from pellucid.bodies.fluid_film.surfaces.triangle_surface import TriangleSurface
from pellucid.geometry.meshes.points import side_by_side
from pellucid.geometry.meshes.triangulation import Triangulation


def film_surface(mesh: Triangulation, interpolation: RadialModel | Literal["loop"]) -> tuple[TriangleSurface, np.ndarray]:
    """Return the geometry of a film through the vertices of a closed mesh with outward normals, and its nodes [m], shape (n,
    3).

    interpolation: settings of radial functions, or "loop" for Loop subdivision. Nodes are in spatial order (`spatial_order`).
    Nodes of Loop surfaces are distributed evenly along the surface, as required for the curvature. Raises ValueError if the
    mesh is not closed, or has too few nodes for the stencils of radial functions.
    """
    ordered = side_by_side(mesh)
    if interpolation != "loop":
        return RadialSurface(ordered.triangles, ordered.vertices, interpolation), ordered.vertices
    surface = LoopSurface(ordered.triangles, len(ordered.vertices))
    return surface, surface.smoothed(surface.through(ordered.vertices))
