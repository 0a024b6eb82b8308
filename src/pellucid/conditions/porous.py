"""Porous media: a fluid that flows through a box is slowed by the Darcy drag of the material in it.

The drag per unit volume is -(μ/k) v, with the viscosity μ, the permeability k and the superficial velocity v (Darcy 1856, Les
fontaines publiques de la ville de Dijon; Whitaker 1986, Transp. Porous Media 1, 3). Per unit mass it is -β v, β = μ/(k ρ), with
the initial density ρ of the fluid. If a node would have the acceleration a without drag, v' = a - β v is solved exactly over a
step Δt:

    v_new = v exp(-β Δt) + a (1 - exp(-β Δt))/β

The steady velocity a/β is therefore exact for any step. A node whose cell the box covers partly gets this share of β.
"""

from collections.abc import Iterator, Sequence
from typing import ClassVar

import numpy as np

from pellucid.energy import Channel
from pellucid.findings import Finding, Path
from pellucid.grid.lattice import Grid
from pellucid.model import Vector, check, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel, is_alone
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart

POROUS_HEAT = Channel("porous_heat", -1.0)


class Porous(Condition):
    """A box of porous material at rest, with the drag -(μ/k) v per unit volume on a fluid in it."""

    losses: ClassVar[Sequence[Channel]] = (POROUS_HEAT,)

    body: str = parameter("", "name of the fluid")
    lower: Vector = parameter("m", "lower corner of the box")
    upper: Vector = parameter("m", "upper corner of the box")
    permeability: float = parameter("m^2", "permeability k of the porous material", gt=0)
    viscosity: float | None = parameter("Pa*s", "viscosity μ of the fluid; default: that of its material", None, gt=0)

    @check
    def _box_is_not_empty(self) -> None:
        if any(low > high for low, high in zip(self.lower, self.upper, strict=True)):
            raise ValueError("`lower` exceeds `upper`; give the lower corner of the box first")

    @classmethod
    def activate(cls, conditions: Sequence["Porous"], assembly: Assembly) -> Sequence[StepPart]:
        return [PorousDrag(porous, assembly) for porous in conditions]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that is no fluid on the grid, shares its velocity field or has no viscosity."""
        yield from parts.no_grid((*path, "body"), "porous boxes act on nodes of the grid")
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        body = parts.named(BodyModel, self.body)
        if body is None:
            return
        if not (body.is_fluid and body.separate_points):
            yield Finding((*path, "body"), f"body {self.body} is not a fluid of material points", "name a fluid")
        elif not is_alone(body, parts):
            text = f"other bodies share the velocity field of body {self.body}, on whose nodes the drag acts"
            yield Finding((*path, "body"), text, "set a separate `field` for the fluid, or make one body of the fluids")
        elif self._viscosity(body) <= 0.0:
            text = f"is missing, and the material of body {self.body} has none"
            yield Finding((*path, "viscosity"), text, "set `viscosity`")

    def drag_rate(self, body: BodyModel) -> float:
        """Return the decay rate β = μ/(k ρ) of the velocity of the fluid [1/s]."""
        return self._viscosity(body) / (self.permeability * body.material.density)

    def _viscosity(self, body: BodyModel) -> float:
        return self.viscosity if self.viscosity is not None else float(getattr(body.material, "viscosity", 0.0))

    def share_of_cells(self, grid: Grid, position: np.ndarray) -> np.ndarray:
        """Return the share of the cell around each node that lies in the box, shape (n,), along axes that the grid resolves;
        position: positions of the nodes [m], shape (n, 3). Cells end at faces of the grid that are not periodic."""
        lattice, share = grid.lattice, np.ones(len(position))
        for axis in range(3):
            if grid.thin[axis]:
                continue
            low, high = position[:, axis] - 0.5 * lattice.cell, position[:, axis] + 0.5 * lattice.cell
            if not grid.periodic[axis]:
                end = lattice.lower[axis] + lattice.counts[axis] * lattice.cell
                low, high = np.maximum(low, lattice.lower[axis]), np.minimum(high, end)
            shifts = (-grid.periods[axis], 0.0, grid.periods[axis]) if grid.periodic[axis] else (0.0,)
            inside = [np.minimum(high, self.upper[axis] + s) - np.maximum(low, self.lower[axis] + s) for s in shifts]
            share *= sum(np.clip(each, 0.0, None) for each in inside) / (high - low)
        return share


class PorousDrag(StepPart):
    """Applies the drag of a porous box to the nodes of the velocity field of a fluid."""

    def __init__(self, porous: Porous, assembly: Assembly) -> None:
        member = assembly.bodies[porous.body]
        if member.velocity_field is None:
            raise ValueError(f"body {porous.body} is not on the grid")
        self._field, self._column = member.velocity_field, assembly.layout.column(POROUS_HEAT)
        self.pushed_fields = [self._field]
        index, position = self._field.grid.where()
        rate = porous.drag_rate(member.model) * porous.share_of_cells(self._field.grid, position)
        order = np.argsort(index)
        inside = rate[order] > 0.0
        self._node, self._rate = index[order][inside], rate[order][inside, None]

    def act_on_nodes(self, dt: float) -> None:
        nodes, at = self._field.grid.nodes, self._node
        new, increment = nodes.velocity[at], nodes.velocity_increment[at]
        kept = np.exp(-self._rate * dt)
        wanted = (new - increment) * kept + increment * (1.0 - kept) / (self._rate * dt)
        self._field.add_impulses(nodes.mass[at, None] * (wanted - new), self._column, -1.0, at)
