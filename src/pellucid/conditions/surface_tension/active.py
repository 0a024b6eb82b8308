"""Active condition of surface tension: nodal forces, surface energy and step limit of a fluid in each step."""

from collections.abc import Mapping
from math import cos, radians
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.conditions.surface_tension.colour import (
    FREE,
    Faces,
    SurfaceEnergy,
    gather_potential,
    scatter_forces,
    scatter_volumes,
)
from pellucid.conditions.surface_tension.model import NEUTRAL
from pellucid.conditions.surface_tension.planes import WettedPlane
from pellucid.energy import FIRST_LOAD, INTERNAL, SURFACE_ENERGY, StepWork
from pellucid.grid.lattice import Grid
from pellucid.parts.annotations import Assembly
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum
from pellucid.step.part import AddedStiffness, StepPart

if TYPE_CHECKING:
    from pellucid.conditions.surface_tension.model import SurfaceTension


class TenseSurface(StepPart):
    """Surface tension of a fluid in a run.

    Forces are the exact derivative of the energy with respect to positions and volumes of the points, f = -V (N ∇φ + φ ∇N)
    with the volume V of a point, the shape function N of a node and the potential φ = ∂E/∂V of the surface energy E, so
    that energy is conserved except for errors of the time step. Since the energy is summed over cells, it changes slightly
    when the fluid moves relative to the grid. The resulting total force on the fluid is not physical. A uniform
    acceleration of all points removes it, except along the normals of faces of the grid that the fluid has reached, since
    these faces can support the fluid.

    The energy is computed for the state at the start of a step. The change recorded for a step is therefore minus the work
    of the forces in the step; the difference from the actual change is recorded in the next step.
    """

    def __init__(self, model: "SurfaceTension", assembly: Assembly) -> None:
        body = assembly.bodies[model.body].body
        if not isinstance(body, PointsOnGrid):
            raise ValueError(f"body {model.body} has no points on the grid; the check of the case should have reported this")
        self._body, self._model, self._layout = body, model, assembly.layout
        column = assembly.load_column(model.body, model.load_channel())
        self._row = column - FIRST_LOAD
        self._rate = model.rate(assembly.bodies[model.body].model.material.density, body.grid.lattice.cell)
        self._values = np.zeros((body.n_points, 4))
        self._sums = np.zeros((body.n_slabs, 3))
        self._mass = body.mass
        self._energy: float | None = None
        self._changed = self._work = 0.0

    def try_out(self) -> None:
        body, model = self._body, self._model
        faces = _faces(body.grid, model.angles, model.contact_angle)
        planes = [WettedPlane(wall.plane(), _cosine(angle)) for wall, angle in model.walls]
        self._surface = SurfaceEnergy(body.grid, body.functions, model.tension, faces, planes)
        self._find()

    def at_stake(self) -> float:
        return abs(self._found)

    def _find(self) -> None:
        """Scatter the volumes of the points to the nodes, and compute the surface energy [J] for these nodal volumes and
        its derivative with respect to them, the potential [J/m³]."""
        body, surface = self._body, self._surface
        surface.volume.fill(0.0)
        scatter_volumes(body.n_slabs, body.mapped, surface.volume)
        domain.spread(surface.volume)  # smoothing reaches further than points
        self._found = surface.find()

    def begin(self, time: float, dt: float) -> None:
        """Apply the nodal forces of the surface energy, computed for the present volumes of the points, over the step dt
        [s] that begins at `time` [s]."""
        body, surface = self._body, self._surface
        self._find()
        energy = self._found
        self._changed = 0.0 if self._energy is None else energy - self._energy + self._work
        self._energy = energy
        gather_potential(body.n_slabs, body.mapped, surface.potential, self._values, self._sums)
        slope = ordered_sum(domain.complete(self._sums))
        acceleration = np.where(surface.at_wall, 0.0, slope / self._mass)
        self._force = np.zeros_like(body.velocity_field.load_row(self._row))
        scatter_forces(body.n_slabs, body.mapped, self._values, acceleration, self._force)
        body.velocity_field.load_row(self._row)[...] += self._force

    def end(self, dt: float) -> None:
        power = domain.of_nodes(self._force * self._body.grid.nodes.mean_velocity)
        self._work = dt * float(np.sum(power))
        if dt > 0.0:
            self._body.totals.half_power += 0.5 * self._work / dt

    def added_stiffness(self) -> AddedStiffness:
        return AddedStiffness([self._body.totals], self._rate, *self._model.swings_as)

    def work(self) -> StepWork:
        done, more = self._layout.no_work(), self._changed - self._work
        done.works[self._layout.column(SURFACE_ENERGY)] = more
        done.works[INTERNAL] += more
        return done

    def columns(self) -> Mapping[str, float]:
        return {f"{self._model.body}_surface_energy": self._found}

    def state_numbers(self) -> dict[str, Any]:
        return {"energy": self._energy, "found": self._found, "work": self._work}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._energy, self._found, self._work = numbers["energy"], numbers["found"], numbers["work"]


def _faces(grid: Grid, angles: Mapping[str, float], default: float) -> tuple[Faces, Faces, Faces]:
    """Return the cosines of the contact angles at the faces of the grid, for each axis; the constant FREE for faces that no
    support constrains.

    angles: contact angles by name of the face [°]; default: contact angle of faces whose nodes are constrained in regions
    [°].
    """
    index, position = grid.where()
    cells = np.rint((position - np.array(grid.lattice.lower)) * grid.lattice.inverse_cell)
    found = []
    for axis, count in enumerate(grid.lattice.counts):
        cosines = []
        for end, layer in (("lower", 0), ("upper", count)):
            is_held = bool(np.all(grid.nodes.constrained[index[cells[:, axis] == layer], axis] > 0))
            angle = angles.get(f"{'xyz'[axis]}-{end}", default)
            cosines.append(_cosine(angle) if is_held else FREE)
        found.append(Faces(*cosines))
    return found[0], found[1], found[2]


def _cosine(angle: float) -> float:
    return 0.0 if angle == NEUTRAL else cos(radians(angle))
