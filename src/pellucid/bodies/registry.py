"""The kinds of bodies: one line each."""

from collections.abc import Callable

from pellucid.bodies.contract import GridBody, NodalBody
from pellucid.bodies.material_points.body import MaterialPoints
from pellucid.bodies.membrane_elements.on_grid import ElementsOnGrid
from pellucid.bodies.membrane_elements.on_own_nodes import MembraneElements
from pellucid.bodies.membrane_points.body import MembranePoints

BODIES: dict[str, Callable[..., GridBody]] = {
    "material-points": MaterialPoints,
    "membrane-points": MembranePoints,
    "membrane-elements": ElementsOnGrid,
}
"""In a velocity field with others; each is built from its model, the model of the grid, the field and the velocity transfer."""

BODIES_ALONE: dict[str, Callable[..., NodalBody]] = {"membrane-elements": MembraneElements}
"""With a velocity field to itself; built from its model, the model of the grid, the field, gravity and the number of loads."""
