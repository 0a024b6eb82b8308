"""Bounds of points: the grid, and the layers of the slab into which they were sorted."""

from math import inf

from pellucid.grid.folding import beyond_span, in_period
from pellucid.grid.points import LOST, NOT_FINITE, OK
from pellucid.jit import pointwise


@pointwise
def bounds_of(slabs, s):
    """Return the bounds for the points of slab s [cells from the lower walls]: lower and upper along the slowest axis in
    memory, lower and upper along the axis on which rows of slabs are cut into slabs; slabs: `Slabs`."""
    return slabs.bounds[s, 0], slabs.bounds[s, 1], slabs.bounds[s, 2], slabs.bounds[s, 3]


@pointwise
def in_cells(lattice, place):
    """Return a position [m] as three numbers in cells from the lower walls, folded into the box along periodic axes."""
    h, low, folding = lattice.inverse_cell, lattice.lower, lattice.folding
    X, Y = in_period(folding, 0, (place[0] - low[0]) * h), in_period(folding, 1, (place[1] - low[1]) * h)
    return X, Y, in_period(folding, 2, (place[2] - low[2]) * h)


@pointwise
def strays(lattice, X, Y, Z, bounds):
    """Return 1.0 if a point at X, Y, Z, in cells from the lower walls, is outside the bounds of its slab (a block of grid
    cells, see `bounds_of`), else 0.0."""
    main, second = lattice.slab_axis, lattice.cut_axis
    along = X if main == 0 else (Y if main == 1 else Z)
    across = X if second == 0 else (Y if second == 1 else Z)
    beyond = beyond_span(lattice.folding, main, along, bounds[0], bounds[1])
    return 1.0 if beyond_span(lattice.folding, second, across, bounds[2], bounds[3]) > 0.0 else beyond


@pointwise
def outside(lattice, X, Y, Z):
    """Return 1.0 if a position X, Y, Z, in cells from the lower walls, is outside the grid or not finite, else 0.0."""
    n = lattice.counts
    bad = 0.0 if X >= 0.0 else 1.0
    bad = bad if Y >= 0.0 else 1.0
    bad = bad if Z >= 0.0 else 1.0
    bad = bad if n[0] >= X else 1.0
    bad = bad if n[1] >= Y else 1.0
    return bad if n[2] >= Z else 1.0


@pointwise
def fault_of_place(place):
    """Return the fault code of a position [m] outside the grid: LOST, or NOT_FINITE if a coordinate is not a finite number."""
    return LOST if abs(place[0] + place[1] + place[2]) < inf else NOT_FINITE


@pointwise
def comes_first(fault, first):
    """Return True if a slab (a block of grid cells) reports the fault code `fault` of a point instead of `first`, the code
    that was found before. A point may be allowed to leave the grid, so any other fault has priority over LOST."""
    return fault != OK and (first == OK or (first == LOST and fault != LOST))


@pointwise
def placed(lattice, x, p, dx, dy, dz, bounds):
    """Move point p of the positions x [m] by (dx, dy, dz) [m]; return the fault code of its new position, and 1 if it is
    outside the bounds of its slab (a block of grid cells, see `bounds_of`), else 0."""
    x[p, 0] += dx
    x[p, 1] += dy
    x[p, 2] += dz
    place = (x[p, 0], x[p, 1], x[p, 2])
    X, Y, Z = in_cells(lattice, place)
    beyond = 1 if strays(lattice, X, Y, Z, bounds) > 0.0 else 0
    return (OK if outside(lattice, X, Y, Z) == 0.0 else fault_of_place(place)), beyond
