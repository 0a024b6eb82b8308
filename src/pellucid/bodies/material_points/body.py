"""A fluid or solid body of material points."""

from typing import Any

import numpy as np

from pellucid.approximants import grid_functions
from pellucid.bodies.grid_body import GridBody
from pellucid.bodies.material_points.derived_fields import point_energies, point_pressures
from pellucid.bodies.material_points.seeding import points_along_axes, seed
from pellucid.bodies.models import MaterialPointsCase
from pellucid.errors import CaseError, Problem
from pellucid.grid import transfer as kernels
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.grid.points import Slabs
from pellucid.jit.bundle import Bundle
from pellucid.materials.fluid import FluidMaterial
from pellucid.materials.point_state import ARRAYS_OF


class MaterialPoints(GridBody):
    """Points that fill a volume and carry what their law asks for."""

    def __init__(self, case: MaterialPointsCase, grid_case: GridCase, grid: Grid, velocity_transfer: Any) -> None:
        self.material = case.material
        self.law: Any = case.material.law()
        self.energy_kind = "internal" if isinstance(case.material, FluidMaterial) else "strain"
        per_cell = points_along_axes(case.points_per_cell, grid.thin)
        arrays = _initial_arrays(case, *_seeded(case, grid_case, per_cell))
        super().__init__(case.name, grid, grid_functions(grid_case.functions, per_cell, grid.thin), velocity_transfer, arrays)

    def bind(self) -> None:
        """Take up arrays that were replaced."""
        super().bind()
        state = ARRAYS_OF[type(self.material.initial_state())]
        self._carried = state(*(self.arrays[name] for name in state._fields))

    def _share(self, slabs: Slabs) -> None:
        super()._share(slabs)
        lattice, nodes = self.grid.lattice, self.grid.nodes
        self._strained = Bundle(self.functions, lattice, nodes, self.points, slabs, self.law, self._carried)

    def update_stress(self, dt: float, move: bool) -> None:
        """Velocity gradients, volumes, stresses; where `move`, new positions."""
        if self.constraint is not None and not self.constraint.strains:
            if move:
                self.update_positions(dt)
            self._bound_rate(float(np.linalg.norm(self.points.velocity, axis=1).max()) * self.grid.lattice.inverse_cell)
            return
        kernels.update_stress(self.n_slabs, self._strained, dt, int(move))
        if move:
            self.place()
        self._collect_strain_sums()

    def field(self, name: str) -> np.ndarray:
        """As for every body; the pressure of a fluid is that of its equation of state."""
        if name == "pressure" and isinstance(self.material, FluidMaterial):
            return point_pressures(self.law.eos, self.field("density"), self.arrays["internal_energy"])
        if name == "stored_energy":
            return self.arrays["mass"] * point_energies(self.law, self._carried, self.field("density"))
        return super().field(name)


def _seeded(case: MaterialPointsCase, grid: GridCase, per_cell: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    try:
        return seed(case.shape.geometry(), grid, per_cell, case.left_out)
    except ValueError as error:
        remedy = "use a smaller grid.cell or more points_per_cell"
        raise CaseError(Problem(str(error), f"body.{case.name}.outside", remedy=remedy)) from None


def _initial_arrays(case: MaterialPointsCase, position: np.ndarray, volume: np.ndarray) -> dict[str, np.ndarray]:
    n = len(position)
    if n == 0:
        raise CaseError(
            Problem(
                "no material point lies inside the shape: it is thinner than the distance between points",
                f"body.{case.name}.shape",
                remedy="use a smaller grid.cell or more points_per_cell",
            )
        )
    velocity = np.tile(np.array(case.velocity), (n, 1))
    velocity += np.cross(case.angular_velocity, position - case.shape.geometry().centre())
    if case.velocity_wave is not None:
        velocity += case.velocity_wave.at(position)
    arrays = {
        "id": np.arange(n),
        "position": position,
        "velocity": velocity,
        "mass": case.material.density * volume,
        "volume": volume,
    }
    state = case.material.initial_state()
    for name, value in zip(ARRAYS_OF[type(state)]._fields, state, strict=True):
        shape = (n, len(value)) if isinstance(value, tuple) else (n,)
        arrays[name] = np.broadcast_to(np.array(value, dtype=float), shape).copy()
    return arrays
