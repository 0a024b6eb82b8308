"""Enclosed volume and mobility of closed membranes, computed from their data models before the bodies are built. They give
an estimate of the rate at which a membrane oscillates on enclosed gas or liquid."""

from typing import NamedTuple

import numpy as np

from pellucid.bodies.membranes.model import MembraneCase
from pellucid.conditions.enclosed.problems import volume_at_start
from pellucid.geometry.meshes.cells import corner_areas, vector_areas
from pellucid.parts.body_model import BodyModel


class AtStart(NamedTuple):
    """State of a membrane at the start, from which the stable step of an enclosed volume is estimated before the run."""

    volume: float  # enclosed volume [m³]
    mobility: float  # second time derivative of the volume per unit of gauge pressure [m⁴/kg]: Σ A²/m over the nodes,
    # with the vector area A and the mass m of a node


def membrane_at_start(body: BodyModel) -> AtStart | None:
    """Return the enclosed volume of a membrane at the start [m³], and the acceleration of this volume per unit of gauge
    pressure [m⁴/kg]; None for other bodies, or if no volume is enclosed."""
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
