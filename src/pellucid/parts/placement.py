"""With what a body is built."""

from typing import NamedTuple

from pellucid.grid.model import GridCase
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer


class Placement(NamedTuple):
    """With what a body is built; without a grid in the case there is no velocity field either."""

    grid_case: GridCase | None
    velocity_field: VelocityField | None
    velocity_transfer: VelocityTransfer
    gravity: tuple[float, float, float]  # [m/s²], which a body with its own nodes applies itself
    n_loads: int  # channels of external forces

    def on_grid(self) -> tuple[GridCase, VelocityField]:
        """Grid and velocity field of a body that needs them; its model checks that they are there."""
        if self.grid_case is None or self.velocity_field is None:
            raise ValueError("this body needs a grid, and the case has none")
        return self.grid_case, self.velocity_field
