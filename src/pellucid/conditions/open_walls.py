"""Gaps between bodies and opening walls (walls that bodies can leave): such a wall acts only on bodies that have reached it."""

from collections.abc import Iterable

from pellucid.contact.contact_body import ContactBody
from pellucid.contact.detection import reach_of_point
from pellucid.grid.clearing import Clearing
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_conditions import YieldingWalls
from pellucid.grid.nodal_fields import STEP
from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, stencil
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop_by_colour
from pellucid.step.part import StepPart

FAR = 2.0  # cells from which on no point reaches the nodes of a wall
NEAR = 1e-4  # cells at which a body has come up to a wall: more than rounding


@parallel_loop_by_colour(gives="walls.gap")
def _measure_gaps(s, mapped, walls, face, radius, near):
    """Compute for each node of an opening wall the smallest gap [m] between the wall and the points of slab s that
    contribute to the node; write it to `walls.gap`. The extent of each point and the distance `near` [m] are subtracted.

    mapped: bundle of the body's `MappedPoints`; walls: bundle of the `YieldingWalls`; face: axis of the wall, direction
    into the grid, position [m]; radius: data from which `reach_of_point` computes the half width of a point.
    """
    functions, lattice, slabs, x = mapped.functions, mapped.lattice, mapped.slabs, mapped.points.position
    axis, inward, wall = face
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(mapped.index, q)
        gap = inward * (x[p, axis] - wall)
        if gap > FAR * lattice.cell:
            continue
        gap -= reach_of_point(radius, mapped.points.volume[p]) + near
        about = stencil(functions, lattice, x, p)
        for a in range(len(about.wx)):
            for b in range(len(about.wy)):
                for c in range(len(about.wz)):
                    I = node_at(about, lattice, a, b, c)
                    if about.wx[a] * about.wy[b] * about.wz[c] > 0.0 and walls.held[I, axis] > 0:
                        walls.gap[I, axis] = min(walls.gap[I, axis], gap)


Face = tuple[int, int]
"""Axis and end (0 lower, 1 upper) of a face of the grid."""


class OpenWalls(StepPart):
    """Active condition of the opening walls of one velocity field, which measures the gaps between walls and bodies. grid:
    grid of the field; walls: data of the walls; faces: axis and end of each wall; bodies: bodies in the field."""

    def __init__(self, grid: Grid, walls: YieldingWalls, faces: Iterable[Face], bodies: Iterable[ContactBody]) -> None:
        lattice = grid.lattice
        self._bodies, self._walls, self._near = list(bodies), Bundle(walls), NEAR * lattice.cell
        self._clear = Clearing(STEP, grid.rows, walls)
        ends = ((axis, end, lattice.lower[axis] + end * lattice.counts[axis] * lattice.cell) for axis, end in faces)
        self._faces = [(axis, 1.0 - 2.0 * end, place) for axis, end, place in ends]

    def begin(self, time: float, dt: float) -> None:
        self._clear()
        for body in self._bodies:
            for face in self._faces:
                _measure_gaps(body.n_slabs, body.mapped, self._walls, face, body.half_width(), self._near)
