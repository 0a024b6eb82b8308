"""Fluids whose viscosity or pressure is solved for on the nodes, as `pellucid.grid.implicit_viscosity` sees them."""

from typing import Protocol

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.grid.passes.gifts import scatter
from pellucid.grid.point_storage import PointStorage
from pellucid.grid.points import FullCells, NoCells
from pellucid.grid.viscous_nodes import diagonal_by_viscosity
from pellucid.jit.bundle import Bundle
from pellucid.materials.contract import ImplicitStress, PointMaterial
from pellucid.materials.rheology import SecondViscosity

VISCOUS_STRESS = "viscous_stress"
"""Name of the point array that holds the viscous stress."""


class Viscous(Protocol):
    """Interface of a fluid body whose viscosity or pressure is solved implicitly by `ImplicitViscosity`: parameters, stresses
    and sums over its points."""

    n_slabs: int  # number of slabs into which the points are divided
    mapped: Bundle  # the points, bundle of `MappedPoints`
    storage: PointStorage
    material: PointMaterial
    arrays: dict[str, np.ndarray]
    """Arrays of the points by name: also `VISCOUS_STRESS`, the viscous stress in the last step [Pa], shape (points, 6), which
    `stress` contains only within a step, and "viscosity", the shear viscosity [Pa s], shape (points,), if points
    have different ones."""

    @property
    def solves_viscosity(self) -> bool:
        """True if the viscous stress is solved for."""

    @property
    def implicit_stress(self) -> ImplicitStress:
        """Parameters of the stress that is solved for."""

    @property
    def functions(self) -> GridFunctions: ...

    @property
    def full_cells(self) -> NoCells | FullCells: ...

    @property
    def nodal_forces(self) -> np.ndarray: ...
    def stored_array(self, name: str) -> np.ndarray: ...
    def curve_paths(self) -> None:
        """From now on, move the points with the velocity u + Δt/2 L u, see `pellucid.grid.straining`."""


class PointViscosity:
    """Viscosities of a fluid whose points have their own, in the diagonal of the viscous operator.

    body: the fluid; viscosity: shear viscosity μ of each point [Pa s], shape (points,); second: its second viscosity; into:
    nodal rows to which the diagonal is added, shape (4 nodes,).
    """

    def __init__(self, body: Viscous, viscosity: np.ndarray, second: SecondViscosity, into: np.ndarray) -> None:
        self.second = second
        self._viscosity, self._volume = viscosity, body.mapped.content.points.volume
        self._product = np.zeros_like(viscosity)
        factors = np.array([1.0, 2.0 + second.ratio])
        self._diagonal = diagonal_by_viscosity(body.mapped.content, self._product, factors, into)

    def add_diagonal(self) -> None:
        """Add the diagonal of the viscosities, without the constant part of λ."""
        np.multiply(self._viscosity, self._volume, out=self._product)
        scatter(self._diagonal)

    def bulk(self) -> np.ndarray:
        """Return 3λ + 2μ of each point [Pa s], shape (points,)."""
        return (3.0 * self.second.ratio + 2.0) * self._viscosity + 3.0 * self.second.constant
