"""The surroundings of a body when it is built: grid, velocity field and gravity."""

from typing import NamedTuple

from pellucid.grid.model import GridCase
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer


class Placement(NamedTuple):
    """Input for building a body from its model (`BodyModel.build`): grid, velocity field and gravity. A case without a grid
    has no velocity field."""

    grid_case: GridCase | None  # table [grid] of the case
    velocity_field: VelocityField | None  # grid nodes that the body shares with other bodies of its field
    velocity_transfer: VelocityTransfer  # transfer of velocities between points and grid, such as FLIP
    gravity: tuple[float, float, float]  # acceleration of gravity [m/s²], applied by bodies with their own nodes
    n_loads: int  # number of channels of external forces

    def on_grid(self) -> tuple[GridCase, VelocityField]:
        """Return the table of the grid and the velocity field for a body that needs both; the model of the body must have
        checked before that the case has a grid."""
        if self.grid_case is None or self.velocity_field is None:
            raise ValueError("this body needs a grid, and the case has none")
        return self.grid_case, self.velocity_field
