"""Openings in faces of the grid, and their strips of cells: the nodes around an opening, and the layers of nodes that move with
the flow through it or have a prescribed velocity, as in a prescribed outflow."""

from collections.abc import Mapping, Sequence
from math import ceil, log2
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.approximants import image_along
from pellucid.approximants.grid_functions import GridFunction, GridFunctions, axis_weights
from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.conditions.open_faces.columns import Columns, OpenFace, opening_of
from pellucid.conditions.open_faces.given_flow import (
    GivenFlow,
    Wall,
    across_tube,
    across_walls,
    is_tube,
    walled_axes,
    why_no_profile,
)
from pellucid.energy import OUTFLOW_WORK, Channel, StepWork, WorkLayout
from pellucid.errors import CaseError, Problem
from pellucid.geometry.shapes.contract import Geometry
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.grid.nodal_conditions import MASS_EPS
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.ranks.domain import domain
from pellucid.step.limit import NO_LIMIT, StepLimit
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.outflow import Outflow


LEAST_WEIGHT = 1e-12  # smallest weight of a node that points reach
SAMPLES = tuple(k / 24 for k in range(25))
"""Sample positions of a point in a cell, as fractions of the cell size. They include the ends of all shape functions,
also of GIMP with 1 to 4 or 6 points per cell."""


class NodesAcross(NamedTuple):
    """Nodes of one layer parallel to a face to which the columns of points behind the opening contribute, with their
    weights. A weight belongs to a pair of column and node."""

    place: np.ndarray  # (m, 3) positions of the nodes if the layer lies on the face [m]
    stored: np.ndarray  # (m,) storage indices of the nodes if the layer lies at the lower end of the grid
    column: np.ndarray  # (e,) index of the column of each pair
    node: np.ndarray  # (e,) index of the node of each pair, from 0 to m - 1
    weight: np.ndarray  # (e,) shape function of the node at the column, within the layer

    def at_columns(self, nodal: np.ndarray, n: int) -> np.ndarray:
        """Interpolate nodal values, shape (m,), to the n columns of points; return shape (n,)."""
        return np.bincount(self.column, self.weight * nodal[self.node], n)


def nodes_across(columns: Columns, grid: Grid, functions: GridFunctions, face: OpenFace) -> NodesAcross:
    """Return the nodes of one layer parallel to a face to which the columns of points behind the face contribute, with their
    weights; functions: shape functions of the grid along each axis."""
    lattice, across = grid.lattice, [axis for axis in range(3) if axis != face.axis]
    numbers: dict[tuple[int, ...], int] = {}
    column, node, weight = list[int](), list[int](), list[float]()
    for c, place in enumerate(columns.place.tolist()):
        one, other = (_reached(functions[axis], place[axis], grid, axis) for axis in across)
        for i, v in one:
            for j, w in other:
                column.append(c)
                node.append(numbers.setdefault((i, j), len(numbers)))
                weight.append(v * w)
    index = np.array(list(numbers), np.int64).reshape(-1, 2)
    place = np.tile(np.array(lattice.lower), (len(index), 1))
    place[:, across] += index * lattice.cell
    place[:, face.axis] = face.level
    stored = index @ np.array([lattice.strides[axis] for axis in across])
    return NodesAcross(place, stored, np.array(column, np.int64), np.array(node, np.int64), np.array(weight))


def layers(grid: Grid, function: GridFunction, face: OpenFace) -> np.ndarray:
    """Return the indices along the normal of the layers of nodes to which points in the cells at a face contribute, shape
    (l,); function: shape functions along the normal."""
    reached = {i for depth in SAMPLES for i in _layers_at(depth, grid, function, face)}
    return np.array(sorted(reached), np.int64)


def led_depth(grid: Grid, function: GridFunction, face: OpenFace) -> float:
    """Return the distance from a face up to which points contribute only to the node layers that `layers` returns [m]: 1 to
    2 cells, depending on the shape functions (`function`)."""
    led = set(layers(grid, function, face).tolist())
    deeper = [1.0 + depth for depth in SAMPLES if _layers_at(1.0 + depth, grid, function, face) <= led]
    return max(deeper) * grid.lattice.cell


def _layers_at(depth: float, grid: Grid, function: GridFunction, face: OpenFace) -> set[int]:
    n = grid.lattice.counts[face.axis]
    return {i for i, _ in _weights(function, n - depth if face.is_upper else depth, n)}


def _reached(function: GridFunction, place: float, grid: Grid, axis: int) -> list[tuple[int, float]]:
    """Return the indices of the nodes along an axis to which a point at the coordinate `place` [m] contributes, with their
    weights; function: shape functions along the axis."""
    n, lattice = grid.lattice.counts[axis], grid.lattice
    found = _weights(function, (place - lattice.lower[axis]) * lattice.inverse_cell, n)
    return [(i % n if grid.periodic[axis] else i, w) for i, w in found]


def _weights(function: GridFunction, u: float, n: int) -> list[tuple[int, float]]:
    first, weights, _ = axis_weights(function, u, n)
    return [(image_along(function, int(first) + k, n), float(w)) for k, w in enumerate(weights) if abs(w) > LEAST_WEIGHT]


class Passage(NamedTuple):
    """An opening in a face of the grid, and the body that flows through it."""

    face: OpenFace  # face of the grid that contains the opening
    columns: Columns  # columns of points behind the opening
    shape: Geometry  # shape whose intersection with the face is the opening
    case: GridCase  # data model of the grid
    member: AssembledBody  # body that flows through the opening
    direction: float  # direction of the flow along the normal axis, 1 or -1
    path: str  # path of the inflow or outflow in the case, for messages


class Strip:
    """Layer of cells at an opening through which fluid flows into or out of the grid: its nodes, and the velocity profile.

    flow: data model of the prescribed flow; passage: the opening and the body that flows through it.
    """

    def __init__(self, flow: GivenFlow, passage: Passage) -> None:
        actions, points = passage.member.actions, passage.member.body
        if actions is None or not isinstance(points, PointsOnGrid):
            raise ValueError(f"body {points.name} has no points on the grid")
        self._flow, self._actions = flow, actions
        self._face, self._columns, self._shape, self._case, _, self._direction, self._path = passage
        face, columns = self._face, self._columns
        grid = actions.field.grid
        self._across = nodes_across(columns, grid, points.functions, face)
        steps = layers(grid, points.functions[face.axis], face) * grid.lattice.strides[face.axis]
        led = (self._across.stored + steps[:, None]).ravel()
        order = np.argsort(led)
        self._nodes, self._number = led[order], np.tile(np.arange(len(self._across.stored)), len(steps))[order]
        self.depth = led_depth(grid, points.functions[face.axis], face)
        """Distance from the face up to which points reach only nodes of the strip [m]."""
        self.area = float(columns.area.sum())
        self.speed = 0.0  # mean over the opening in this step [m/s]

    def find_profile(self) -> None:
        """Compute the velocity profile across the opening, scaled to a mean of one. Called when all constraints are known.
        Raises CaseError if supports constrain all nodes."""
        nodes, free = self._actions.field.grid.nodes, np.ones(len(self._across.stored), bool)
        free[self._number[nodes.constrained[self._nodes, self._face.axis] > 0]] = False
        share = np.where(free, self._profile(), 0.0)
        at_columns = self._across.at_columns(share, self._columns.n)
        mean = float(self._columns.area @ at_columns) / self.area
        if not mean > 0.0:
            text = f"nothing can flow through the face {self._face.name}: supports constrain all its nodes"
            raise CaseError(Problem(text, self._path, remedy="remove the supports from the opening, or enlarge it"))
        self._share, self.at_columns = (share / mean)[self._number], at_columns / mean

    def _profile(self) -> np.ndarray:
        """Return the velocity profile at the nodes of the opening, with an arbitrary scale, shape (m,)."""
        place, axis = self._across.place, self._face.axis
        if self._flow.profile == "uniform":
            return np.ones(len(place))
        if is_tube(self._shape, axis):
            return across_tube(self._shape, axis, place)
        if reason := why_no_profile(self._shape, axis):
            raise CaseError(Problem(reason.text, f"{self._path}.profile", remedy=reason.remedy))
        return across_walls(self._walls(), place)

    def _walls(self) -> list[Wall | None]:
        """Return for each axis the positions [m] of the two walls of a slit or duct, i.e. the ends of the shape or of the
        grid, or None for an axis without walls. A face constrained along its normal only is a plane of symmetry; the
        profile continues beyond it."""
        lower, upper = self._shape.bounds()
        walls: list[Wall | None] = [None, None, None]
        for axis, walled in enumerate(walled_axes(self._case, self._face.name)):
            if walled:
                low = max(float(lower[axis]), float(self._case.lower[axis]))
                high = min(float(upper[axis]), float(self._case.extent_upper()[axis]))
                at_low, at_high = self._is_symmetric(axis, low), self._is_symmetric(axis, high)
                if not (at_low and at_high):
                    walls[axis] = (2.0 * low - high if at_low else low), (2.0 * high - low if at_high else high)
        if all(pair is None for pair in walls):
            text = f"the opening in the face {self._face.name} lies between planes of symmetry: it has no walls"
            raise CaseError(Problem(text, f"{self._path}.profile", remedy='use profile = "uniform"'))
        return walls

    def _is_symmetric(self, axis: int, level: float) -> bool:
        """Return True if the nodes of the opening at the coordinate `level` [m] along an axis lie on a plane of symmetry:
        they are constrained along `axis` and free along the flow."""
        at_level = np.abs(self._across.place[:, axis] - level) < 1e-6 * self._case.cell
        held = self._actions.field.grid.nodes.constrained[self._nodes[at_level[self._number]]]
        return len(held) > 0 and bool(np.all(held[:, axis] > 0) and np.all(held[:, self._face.axis] == 0))

    def step_limit(self) -> StepLimit:
        """Return the step limit for which the fluid in the strip, at the velocity of the last step, moves at most one cell."""
        fastest, cell = self.speed * float(self._share.max(initial=0.0)), self._case.cell
        if fastest <= 0.0:
            return NO_LIMIT
        what = f"the flow through the face {self._face.name} moves at {fastest:.3g} m/s through cells of {cell:.4g} m"
        return StepLimit(1.0 / (fastest / cell), "motion", what)

    def _free(self) -> np.ndarray:
        """Return a mask of the directions in which each node of the strip can move (it has mass and no support), shape (n,
        3)."""
        nodes = self._actions.field.grid.nodes
        return np.asarray((nodes.mass[self._nodes] >= MASS_EPS)[:, None] & (nodes.constrained[self._nodes] == 0))

    @property
    def normal(self) -> np.ndarray:
        """Direction of the flow, a unit vector, shape (3,)."""
        return self._direction * np.eye(3)[self._face.axis]


def work_of_strip(layout: WorkLayout, channel: Channel, work: float, impulse: np.ndarray, name: str | None) -> StepWork:
    """Return the work of the flow on a strip of cells and its impulse as a `StepWork` of the step.

    layout: columns of the array of works; channel: entry of the energy balance for the work; work: work of the flow on
    the strip [J]; impulse: shape (3,) [N s]; name: name of the flow, under which the impulse is recorded, or None.
    """
    done = layout.no_work()
    done.works[layout.column(channel)] = work
    if name is None:
        done.impulse[:] = impulse
        return done
    return done._replace(motions={name: impulse})


HEAVY = 1e6
"""Mass that is added to a node to give it the prescribed velocity, as a multiple of the mass of a cell filled with the
fluid: large enough that all material in the strip follows."""


class LedStrip(Strip):
    """Strip (layer of cells) at an opening with a flow of prescribed velocity."""

    def __init__(self, flow: GivenFlow, passage: Passage) -> None:
        """flow: data model of the prescribed flow; passage: the opening and the body that flows through it."""
        super().__init__(flow, passage)
        self._driven, body = self._actions.driven(), passage.member.body
        density = float(np.sum(body.stored_array("mass")) / np.sum(body.volumes()))
        self._mass = 2.0 ** ceil(log2(HEAVY * density * self._actions.field.grid.cell_volume))  # a power of 2: no rounding

    def mean_at(self, time: float) -> float:
        """Return the prescribed mean velocity through the opening at a time [s], in m/s."""
        mean = self._flow.velocity if self._flow.flow_rate is None else self._flow.flow_rate / self.area
        return self._flow.share(time) * (mean or 0.0)

    def begin(self, time: float, dt: float) -> None:
        """Set the velocity of the nodes over a step dt [s] from `time` [s]; it is zero if dt is 0."""
        self.speed = self.mean_at(time) if dt > 0.0 else 0.0
        self._driven.mass[self._nodes] += self._mass
        self._driven.momentum[self._nodes, self._face.axis] += self._mass * self._velocity()

    def _velocity(self) -> np.ndarray:
        return self._direction * self.speed * self._share

    def act(self, dt: float) -> tuple[float, np.ndarray]:
        """Return the work of the flow on the nodes over the step dt [s], in J, and its impulse [N s], shape (3,). Called
        after the momentum update."""
        given = np.where(self._free(), self._mass * self._driven.impulse[self._nodes], 0.0)
        impulse = domain.of_nodes(given, self._nodes)
        return float(impulse[:, self._face.axis] @ self._velocity()), impulse.sum(axis=0)


class LeadingOut(StepPart):
    """Active outflow with a prescribed flow. Only one body flows out: the first in the list of bodies that has points at
    the face, through the opening of the outflow in the face."""

    def __init__(self, outflow: "Outflow", bodies: Sequence[str], assembly: Assembly, path: str) -> None:
        self._layout, self._name = assembly.layout, outflow.name
        for name in bodies:
            member = assembly.bodies[name]
            if member.velocity_field is None:
                continue
            case = member.velocity_field.grid.case
            face = OpenFace.of(outflow.where[0], case)
            columns, shape = opening_of(outflow.through, face, member.model, case)
            if columns.n:
                self._strip = LedStrip(outflow, Passage(face, columns, shape, case, member, -face.inward, path))
                break
        else:
            text = f"no body that can leave reaches the face {outflow.where[0]}, and no opening is defined"
            remedy = "extend a body to the face, or define an opening with `through`, one cell deep into the grid"
            raise CaseError(Problem(text, f"{path}.where", remedy=remedy))
        self._work, self._impulse = 0.0, np.zeros(3)

    def try_out(self) -> None:
        self._strip.find_profile()
        self._strip.speed = self._strip.mean_at(0.0)

    def begin(self, time: float, dt: float) -> None:
        self._strip.begin(time, dt)

    def act_on_nodes(self, dt: float) -> None:
        """Compute the work of the prescribed flow on the nodes over the step dt [s], and its impulse."""
        self._work, self._impulse = self._strip.act(dt)

    def step_limit(self) -> StepLimit:
        return self._strip.step_limit()

    def work(self) -> StepWork:
        return work_of_strip(self._layout, OUTFLOW_WORK, self._work, self._impulse, self._name)

    def state_numbers(self) -> dict[str, Any]:
        return {"speed": self._strip.speed}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._strip.speed = float(numbers["speed"])
