"""The surroundings of a body when it is built: grid, velocity field and gravity."""

from typing import NamedTuple

from pellucid.grid.model import GridCase
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer


class Placement(NamedTuple):
    """The surroundings of a body when it is built. A case without a grid has no velocity field."""

    grid_case: GridCase | None
    velocity_field: VelocityField | None
    velocity_transfer: VelocityTransfer
    gravity: tuple[float, float, float]  # acceleration of gravity [m/s²], applied by bodies with their own nodes
    n_loads: int  # number of channels of external forces

    def on_grid(self) -> tuple[GridCase, VelocityField]:
        """Return grid and velocity field for a body that needs them. Its model must have checked that they exist."""
        if self.grid_case is None or self.velocity_field is None:
            raise ValueError("this body needs a grid, and the case has none")
        return self.grid_case, self.velocity_field
