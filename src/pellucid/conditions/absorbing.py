"""Absorbing faces of the grid: viscous damping stresses at a face, through which waves leave.

Source: Lysmer & Kuhlemeyer 1969, J. Eng. Mech. Div. 95, 859.
"""

from collections.abc import Iterator, Sequence
from typing import ClassVar

import numpy as np
from pydantic import field_validator

from pellucid.approximants import with_walls
from pellucid.approximants.grid_functions import GridFunction, GridFunctions, axis_weights
from pellucid.conditions.support import Face
from pellucid.energy import ABSORBED_ENERGY, Channel
from pellucid.findings import Finding, Path
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_conditions import ExternalAction
from pellucid.grid.nodal_fields import fields_of
from pellucid.model import one_or_several, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart

SAMPLES = 4000  # number of samples for the integral of a shape function at a boundary


class Absorbing(Condition):
    """Absorbing faces of the grid, with the traction -ρ c_p v_n n - ρ c_s v_t, for the density ρ, the speeds c_p and c_s of
    pressure and shear waves, the velocity v_n along the outward normal n and the tangential velocity v_t: plane waves along
    the normal leave without reflection."""

    # energy that leaves through the faces, counted by the momentum equation of the nodes
    losses: ClassVar[Sequence[Channel]] = (ABSORBED_ENERGY,)

    where: tuple[Face, ...] = parameter("", "faces of the grid", min_length=1)
    body: str = parameter(
        "", "body whose waves are absorbed; the faces are tuned to the wave speeds of its material at the start"
    )

    _one_or_several = field_validator("where", mode="before")(one_or_several)

    @classmethod
    def activate(cls, conditions: Sequence["Absorbing"], assembly: Assembly) -> Sequence[StepPart]:
        return [AbsorbingFaces(absorbing, assembly) for absorbing in conditions]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about bodies that carry no waves to a face, and about faces that a support constrains or that are
        listed twice. path: location of the condition in the case; parts: all parts of the case."""
        yield from parts.no_grid((*path, "where"), "faces belong to a grid")
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        body = parts.named(BodyModel, self.body)
        if body is not None and body.wave_speeds() is None:
            why = "is a membrane: its waves travel along it and do not reach a face" if body.is_surface else "has no waves"
            text = f"body {self.body} {why}"
            yield Finding((*path, "body"), text, "name a body of kind material-points")
        before = [face for place, other in parts.placed(Absorbing) if place < path for face in other.where]
        for number, face in enumerate(self.where):
            yield from parts.seam((*path, "where", number), face)
            if face in before or face in self.where[:number]:
                text = f"the face {face} is listed twice and would absorb twice"
                yield Finding((*path, "where"), text, "list each face once, with the body that fills it")
            if any(condition.constrains_face(face) for condition in parts.of(Condition)):
                text = f"a support constrains the face {face}, and constrained nodes cannot absorb waves"
                yield Finding((*path, "where"), text, "remove the face from one of the two")


class AbsorbingFaces(StepPart):
    """Absorbing faces of a body: damping rates of the nodes of its velocity field, which are constant in a run. The momentum
    update of the nodes applies them and computes their work."""

    def __init__(self, absorbing: Absorbing, assembly: Assembly) -> None:
        member = assembly.bodies[absorbing.body]
        speeds = member.model.wave_speeds()
        if member.actions is None or member.body.on_grid is None or speeds is None:
            raise ValueError(f"body {absorbing.body} has no points on the grid, so a face cannot absorb its waves")
        faces = [(face, *speeds) for face in absorbing.where]
        functions = member.body.on_grid.functions
        member.actions.absorption()[:] += absorption_rates(member.actions.field.grid, functions, faces)


def absorption_rates(grid: Grid, functions: GridFunctions, faces: Sequence[tuple[Face, float, float]]) -> np.ndarray:
    """Return the damping rates of the grid nodes at absorbing faces along x, y and z [1/s], shape (nodes, 3): the momentum
    that a node loses per time, divided by its momentum.

    functions: shape functions of the grid along each axis; faces: name of each face, with the speeds of pressure and shear
    waves there [m/s]. Only nodes on a face have shape functions N that are nonzero on the face. With the part A of the
    face and the wave speed c, such a node has the mass m = ρ A ∫N dx, integrated along the normal. It loses the momentum ρ
    c A v per time, i.e. m v c/∫N dx.
    """
    rates = fields_of(ExternalAction)["absorption"].allocate(grid.n_nodes)
    index, position = grid.where()
    lattice = grid.lattice
    for face, pressure_speed, shear_speed in faces:
        axis = "xyz".index(face[0])
        if grid.thin[axis]:
            continue
        layer = 0 if face.endswith("lower") else lattice.counts[axis]
        cells = np.rint((position[:, axis] - lattice.lower[axis]) / lattice.cell)
        nodes = index[cells == layer]
        thickness = lattice.cell * _integral(with_walls(functions[axis]), lattice.counts[axis])
        for direction in range(3):
            rates[nodes, direction] += (pressure_speed if direction == axis else shear_speed) / thickness
    return rates


def _integral(function: GridFunction, n: int) -> float:
    """Return the integral of the shape function of a node on a face, along the normal of the face, in units of the cell size.
    function: shape functions along the normal axis; n: number of cells along this axis."""
    reach = min(function.stencil, n)
    total = 0.0
    for sample in range(SAMPLES):
        first, weights, _ = axis_weights(function, reach * (sample + 0.5) / SAMPLES, n)
        total += weights[0] if first == 0 else 0.0
    return total * reach / SAMPLES
