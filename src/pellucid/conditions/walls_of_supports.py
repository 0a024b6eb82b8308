"""Supports whose shapes act as walls of fluids in a run: their regions, and the account of their reactions.

Walls are often made of several shapes that touch or overlap. A face of one shape inside another one is no surface on which a
fluid flows: as a wall of its own, each shape would drag the fluid with its whole surface, also with the faces at seams. Shapes
that touch and hold the same axes therefore make one wall. Its region is their union, and its velocity at a node is that of the
support whose shape has the surface there. Supports that hold different axes, or of which only one lets fluids slip, make walls
of their own. Such a wall has no surface inside another one that holds all its axes; at a seam both are approximate.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from scipy import ndimage
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from pellucid.energy import IMPACT, SUPPORT, StepWork, WorkLayout
from pellucid.geometry.region import within
from pellucid.geometry.shapes.contract import ActiveAxes, Geometry, Space
from pellucid.grid.actions import NodalActions
from pellucid.grid.lattice import Grid

if TYPE_CHECKING:
    from pellucid.conditions.support import Support

PER_CELL = 4  # positions in a cell along each axis at which shapes that touch are looked for
AROUND = 2  # cells around the nodes of both shapes, between which they may touch
MOST_PLACES = 1_000_000  # largest number of positions evaluated at once
INSIDE = 1e-3  # cells below the surface: the shapes that contain this position have the surface


class Part(NamedTuple):
    """A support whose shape makes a wall or a part of one."""

    row: int  # index of the support among all supports, split so that each acts on at most one face
    support: "Support"
    region: Geometry


class UnionOfShapes(NamedTuple):
    """The region that several shapes fill together."""

    shapes: Sequence[Geometry]

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        lower, upper = zip(*(shape.bounds() for shape in self.shapes), strict=True)
        return np.min(lower, axis=0), np.max(upper, axis=0)

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        inside, on = np.zeros(len(points), bool), np.array(active)
        for shape in self.shapes:
            lower, upper = shape.bounds()
            near = np.flatnonzero(~inside & np.all(((points >= lower) & (points <= upper))[:, on], axis=1))
            inside[near] = shape.contains(points[near], active)
        return inside


class SupportsAsWall:
    """Supports whose shapes touch, which hold the same axes and slip alike: they make one wall together."""

    def __init__(self, parts: Sequence[Part], actions: NodalActions) -> None:
        """parts: the supports, at least one; actions: actions on the nodes of the fluids."""
        first, names = parts[0].support, [f"`{part.support.name}`" for part in parts if part.support.name]
        one, several = f"the support {', '.join(names)}", f"the supports {', '.join(names)}"
        self.name = ("the wall of a support", one, several)[min(len(names), 2)]
        self.rows, self.axes, self.slips = tuple(part.row for part in parts), first.axes(), first.slips()
        self.shapes = [part.region for part in parts]
        self.region: Space = self.shapes[0] if len(parts) == 1 else UnionOfShapes(self.shapes)
        self.others: Sequence[Space] = ()
        """Regions of other walls inside which this one has no surface."""
        self._grid, self._velocities = actions.field.grid, actions.supports.velocity[list(self.rows)]
        # for several supports: velocities of the wall at the nodes near the surface, and the share of each support there
        self._velocity, self._shares = np.zeros((0, 3)), np.zeros((len(parts), 0))

    def faces_fluid(self, place: np.ndarray) -> np.ndarray:
        outside = np.ones(len(place), bool)
        for region in self.others:
            outside &= ~within(region, place, self._grid.active_axes, self._grid.periods)
        return outside

    def velocity_at(self, place: np.ndarray) -> np.ndarray:
        return self._velocities[0] if len(self.rows) == 1 else self._velocity

    def find_owners(self, place: np.ndarray, feet: np.ndarray, normal: np.ndarray) -> None:
        """Find the support to which each node near the surface belongs: the last one whose shape has the surface there, else
        the last one whose shape contains the node. Supports with the same velocity of which this holds share the reaction.

        place: positions of the nodes [m]; feet: positions on the surface next to them [m]; normal: unit normals there; shape
        (n, 3) each.
        """
        if len(self.rows) == 1:
            return
        below = feet - INSIDE * self._grid.lattice.cell * normal
        has_surface, has_node = (self._in_shapes(at) for at in (below, place))
        belongs = np.where(has_surface.any(axis=0), has_surface, has_node)
        belongs[-1] |= ~belongs.any(axis=0)
        self._velocity = self._velocities[len(self.rows) - 1 - belongs[::-1].argmax(axis=0)]
        belongs &= np.all(self._velocities[:, None] == self._velocity, axis=2)
        self._shares = belongs / belongs.sum(axis=0)

    def _in_shapes(self, place: np.ndarray) -> np.ndarray:
        """Return masks of the positions [m], shape (n, 3), in each shape, shape (shapes, n)."""
        active, periods = self._grid.active_axes, self._grid.periods
        return np.stack([within(shape, place, active, periods) for shape in self.shapes])

    def account(self, impulse: np.ndarray, place: np.ndarray, layout: WorkLayout) -> StepWork:
        done = layout.no_work()
        totals = impulse.sum(axis=0)[None] if len(self.rows) == 1 else self._shares @ impulse
        for row, velocity, total in zip(self.rows, self._velocities, totals, strict=True):
            done.reactions[row] += total
            done.impulse[:] -= total
            done.works[[SUPPORT, IMPACT]] += float(total @ velocity)
        return done


def walls_of_supports(parts: Sequence[Part], actions: NodalActions) -> list[SupportsAsWall]:
    """Return the walls that supports make in a velocity field, in the order of the first support of each. parts: the supports;
    actions: actions on the nodes of the field."""
    grid, pairs = actions.field.grid, np.zeros((len(parts), len(parts)), bool)
    held = [np.array(part.support.axes()) & grid.active_axes for part in parts]
    nodes = [_around(part.region, grid) for part in parts] if len(parts) > 1 else []
    for k, one in enumerate(parts):
        for n, other in enumerate(parts[:k]):
            alike = one.support.slips() == other.support.slips() and np.array_equal(held[k], held[n])
            pairs[k, n] = alike and _touch(one.region, other.region, nodes[k] & nodes[n], grid)
    label = connected_components(csr_array(pairs), directed=False)[1] if len(parts) else np.zeros(0, int)
    walls = [
        SupportsAsWall([part for part, of in zip(parts, label, strict=True) if of == wall], actions)
        for wall in dict.fromkeys(label.tolist())
    ]
    for wall in walls:
        freed = [np.array(wall.axes) & grid.active_axes & ~np.array(other.axes) for other in walls]
        wall.others = [other.region for other, axes in zip(walls, freed, strict=True) if other is not wall and not axes.any()]
    return walls


def _around(region: Geometry, grid: Grid) -> np.ndarray:
    """Return a mask of the nodes of a grid that lie at most `AROUND` cells along each axis from a node in a region."""
    place = grid.where()[1]
    active, cell, lower = np.array(grid.active_axes), grid.lattice.cell, place.min(axis=0)
    at = np.where(active, np.rint((place - lower) / cell), 0).astype(int)
    box = np.zeros(at.max(axis=0) + 1, bool)
    box[tuple(at.T)] = within(region, place, grid.active_axes, grid.periods)
    modes: list[Literal["wrap", "nearest"]] = ["wrap" if periodic else "nearest" for periodic in grid.periodic]
    size = np.where(active, 2 * AROUND + 1, 1).tolist()
    return np.asarray(ndimage.maximum_filter(box, size=size, mode=modes)[tuple(at.T)])


def _touch(one: Geometry, other: Geometry, nodes: np.ndarray, grid: Grid) -> bool:
    """Return True if two regions overlap or lie less than about a quarter of a cell apart, in the cells around `nodes`, a
    mask of the nodes of a grid."""
    active, periods, apart = grid.active_axes, grid.periods, grid.lattice.cell / PER_CELL
    steps = np.arange(-PER_CELL // 2, PER_CELL // 2 + 1)  # with one step more than a cell, for neighbours in the next cell
    block = np.stack(np.meshgrid(*(apart * steps if on else [0.0] for on in active), indexing="ij"), axis=-1)
    place = grid.where()[1][nodes]
    at_once, size = max(1, MOST_PLACES // (block.size // 3)), [1, *(3 if on else 1 for on in active)]
    for k in range(0, len(place), at_once):
        at = (place[k : k + at_once, None] + block.reshape(-1, 3)).reshape(-1, 3)
        in_one, in_other = (within(region, at, active, periods).reshape(-1, *block.shape[:3]) for region in (one, other))
        if (ndimage.maximum_filter(in_one, size=size, mode="constant") & in_other).any():
            return True
    return False
