"""The kinds of bodies: one line each. A body is built from its case, the grid's case, the grid and the velocity transfer."""

from typing import Any

from pellucid.bodies.material_points.body import MaterialPoints
from pellucid.bodies.membrane_elements.on_grid import ElementsOnGrid
from pellucid.bodies.membrane_elements.on_own_nodes import MembraneElements
from pellucid.bodies.membrane_points.body import MembranePoints

BODIES: dict[str, Any] = {
    "material-points": MaterialPoints,
    "membrane-points": MembranePoints,
    "membrane-elements": ElementsOnGrid,
}

ALONE: dict[str, Any] = {**BODIES, "membrane-elements": MembraneElements}
"""The same for a body that has a velocity field to itself: then elements move on nodes of their own."""
