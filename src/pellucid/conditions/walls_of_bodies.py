"""Bodies that act as walls of fluids in a run: their present region, their velocity, and the account of their reaction."""

from collections.abc import Sequence
from itertools import product

import numpy as np
from scipy import ndimage

from pellucid.conditions.rigid.kinematics import rotation_between
from pellucid.energy import IMPACT, MOTION, StepWork, WorkLayout
from pellucid.geometry.region import within
from pellucid.geometry.shapes.contract import ActiveAxes, Space
from pellucid.geometry.shapes.rotation import Turn
from pellucid.grid.actions import NodalActions
from pellucid.grid.lattice import Grid
from pellucid.parts.assembly import AssembledBody
from pellucid.parts.body import Body
from pellucid.parts.constraint import PrescribesWhole, RigidRates

MARGIN = 1e-6  # cells before a face of the grid, from which on a region that ends there continues
ROUNDING = 1e-6  # cells
ENDLESS = np.array([[-np.inf] * 3, [np.inf] * 3])
MOVED = 0.01  # cells by which the surface of a body may move along its normal before it is found again
PER_CELL = 2  # positions in a cell along each axis at which space that no fluid can reach is looked for


class EmptySpace:
    """Space outside of walls that contains no fluid and that no fluid can reach, since walls lie between.

    grid: the grid; walls: regions of all walls; fluid: positions of the points of fluids [m], shape (n, 3).
    """

    def __init__(self, grid: Grid, walls: Sequence[Space], fluid: np.ndarray) -> None:
        self._thin, self._periodic = np.array(grid.thin), np.array(grid.periodic)
        self._walls, self._periods = walls, grid.periods
        self._lower, self._apart = np.array(grid.lattice.lower), grid.lattice.cell / PER_CELL
        self._counts = np.where(self._thin, 1, PER_CELL * np.array(grid.lattice.counts))
        lattice = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in self._counts), indexing="ij"), axis=-1)
        place = (self._lower + self._apart * lattice).reshape(-1, 3)
        open_space = self._is_open(place).reshape(self._counts)
        parts, n = self._label(open_space)
        joined = np.arange(n + 1)
        for axis in np.flatnonzero(self._periodic):
            for one, other in zip(parts.take(0, axis).ravel(), parts.take(-1, axis).ravel(), strict=True):
                if one and other:
                    joined[joined == joined[one]] = joined[other]
        parts = joined[parts]
        wet = np.isin(parts, parts[self._index(fluid)]) & open_space
        self.exists = bool((open_space & ~wet).any())
        """True if there is such space as far as the lattice resolves it."""
        # open space that no position shows is wet if a neighbour is
        self._empty = (open_space & ~wet) | ~ndimage.binary_dilation(wet, np.ones((3, 3, 3), bool))

    @staticmethod
    def _label(mask: np.ndarray) -> tuple[np.ndarray, int]:
        """Return for each position of a mask the number, from 1, of the connected part to which it belongs, and the number of
        parts."""
        parts = np.zeros(mask.shape, np.int32)
        return parts, int(ndimage.label(mask, output=parts))

    def contains(self, place: np.ndarray) -> np.ndarray:
        """Return a mask of the positions [m], shape (n, 3), that lie in this space, shape (n,)."""
        inside = np.array(self._empty[self._index(place)])
        if inside.any():
            inside[inside] = self._is_open(place[inside])
        return inside

    def is_wet(self, place: np.ndarray) -> np.ndarray:
        """Return a mask of the positions [m], shape (n, 3), that fluids may reach, shape (n,)."""
        wet = ~self._empty[self._index(place)]
        wet[wet] = self._is_open(place[wet])
        return np.asarray(wet)

    def _is_open(self, place: np.ndarray) -> np.ndarray:
        """Return a mask of the positions [m], shape (n, 3), outside of all walls, shape (n,)."""
        x, y, z = ~self._thin
        inside = np.zeros(len(place), bool)
        for wall in self._walls:
            inside |= within(wall, place, (x, y, z), self._periods)
        return ~inside

    def _index(self, place: np.ndarray) -> tuple[np.ndarray, ...]:
        at = np.floor((place - self._lower) / self._apart).astype(int)
        return tuple(np.where(self._periodic, np.mod(at, self._counts), np.clip(at, 0, self._counts - 1)).T)


class MovedRegion:
    """Region that a body fills after a rigid motion. Where the region ends at a face of the grid, it continues beyond."""

    def __init__(self, shape: Space, turn: Turn, ends: np.ndarray, behind: EmptySpace | None) -> None:
        """shape: region at the start; turn: its motion; ends: lower and upper corner of the grid [m], shape (2, 3), infinite
        along axes on which the region does not continue; behind: space that counts as part of the region."""
        self._shape, self._turn, self._ends, self._behind = shape, turn, ends, behind
        corners = turn.forth(np.array(list(product(*zip(*shape.bounds(), strict=True)))))
        self._bounds = corners.min(axis=0), corners.max(axis=0)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return self._bounds

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        points = np.clip(points, *self._ends)
        inside = np.array(self._shape.contains(self._turn.back(points), active))
        if self._behind is not None and not inside.all():
            inside[~inside] = self._behind.contains(points[~inside])
        return inside


def find_region(member: AssembledBody, grid: Grid) -> Space | None:
    """Return the region that a solid fills at the start of the run, moved if it continues from an earlier run; None if its
    shape is not known. grid: the grid."""
    shape = member.model.wall_region(grid.case)
    if shape is None:
        return None
    place, seeds = member.selectable_by_number().position, member.model.standing(grid.case).position
    if np.abs(place - seeds).max() <= ROUNDING * grid.lattice.cell:
        return shape
    one, before, after = np.ones((len(seeds), 1)), seeds.mean(axis=0), place.mean(axis=0)
    return MovedRegion(shape, Turn(rotation_between(one, seeds - before, place - after), before, after), ENDLESS, None)


class BodyAsWall:
    """A body whose motion is prescribed and whose surface makes a wall."""

    rows: tuple[int, ...] = ()
    axes, slips = (True, True, True), False

    def __init__(self, member: AssembledBody, at_start: Space, actions: NodalActions) -> None:
        """member: the body; at_start: region that it fills at the start; actions: actions on the nodes of the fluids."""
        grid = actions.field.grid
        lower, upper = np.array(grid.case.lower), np.array(grid.case.extent_upper())
        inside = MARGIN * grid.lattice.cell
        open_axes = np.array(grid.periodic) | np.array(grid.thin)
        self._ends = np.where(open_axes, [[-np.inf], [np.inf]], [lower + inside, upper - inside])
        self.name, self._grid, self._body, self._at_start = f"the body {member.body.name}", grid, member.body, at_start
        self._active, self._rates = member.active_axes, RigidRates(np.zeros(3), np.zeros(3), np.zeros(3))
        self._feet = np.zeros((2, 0, 3))
        self._behind: EmptySpace | None = None
        self.move(Turn(np.eye(3), np.zeros(3), np.zeros(3)))

    @property
    def _constraint(self) -> PrescribesWhole:
        constraint: object = self._body.constraint
        if not isinstance(constraint, PrescribesWhole):
            raise ValueError(f"the motion of body {self._body.name} is not prescribed, but it acts as a wall")
        return constraint

    def move(self, turn: Turn) -> None:
        """Move the region by a rigid motion from its initial place."""
        self.turn, self._behind = turn, None
        self.region = MovedRegion(self._at_start, turn, self._ends, None)

    def fill_behind(self, behind: EmptySpace) -> None:
        """Let space that no fluid can reach count as part of the region."""
        self._behind = behind
        self.region = MovedRegion(self._at_start, self.turn, self._ends, behind)

    def faces_fluid(self, place: np.ndarray) -> np.ndarray:
        return np.ones(len(place), bool) if self._behind is None else self._behind.is_wet(place)

    def stand(self, feet: np.ndarray, normal: np.ndarray) -> None:
        """Store positions on the surface [m] and the unit normals there, shape (n, 3) each, by which `find_turn` detects
        motion."""
        away = MOVED * self._grid.lattice.cell * normal
        self._feet = np.stack([feet - away, feet + away])

    def find_turn(self) -> Turn | None:
        """Return the rigid motion of the body since the start, or None if its surface has not moved along its normal since it
        was found."""
        turn = self._constraint.placement()
        if all(np.array_equal(one, other) for one, other in zip(turn, self.turn, strict=True)):
            return None
        region = MovedRegion(self._at_start, turn, self._ends, None)
        if not self._feet.size:
            return turn
        inside, outside = (within(region, at, self._active, self._grid.periods) for at in self._feet)
        return None if inside.all() and not outside.any() else turn

    def begin_step(self) -> None:
        """Find the velocity of the body in this step, once its motions have begun the step."""
        self._rates = self._constraint.prescribed_rates()

    def velocity_at(self, place: np.ndarray) -> np.ndarray:
        return np.asarray(self._rates.velocity + np.cross(self._rates.turn, self._arms(place)))

    def account(self, impulse: np.ndarray, place: np.ndarray, layout: WorkLayout) -> StepWork:
        done, total = layout.no_work(), impulse.sum(axis=0)
        about = np.cross(self._arms(place), impulse).sum(axis=0)
        done.impulse[:] -= total
        done.works[[MOTION, IMPACT]] += float(total @ self._rates.velocity + about @ self._rates.turn)
        motions, turning = self._constraint.shares(np.concatenate([total, about]))
        return done._replace(motions=motions, turning=turning)

    def _arms(self, place: np.ndarray) -> np.ndarray:
        """Return the vectors from the centre of the body to positions, shape (n, 3) [m]; on a periodic grid, to the nearest
        images."""
        arms, periods = place - self._rates.centre, np.array(self._grid.periods)
        arms -= periods * np.round(arms / np.where(periods > 0.0, periods, np.inf))
        return np.where(self._grid.thin, 0.0, arms)


class EnclosedFluids:
    """Fluids of a velocity field between walls: finds the space that they cannot reach.

    name: name of the velocity field; grid: its grid; shapes: regions of walls made by supports; fluids: the fluids.
    """

    def __init__(self, name: str, grid: Grid, shapes: Sequence[Space], fluids: Sequence[Body]) -> None:
        self.name, self._grid, self._shapes, self._fluids, self._may_be = name, grid, shapes, fluids, True

    def fill_behind(self, bodies: Sequence[BodyAsWall]) -> None:
        """Let the space that the fluids cannot reach count as part of the regions of `bodies`. If there is none at the start,
        none is looked for later."""
        if not (bodies and self._may_be):
            return  # of a region without such space, only the inside would be found
        places = [fluid.stored_array("position")[fluid.stored_array("mass") > 0.0] for fluid in self._fluids]
        empty = EmptySpace(self._grid, [*self._shapes, *(body.region for body in bodies)], np.concatenate(places))
        self._may_be = empty.exists
        for body in bodies:
            body.fill_behind(empty)
