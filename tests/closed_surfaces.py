"""Closed surfaces of all kinds as tables of a case file, and the surface of a red blood cell."""

import numpy as np

from pellucid.geometry.meshes.triangulation import Triangulation
from pellucid.geometry.surfaces.triangles import Icosphere

CLOSED = {
    "icosphere": {"centre": (0, 0, 0), "radius": 1e-5, "refinements": 2},
    "ellipsoid": {"centre": (0, 0, 0), "radii": (1, 0.5, 0.3), "refinements": 3},
    "sphere": {"centre": (0, 0, 0), "radius": 2.0, "divisions": 4},
    "box": {"lower": (0, 0, 0), "upper": (1, 2, 3), "points": (4, 5, 6)},
    "cylinder": {"start": (0, 0, 0), "end": (1, 1, 1), "radius": 0.4, "rings": 4, "along": 7},
    "cushion": {"centre": (0, 0, 0), "sides": (1, 1), "height": 0.3, "points": (9, 9)},
}


def red_cell(refinements: int) -> Triangulation:
    """Return the biconcave surface of a red blood cell (Evans & Fung 1972, Microvascular Research 4, 335), in micrometres."""
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=refinements).triangulate()
    away = np.hypot(vertices[:, 0], vertices[:, 1])
    half = 0.5 * np.sqrt(np.maximum(1.0 - away**2, 0.0)) * (0.207 + 2.003 * away**2 - 1.123 * away**4)
    return Triangulation(3.91 * np.column_stack([vertices[:, :2], np.sign(vertices[:, 2]) * half]), triangles)
