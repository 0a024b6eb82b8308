"""Pressure at an open face, where a fluid ends.

A pressure p acts on the end of a fluid along the normal n of the face with the nodal forces f_I = -n p ∮ N_I n·dA, with the
shape function N_I of node I. By the divergence theorem this is

    f_I = -n p Σ_p V_p n·∇N_I(x_p),

summed over the points p of the fluid with the volumes V_p and positions x_p. This is the same sum as for the fluid's own
pressure, evaluated at the nodes around the layer of cells at the face. Therefore the end of the fluid need not be located,
nodes with almost no mass receive almost no force, and a fluid at the pressure p is in equilibrium, to rounding.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.conditions.open_faces.columns import OpenFace
from pellucid.energy import FIRST_LOAD, OUTFLOW_WORK, Passed
from pellucid.errors import CaseError, Problem, RunStopped
from pellucid.findings import listed
from pellucid.grid.nodal_fields import ROW, STEP, SUM, allocate, rows
from pellucid.grid.passes.gifts import by_slope, given, giving, scatter
from pellucid.jit import point_function
from pellucid.jit.bundle import Bundle
from pellucid.jit.vector import row
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.outflow import Outflow


class FluidPoints(NamedTuple):
    """Arrays of the points of a fluid that are read by the kernel which scatters the pressure on the end of the fluid to
    the nodes."""

    position: Any  # (n, 3) [m]
    volume: Any  # (n,) [m³]


class EndPressure(NamedTuple):
    """Rule by which points near a face distribute the pressure p on the end of the fluid to the nodes: each point with the
    volume V gives a node -V p times the derivative of its shape function along the axis of the face."""

    pressure: np.ndarray  # (1,) pressure on the end of the fluid in this step [Pa]
    level: float  # position of the face, in cells
    inward: float  # direction into the grid along the axis, 1 or -1
    axis: int  # normal axis of the face
    reach: float  # largest distance from the face of points that contribute, in cells


@point_function(given, EndPressure)
def _pressure_of_point(rule, lattice, points, p):
    x = points.position
    place = x[p, 0] if rule.axis == 0 else (x[p, 1] if rule.axis == 1 else x[p, 2])
    near = rule.inward * (place * lattice.inverse_cell - rule.level) < rule.reach
    c = -rule.pressure[0] * points.volume[p] if near else 0.0
    return (
        row(c if rule.axis == 0 else 0.0, 0.0, 0.0, 0.0),
        row(0.0, c if rule.axis == 1 else 0.0, 0.0, 0.0),
        row(0.0, 0.0, c if rule.axis == 2 else 0.0, 0.0),
    )


class EndNodes(NamedTuple):
    """Nodal field of a fluid on whose end, at a face of the grid, a pressure acts."""

    end_force: Annotated[np.ndarray, rows(SUM, STEP, "N", "force of the pressure on the end of the fluid")]


class EndOfFluid:
    """Points of a body at a face of the grid, where a pressure acts on the end of the body.

    member: the body; face: name of the face; column: column of the pressure's work in the array of works.
    """

    def __init__(self, member: AssembledBody, face: str, column: int) -> None:
        body = member.body
        if not isinstance(body, PointsOnGrid) or member.velocity_field is None:
            raise ValueError(f"body {body.name} has no points on the grid")
        self.face = OpenFace.of(face, body.grid.case)
        self.body, self._field, self._row = body, member.velocity_field, column - FIRST_LOAD
        self._pressure = np.zeros(1)
        self._rows = allocate(EndNodes, body.grid.n_nodes).end_force.reshape(-1, ROW)
        self._gives: Bundle | None = None
        self._deep = body.functions[self.face.axis].stencil
        index, place = body.grid.where()
        # nodes that points of the outermost layer of cells reach, and one more layer
        self._near = index[self.face.depth(place) < (self._deep + 0.5) * body.grid.lattice.cell]

    def push(self, pressure: float) -> None:
        """Apply a pressure [Pa] on the end of the body over the coming step."""
        self._pressure[0] = pressure
        if pressure == 0.0:
            return
        self._rows.fill(0.0)
        scatter(self._gift())
        self._field.load_row(self._row)[self._near, self.face.axis] += self._rows[self._near, self.face.axis]

    def _gift(self) -> Bundle:
        """Return the bundled arguments of the kernel that scatters the pressure to the nodes; built at first use, when all
        conditions are known."""
        if self._gives is None:
            arrays, face, cell = self.body.arrays, self.face, self.body.grid.lattice.cell
            rule = EndPressure(self._pressure, face.level / cell, face.inward, face.axis, 2.0 * self._deep)
            points = FluidPoints(arrays["position"], arrays["volume"])
            self._gives = giving(self.body.mapped.content, by_slope(rule, points, self._rows.reshape(-1)))
        return self._gives

    def nearest(self) -> tuple[float, float]:
        """Return the distance of the body's nearest point from the face, in cells, and the velocity of this point into
        the grid [m/s]."""
        there, axis = self.body.storage.n_present, self.face.axis
        if there == 0:
            return np.inf, 0.0
        depth = self.face.depth(self.body.arrays["position"][:there])
        p = int(np.argmin(depth))
        inward = self.face.inward * self.body.arrays["velocity"][p, axis]
        return float(depth[p]) * self.body.grid.lattice.inverse_cell, float(inward)


class OutletPressure(StepPart):
    """Active condition of an outflow against a pressure, which acts on the end of the fluid at each open face."""

    def __init__(self, outflow: "Outflow", bodies: Sequence[str], assembly: Assembly, path: str) -> None:
        self._outflow, self._path, self._filled = outflow, path, [True] * len(outflow.where)
        self._ends: list[tuple[OpenFace, list[EndOfFluid]]] = []
        for name in outflow.where:
            ends = [EndOfFluid(assembly.bodies[body], name, assembly.load_column(body, OUTFLOW_WORK.name)) for body in bodies]
            self._ends.append((ends[0].face, ends))

    def try_out(self) -> None:
        """Raise CaseError if no fluid is at the face, where the pressure would have no effect."""
        for face, ends in self._ends:
            if _nearest(ends)[0] > 1.0:
                text = (
                    f"no point of {_names(ends)} lies in the layer of cells at the face {face.name}, on which the pressure acts"
                )
                remedy = "extend a body to the face, or remove `pressure`"
                raise CaseError(Problem(text, f"{self._path}.pressure", remedy=remedy))

    def begin(self, time: float, dt: float) -> None:
        pressure = self._outflow.share(time) * (self._outflow.pressure or 0.0)
        for _, ends in self._ends:
            for end in ends:
                end.push(pressure)

    def enter(self, n_steps: int, time: float) -> Sequence[Passed]:
        """Raise RunStopped if backflow empties the layer of cells at a face. No points enter: returns an empty sequence."""
        for number, (face, ends) in enumerate(self._ends):
            depth, inward = _nearest(ends)
            if self._filled[number] and depth > 1.0 and inward > 0.0:
                where = f"backflow at the outflow through {face.name} (body {_names(ends)})"
                text = f"{where}: no fluid is left in the layer of cells at this face"
                remedy = (
                    f"keep the pressure at this face below that at the inlet at all times: reduce `{self._path}.pressure` or "
                    f"the largest share of its `amplitude`, or raise `rise`; {face.when_flow_reverses}"
                )
                message = f"step {n_steps}, time {time:.6g} s: {text}; {remedy}"
                raise RunStopped(message, step=n_steps, time=time)
            self._filled[number] = depth <= 1.0
        return ()

    def state_numbers(self) -> dict[str, Any]:
        return {"filled": list(self._filled)}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._filled = list(numbers["filled"])


def _nearest(ends: Sequence[EndOfFluid]) -> tuple[float, float]:
    """Return the distance from the face [cells] of the point nearest to it, of all bodies in `ends`, and the velocity of
    this point into the grid [m/s]."""
    return min((end.nearest() for end in ends), default=(0.0, 0.0))


def _names(ends: Sequence[EndOfFluid]) -> str:
    return listed([end.body.name for end in ends])
