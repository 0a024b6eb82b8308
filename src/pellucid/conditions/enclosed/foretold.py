"""Enclosed volume and mobility of closed membranes, computed from their data models before the bodies are built. They give
an estimate of the rate at which a membrane oscillates on enclosed gas or liquid."""

from typing import NamedTuple

import numpy as np

from pellucid.bodies.membranes.model import MembraneCase
from pellucid.conditions.enclosed.problems import volume_at_start
from pellucid.geometry.meshes.cells import corner_areas, vector_areas
from pellucid.parts.body_model import BodyModel


class AtStart(NamedTuple):
    """A membrane at the start: its enclosed volume [m³], and the mobility Σ A²/m [m⁴/kg], i.e. the second time derivative of
    this volume per unit pressure, with vector area A and mass m of each node."""

    volume: float
    mobility: float


def membrane_at_start(body: BodyModel) -> AtStart | None:
    """Return the enclosed volume [m³] of a membrane at the start, and the acceleration of this volume per pressure
    difference, as in `AtStart`; None for other bodies or if no volume is enclosed."""
    if not isinstance(body, MembraneCase):
        return None
    vertices, triangles = body.surface.triangulate()
    thirds = np.linalg.norm(vector_areas(vertices, triangles), axis=1) / 3.0
    sizes = np.bincount(triangles.ravel(), np.repeat(thirds, 3), len(vertices))
    mass = body.material.density * body.thickness * sizes
    volume = volume_at_start(vertices, triangles)
    if volume <= 0.0:
        return None
    return AtStart(volume, float(np.sum(np.square(corner_areas(vertices, triangles)) / mass[:, None])))
