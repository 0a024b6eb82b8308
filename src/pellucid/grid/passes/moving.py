"""The loop that moves points one by one, with a rule for their displacement."""

from typing import Any, NamedTuple

from numpy import intp

from pellucid.grid.passes.places import bounds_of, comes_first, placed
from pellucid.grid.points import MappedPoints, place_of
from pellucid.jit import generic, kernel, point_function
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import joint_for, parallel_for


class MovingPoints(NamedTuple):
    """Input of `move_points`: the points of a body, and the rule by which the function `displacement` computes how far each
    point moves in a step."""

    mapped: MappedPoints
    rule: Any  # kind of motion, whose type selects `displacement`


class Stay(NamedTuple):
    """Rule for `move_points` with zero displacement: `move_points` then only checks whether the positions, which other code
    has changed, are inside the grid and the slabs."""


@generic
def displacement(rule: Any, mapped: Any, p: Any, dt: float) -> Any:
    """Return the displacement [m] of point p of `mapped` (`MappedPoints`) over a step dt [s], as three numbers; rule: kind of
    motion, whose type selects the implementation."""


@point_function(displacement, Stay)
def _none(rule, mapped, p, dt):
    return 0.0, 0.0, 0.0


@kernel(inner=True)
def _slab(s, points, dt):
    mapped = points.mapped
    lattice, index, slabs, x = mapped.lattice, mapped.index, mapped.slabs, mapped.points.position
    bounds = bounds_of(slabs, s)
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        dx, dy, dz = displacement(points.rule, mapped, p, dt)
        fault, beyond = placed(lattice, x, p, dx, dy, dz, bounds)
        slabs.left_slab[s] |= beyond
        if comes_first(fault, slabs.fault[s, 0]):  # what was found earlier in the step stays
            slabs.fault[s, 0] = fault
            slabs.fault[s, 1] = intp(p)


@kernel()
def _move(n, points, dt):
    parallel_for(_slab, n, points, dt)


@kernel()
def _move_jointly(n, points, dt):
    joint_for(_slab, n, points, dt)


def move_points(points: Bundle, dt: float) -> None:
    """Move the points of a body over a step dt [s], and record faults and points outside their slab in `Slabs`; points: result
    of `moving`."""
    _move(len(points.mapped.slabs.layers), points, dt)


def move_points_jointly(points: Bundle, dt: float) -> None:
    """Move the points of a body as `move_points` does, within a joint region (several loops over slabs, i.e. blocks of grid
    cells, that run as one parallel loop), slab by slab after the other loops of the body."""
    _move_jointly(len(points.mapped.slabs.layers), points, dt)


def moving(mapped: MappedPoints, rule: Any) -> Bundle:
    """Return the input of `move_points`: the points of a body, and the rule that selects the implementation of `displacement`,
    by which they move."""
    return Bundle(MovingPoints(mapped, rule))
