"""Constraint of velocities at nodes by supports, for nodes of the grid and for nodes of bodies with their own nodes."""

from collections.abc import Collection, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from pellucid.conditions.open_walls import OpenWalls
from pellucid.energy import StepWork
from pellucid.errors import CaseError, Problem
from pellucid.findings import refuse
from pellucid.geometry.region import (
    CONSTRAINS_NOTHING,
    EVERY_AXIS,
    NOWHERE,
    Selectable,
    chosen_nodes,
    faults,
    needs_mesh,
)
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.grid.nodal_conditions import Supports, YieldingWalls, no_walls
from pellucid.grid.nodal_fields import fields_of
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.parts.body import in_metres
from pellucid.parts.capabilities import HeldInRegions, NodalSupport, ReleasesSupports, TakesSupports
from pellucid.parts.families import NodalBody
from pellucid.parts.support_precedence import find_owners
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.support import Support

REACH = 1e-6  # tolerance for nodes outside a box, in cells


class ActiveSupports(StepPart):
    """The supports of a case in a run: constrains nodes of all grids and of bodies with their own nodes, releases them when
    supports end, and reports the impulses of named supports. The momentum update of the nodes applies the constraints.

    supports: supports of the case; a support that lists several faces counts as one support for each face. Raises CaseError
    for a support without nodes.

    Attributes
    ----------
    supports : list of Support
        The supports, split so that each acts on at most one face: one for each row of the reactions in `StepWork`.
    """

    def __init__(self, supports: "Sequence[Support]", assembly: Assembly) -> None:
        numbers = [number for number, support in enumerate(supports) for _ in support.on_each_face()]
        self.supports = [one for support in supports for one in support.on_each_face()]
        self._actions = assembly.actions
        members = assembly.bodies.values()
        self._releasing = [member.body for member in members if isinstance(member.body, ReleasesSupports)]
        self._gone: set[int] = set()
        self._reactions = np.zeros((0, 3))
        own: dict[NodalBody, list[NodalSupport]] = {}
        for member in members:
            if isinstance(member.body, NodalBody):
                own[member.body] = [
                    nodal_support(member, one, number) for one, number in zip(self.supports, numbers, strict=True)
                ]
        found = {row for of_body in own.values() for row, support in enumerate(of_body) if support.nodes.any()}
        for actions in self._actions:
            actions.supports = constrain_nodes(actions.field.grid, self.supports, found, numbers=numbers)
        for row, support in enumerate(self.supports):
            if row not in found and support.body is None and not self._actions:
                raise CaseError(Problem(CONSTRAINS_NOTHING, f"support.{numbers[row]}.where", remedy=NOWHERE))
        for body, of_body in own.items():
            if isinstance(body, TakesSupports):
                body.add_supports(of_body)
        for member in members:
            if isinstance(member.body, HeldInRegions) and member.velocity_field is not None:
                member.body.hold_in_regions(_find_held_points(member, self.supports, member.velocity_field.grid.case))

    def begin(self, time: float, dt: float) -> None:
        """Release the nodes of supports whose end time is before `time` [s]. At the end time itself, the nodes stay
        constrained while dt, the increment of the load time, is 0, e.g. during settling."""
        untils = [(number, support.until) for number, support in enumerate(self.supports)]
        gone = {n for n, until in untils if until is not None and (time > until or (time == until and dt > 0.0))}
        if gone != self._gone:
            self._gone = gone
            for actions in self._actions:
                self._constrain_again(actions.field.grid, actions.supports.walls.held)
            for body in self._releasing:
                body.let_go(gone)

    def balance(self, done: StepWork) -> None:
        """Read the impulses of the supports, which nodes and bodies have added to the works of the step."""
        self._reactions = done.reactions

    def impulses(self) -> Mapping[str, np.ndarray]:
        total: dict[str, np.ndarray] = {}
        for support, impulse in zip(self.supports, self._reactions, strict=False):  # the last row is of thin axes
            if support.name is not None:
                total[support.name] = total.get(support.name, np.zeros(3)) + impulse
        return total

    def _constrain_again(self, grid: Grid, held: np.ndarray) -> None:
        """Mark the constrained directions of the nodes of a grid by the supports that have not ended; nodes that an opening
        wall has released stay free. held: number of the wall that holds each node along each axis, shape (nodes, 3),
        updated here."""
        constrained = grid.nodes.constrained
        let_go = (held > 0) & (constrained[: len(held)] == 0)
        held[:] = constrain_nodes(grid, self.supports, range(len(self.supports)), self._gone).walls.held
        constrained[: len(held)][let_go & (held > 0)] = 0


def _find_held_points(member: AssembledBody, supports: "Sequence[Support]", grid: GridCase) -> np.ndarray:
    """Return for each point of a body the number, counted from 1, of the support at rest whose region contains the point and
    which constrains all directions; 0 if there is none. Shape (n,), in the order of the point numbers."""
    of, rows = member.selectable(), np.zeros(member.body.n_points, np.int64)
    stored = rows.copy()
    for row, support in enumerate(supports):
        region = support.region()
        if region is None or needs_mesh(region) or support.body is not None or not support.holds_all() or any(support.velocity):
            continue
        stored[nodes_of(support, grid, of)] = row + 1
    rows[member.body.stored_array("id")] = stored
    return rows


def open_walls(supports: "Sequence[Support]", assembly: Assembly) -> list[OpenWalls]:
    """Return, for each velocity field that contains points, the condition of its opening walls (walls that hold a body only
    against motion into the wall). supports: all supports, split so that each acts on at most one face."""
    faces = [face for support in supports if support.lets_go() and (face := support.face()) is not None]
    found = []
    for actions in assembly.actions if faces else []:
        members = (member.body for member in assembly.bodies.values() if member.actions is actions)
        bodies = [body.on_grid for body in members if body.on_grid is not None]
        if bodies:
            found.append(OpenWalls(actions.field.grid, actions.supports.walls, dict.fromkeys(faces), bodies))
    return found


def constrain_nodes(
    grid: Grid,
    supports: "Sequence[Support]",
    elsewhere: Collection[int] = (),
    gone: Collection[int] = (),
    numbers: Sequence[int] = (),
) -> Supports:
    """Mark the constrained directions of the grid nodes; return the velocities and wall data of the supports, one row for
    each support, plus a last row for axes along which the grid is one cell thick.

    For the precedence of supports see `find_owners`. elsewhere: indices of supports (each on at most one face) that
    constrain nodes of bodies and may contain no grid node; gone: indices of supports that have ended; numbers: indices of
    the supports in the case, for messages. Raises CaseError for a support without nodes.
    """
    index, position = grid.where()
    of = Selectable(position, periods=grid.periods)
    constrained, on_nodes = grid.nodes.constrained, []
    for row, support in enumerate(supports):
        inside = nodes_of(support, grid.case, of) if support.body is None else np.zeros(len(position), bool)
        if not inside.any() and support.body is None and row not in elsewhere:
            text = "the support constrains no node of the grid: the region lies outside the grid or between its nodes"
            lower, upper = (in_metres(corner) for corner in (position.min(axis=0), position.max(axis=0)))
            wider = f"move the region into the grid, from {lower} to {upper}, or make it at least one cell"
            wider += f" ({grid.lattice.cell:g} m) wide"
            raise CaseError(Problem(text, f"support.{numbers[row] if numbers else row}.where", remedy=wider))
        on_nodes.append(on_those(support, inside))
    constrained.fill(0)
    constrained[index] = find_owners(on_nodes, len(position), gone)
    for axis in np.flatnonzero(grid.thin):
        constrained[:, axis] = len(supports) + 1
    velocity = np.array([*(support.velocity for support in supports), (0.0, 0.0, 0.0)])
    faces = [support.face() is not None for support in supports]
    return Supports(velocity, np.array([*faces, True], dtype=np.int64), _yielding(supports, constrained))


def _yielding(supports: "Sequence[Support]", constrained: np.ndarray) -> YieldingWalls:
    """Return the friction and opening data of the supports, and the nodes that walls with friction or opening walls (walls
    that bodies can leave) constrain, as `YieldingWalls`; constrained: 1 + index of the support that constrains each node
    along each axis, else 0, shape (nodes, 3)."""
    ends = [support.face() for support in supports]
    inward = [0.0 if end is None else 1.0 - 2.0 * end[1] for end in ends]
    friction, opens = [support.wall_friction() for support in supports], [support.lets_go() for support in supports]
    yields = np.array([False, *(np.array(friction) > 0.0) | np.array(opens, bool), False])
    if not yields.any():
        return no_walls()
    held = np.where(yields[constrained], constrained, 0).astype(constrained.dtype)
    numbers = np.array([*friction, 0.0]), np.array([*opens, False], np.uint8), np.array([*inward, 0.0])
    walls, n = fields_of(YieldingWalls), len(held)
    gap = walls["gap"].allocate(n if any(opens) else 0)
    gap.fill(0.0)  # before it is measured, velocities alone tell whether walls let nodes go
    return YieldingWalls(*numbers, held, walls["stuck"].allocate(n), gap, walls["impulse"].allocate(n))


def nodal_support(member: AssembledBody, support: "Support", number: int) -> NodalSupport:
    """Return the constraint that a support imposes on the nodes of a body with its own nodes; number: index of the support
    in the case, for messages. A face of the grid that is constrained along its normal acts as a wall.

    The support holds the nodes that are on the face at the start, unless it is an opening wall. Raises CaseError if the
    support names this body and a region without nodes of the body.
    """
    region, of = support.region(), member.selectable()
    if region is not None and support.body == member.body.name:
        refuse(faults(region, of, ("support", number, "where"), member.body.name, member.active_axes))
    label = support.label(number)
    if support.body not in (None, member.body.name):
        return NodalSupport(np.zeros(len(of.position), bool), support.axes(), support.velocity, None, label)
    grid = member.velocity_field.grid.case if member.velocity_field else None
    on_nodes = on_those(support, nodes_of(support, grid, of))
    if on_nodes.wall is not None and support.lets_go():
        on_nodes.nodes[:] = False
    return on_nodes._replace(label=label, friction=support.wall_friction())


def on_those(support: "Support", nodes: np.ndarray) -> NodalSupport:
    """Convert a support, which acts on at most one face of the grid, to a `NodalSupport`; nodes: mask of the nodes that the
    support constrains, shape (n,)."""
    face, axes = support.face(), support.axes()
    wall = face if face is not None and axes[face[0]] else None
    until = inf if support.until is None else support.until
    return NodalSupport(nodes, axes, support.velocity, wall, face=face, until=until)


def nodes_of(support: "Support", grid: GridCase | None, of: Selectable) -> np.ndarray:
    """Return a mask of the nodes that a support constrains, shape (n,); of: all nodes of the grid or of a body."""
    region, face, position = support.region(), support.face(), of.position
    active = grid.active_axes() if grid else EVERY_AXIS
    if region is not None:
        reach = REACH * grid.cell if grid else 0.0
        return chosen_nodes(region, of, active, reach)
    if face is None or grid is None:
        return np.ones(len(position), bool)
    axis, end = face
    if not active[axis]:
        return np.ones(len(position), bool)
    cells = (position[:, axis] - grid.lower[axis]) / grid.cell
    return np.asarray(np.abs(cells - end * grid.counts()[axis]) <= REACH)
