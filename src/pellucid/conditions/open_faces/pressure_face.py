"""Open face of the grid at which a pressure acts: fluid enters or leaves as the flow requires.

A pressure p acts on the end of a fluid along the normal n of the face with the nodal forces f_I = -n p ∮ N_I n·dA, with the
shape function N_I of node I. By the divergence theorem this is

    f_I = -n p Σ_p V_p n·∇N_I(x_p),

summed over the points p of the fluid with the volumes V_p and positions x_p. This is the same sum as for the fluid's own
pressure, evaluated at the nodes around the layer of cells at the face. Therefore the end of the fluid need not be located,
nodes with almost no mass receive almost no force, and a fluid at the pressure p is in equilibrium, to rounding.

The fluid crosses the face along its normal: the nodes of the face are constrained along the other axes. With continuity the
normal viscous stress then vanishes at the face, so that p is the pressure of the fluid there, and a developed flow crosses the
face unchanged (Heywood, Rannacher & Turek 1996, Int. J. Numer. Methods Fluids 22, 325). Without the constraint the flow would
spread at the face like a free jet.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NamedTuple, Protocol

import numpy as np

from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.conditions.open_faces.columns import ROUNDING, Columns, OpenFace, opening_of
from pellucid.conditions.open_faces.entering import EnteringColumns
from pellucid.conditions.open_faces.strip import nodes_across
from pellucid.energy import FIRST_LOAD, Channel, Passed
from pellucid.errors import CaseError, Problem
from pellucid.findings import listed
from pellucid.geometry.region import Shape
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_fields import ROW, STEP, SUM, allocate, rows
from pellucid.grid.passes.gifts import by_slope, given, giving, scatter
from pellucid.jit import point_function
from pellucid.jit.bundle import Bundle
from pellucid.jit.vector import row
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.parts.capabilities import LosesPoints
from pellucid.ranks.domain import domain
from pellucid.step.part import StepPart


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

    def nearest(self) -> float:
        """Return the distance of the body's nearest point from the face, in cells; infinite without points."""
        depth = self.face.depth(self.body.storage.present("position"))
        return float(np.min(depth, initial=np.inf)) * self.body.grid.lattice.inverse_cell


class FaceNodes:
    """Nodes that determine the flow through a face at the columns of its opening."""

    def __init__(self, member: AssembledBody, opening: Columns, face: OpenFace) -> None:
        body = member.body
        if not isinstance(body, PointsOnGrid):
            raise ValueError(f"body {body.name} has no points on the grid")
        self._face, self._n, nodes = face, opening.n, body.grid.nodes
        self._across = nodes_across(opening, body.grid, body.functions, face)
        layer = body.grid.lattice.counts[face.axis] if face.is_upper else 0
        self.stored = self._across.stored + layer * body.grid.lattice.strides[face.axis]
        self._order = np.argsort(self.stored)
        stress = member.model.implicit_stress
        curving = stress is not None and stress.stiffness > 0.0
        self._velocity = nodes.strain_velocity if curving else nodes.velocity

    def velocity_at_columns(self) -> np.ndarray:
        """Return the velocity of the flow into the grid at each column [m/s], shape (c,)."""
        nodes, nodal = self.stored[self._order], np.empty(len(self.stored))
        nodal[self._order] = domain.of_nodes(self._velocity[nodes, self._face.axis], nodes)
        return self._face.inward * self._across.at_columns(nodal, self._n)


MARGIN = 0.05
"""Distance from the face at which a point enters, as a fraction of the point spacing: oscillations over this distance move no
points in and out."""


class PressureFlow(Protocol):
    """Interface of an inflow or outflow under a pressure."""

    @property
    def pressure(self) -> float | None:
        """Pressure at the face [Pa], before its change in time."""

    @property
    def through(self) -> Shape | None:
        """Shape whose intersection with the face is the opening; None for that of the body."""

    def share(self, time: float) -> float:
        """Return the fraction of the pressure at a time [s]."""


class PressureFace(StepPart):
    """Face of the grid at which a pressure acts on fluids in a run.

    Points of the bodies that cross the face leave. Where the flow is into the grid, points of one fluid enter: of the first of
    the bodies that reaches the face at the start. The room of a column (`EnteringColumns`) changes by the nodal velocities at
    the face, and by the points that leave.
    """

    def __init__(
        self, flow: PressureFlow, face: str, bodies: Sequence[str], channel: Channel, assembly: Assembly, path: str
    ) -> None:
        """flow: the inflow or outflow, with its pressure and opening; face: name of the face; bodies: names of the bodies that
        may cross it; channel: entry of the energy balance for the work of the pressure; path: path of the flow in the case, for
        messages."""
        self._flow, self._path, self._members = flow, path, [assembly.bodies[name] for name in bodies]
        columns = [assembly.load_column(name, channel.name) for name in bodies]
        self._ends = [EndOfFluid(member, face, column) for member, column in zip(self._members, columns, strict=True)]
        self._face = self._ends[0].face
        self._columns: EnteringColumns | None = None
        for member in self._members:
            if member.model.is_fluid and member.velocity_field is not None:
                grid = member.velocity_field.grid
                opening, _ = opening_of(flow.through, self._face, member.model, grid.case)
                if opening.n:
                    self._columns = EnteringColumns(member, self._face, opening, MARGIN * opening.spacing)
                    self._nodes = FaceNodes(member, opening, self._face)
                    break

    def try_out(self) -> None:
        """Constrain the nodes of the face along the face. Raises CaseError if no fluid is at the face, where the pressure would
        have no effect."""
        if min(end.nearest() for end in self._ends) > 1.0:
            text = (
                f"no point of {listed([end.body.name for end in self._ends])} lies in the layer of cells at the face "
                f"{self._face.name}, on which the pressure acts"
            )
            remedy = "extend a body to the face, or remove `pressure`"
            raise CaseError(Problem(text, f"{self._path}.pressure", remedy=remedy))
        self._at_face = [
            (member.actions, self._nodes_at_face(member.actions.field.grid))
            for member in self._members
            if member.model.is_fluid and member.actions is not None
        ]
        self._hold_sideways()
        if self._columns is not None:
            self._columns.find_state()

    def _nodes_at_face(self, grid: Grid) -> np.ndarray:
        """Return the indices of the nodes of the face, or of the opening `through` in it."""
        index, place = grid.where()
        at_face = np.abs(self._face.depth(place)) < ROUNDING * grid.lattice.cell
        if self._flow.through is not None:
            at_face &= np.isin(index, self._nodes.stored)
        return np.asarray(index[at_face])

    def _hold_sideways(self) -> None:
        """Constrain the nodes of the face along all axes except the normal, unless supports do."""
        for actions, nodes in self._at_face:
            constrained = actions.field.grid.nodes.constrained
            held = constrained[nodes]
            held[(held == 0) & (np.arange(3) != self._face.axis)] = len(actions.supports.velocity)  # the row of thin axes
            constrained[nodes] = held

    def begin(self, time: float, dt: float) -> None:
        self._hold_sideways()  # supports may have ended
        self._pressure = self._flow.share(time + 0.5 * dt) * (self._flow.pressure or 0.0)
        for end in self._ends:
            end.push(self._pressure)

    def end(self, dt: float) -> None:
        if self._columns is not None:
            self._velocity = self._nodes.velocity_at_columns()
            self._columns.room += dt * self._velocity

    def enter(self, n_steps: int, time: float) -> Sequence[Passed]:
        """Let points enter where the flow is into the grid and columns have room, and note the room of the points that left."""
        columns = self._columns
        if columns is None:
            return ()
        for member in self._members:
            position, volume = member.offers(LosesPoints).just_left()
            beyond = self._face.depth(position) < 0.0
            columns.give_way(position[beyond], volume[beyond])
        columns.limit_room(self._velocity <= 0.0)
        return columns.enter(self._velocity, self._pressure, n_steps, time)

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {} if self._columns is None else {"room": self._columns.room}

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        if self._columns is not None:
            self._columns.room[:] = arrays["room"]
