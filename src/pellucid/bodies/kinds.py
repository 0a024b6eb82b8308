"""The kinds of bodies: one line each. A body is built from its case, the grid's case, the grid and the velocity transfer."""

from typing import Any

from pellucid.bodies.elements_on_grid import ElementsOnGrid
from pellucid.bodies.material_points import MaterialPoints
from pellucid.bodies.membrane_elements import MembraneElements
from pellucid.bodies.membrane_points import MembranePoints

BODIES: dict[str, Any] = {
    "material-points": MaterialPoints,
    "membrane-points": MembranePoints,
    "membrane-elements": ElementsOnGrid,
}

ALONE: dict[str, Any] = {**BODIES, "membrane-elements": MembraneElements}
"""The same for a body that has a velocity field to itself: then elements move on nodes of their own."""
