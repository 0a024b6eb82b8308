"""Masses and viscosities of the fluids at the nodes of a velocity field, for the walls in it."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from pellucid.bodies.material_points.body import MaterialPoints
from pellucid.conditions.pressure_on_walls import FluidAtWalls
from pellucid.conditions.wall_surface import CutNodes
from pellucid.grid.actions import NodalActions
from pellucid.grid.clearing import Clearing
from pellucid.grid.nodal_fields import STEP, SUM, NodalField, allocate, with_memory
from pellucid.grid.transfer import scatter_numbers
from pellucid.materials.fluid import ViscousFluid
from pellucid.materials.rheology import UniformViscosity
from pellucid.parts.assembly import AssembledBody
from pellucid.ranks.domain import domain
from pellucid.step.part import StepPart


class Bodies(NamedTuple):
    """Bodies of a velocity field in which walls of this kind act."""

    fluids: Sequence[MaterialPoints]
    rigid: Sequence[AssembledBody]
    membranes: bool  # True if the field contains membranes


class FluidSums(NamedTuple):
    """Nodal sums over the points of fluids."""

    of_fluids: Annotated[
        np.ndarray, NodalField(3, SUM, STEP, "kg, m³, Pa s m³", "mass of fluids; their volume; their volume times viscosity")
    ]


class NodalFluid(StepPart):
    """Mass and viscosity of the fluids at the nodes of a velocity field, for its walls. With a single fluid of one viscosity,
    alone in the field, these are the masses of the nodes and the viscosity of the fluid; otherwise they are summed over the
    points in each step.

    bodies: bodies of the field; actions: actions on its nodes.

    Attributes
    ----------
    is_alone : bool
        True if there is one fluid of one viscosity, and no membrane.
    is_affine : bool
        True if the fluids map affine velocity fields to the nodes.
    """

    def __init__(self, bodies: Bodies, actions: NodalActions) -> None:
        self._fluids, self._nodes = bodies.fluids, actions.field.grid.nodes
        own = [fluid.arrays.get("viscosity") for fluid in self._fluids]
        uniform = {_viscosity_of(fluid) for fluid in self._fluids}
        self._uniform = uniform.pop() if len(uniform) == 1 and all(one is None for one in own) else None
        self.is_affine = all("affine" in fluid.arrays for fluid in self._fluids)
        self.is_alone = self._uniform is not None and not bodies.membranes
        grid = actions.field.grid
        self._sums = with_memory(allocate(FluidSums, 0), grid.n_nodes, *([] if self.is_alone else ["of_fluids"]))
        self._clear = Clearing(STEP, grid.rows, self._sums)
        self._outside = CutNodes(np.zeros(0, int), np.zeros(0))
        self.at_walls = FluidAtWalls(self._fluids, grid)

    def leave_out(self, walls: Sequence[CutNodes]) -> None:
        """Set the parts of the volumes of nodes that walls fill, where no fluid can be. walls: nodes near each wall."""
        node, at = np.unique(np.concatenate([wall.node for wall in walls]), return_inverse=True)
        filled = np.bincount(at, np.concatenate([wall.filled for wall in walls]), len(node))
        self._outside = CutNodes(node, np.minimum(filled, 1.0))
        self.at_walls.mark([wall.node for wall in walls])

    def open_shares(self, node: np.ndarray) -> np.ndarray:
        """Return the parts of the volumes of nodes with the numbers `node` that lie outside walls, shape (n,)."""
        cut, filled = self._outside
        if not len(cut):
            return np.ones(len(node))
        at = np.minimum(np.searchsorted(cut, node), len(cut) - 1)
        return np.where(cut[at] == node, 1.0 - filled[at], 1.0)

    def before_momentum(self, dt: float) -> None:
        """Sum mass, viscosity and pressure over the points, for their positions in this step."""
        self.at_walls.sum()
        if self.is_alone:
            return
        self._clear()
        for fluid in self._fluids:
            volume, own = fluid.arrays["volume"], fluid.arrays.get("viscosity")
            viscosity = np.full(len(volume), _viscosity_of(fluid)) if own is None else own
            values = np.stack([fluid.arrays["mass"], volume, viscosity * volume], axis=1)
            scatter_numbers(fluid.n_slabs, fluid.mapped, values, self._sums.of_fluids)

    def masses(self, node: np.ndarray) -> np.ndarray:
        """Return the masses of fluids at nodes with the numbers `node`, shape (n,) [kg]."""
        of_nodes = self._nodes.mass[node] if self.is_alone else self._sums.of_fluids[node, 0]
        return domain.of_nodes(of_nodes, node)

    def viscosities(self, node: np.ndarray) -> np.ndarray | float:
        """Return the mean viscosities of the fluids at nodes [Pa s], shape (n,); a number if all are the same."""
        if self._uniform is not None:
            return self._uniform
        _, volume, product = domain.of_nodes(self._sums.of_fluids[node], node).T
        return np.divide(product, volume, out=np.zeros(len(node)), where=volume > 0.0)


def sorted_bodies(members: Sequence[AssembledBody]) -> Bodies:
    """Return the bodies of a velocity field by their kind."""
    fluids = [member.body for member in members if isinstance(member.body, MaterialPoints) and not member.model.is_rigid]
    rigid = [member for member in members if member.model.is_rigid]
    return Bodies(fluids, rigid, any(member.model.is_surface for member in members))


def _viscosity_of(body: MaterialPoints) -> float:
    """Return the viscosity [Pa s] that all points of a body have; 0 for bodies without viscosity, and if it depends on the
    shear rate."""
    if body.solves_viscosity:
        return body.implicit_stress.mu
    viscosity = body.law.viscosity if isinstance(body.law, ViscousFluid) else None
    return viscosity.mu if isinstance(viscosity, UniformViscosity) else 0.0
