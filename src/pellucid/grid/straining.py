"""Velocity gradients at the points and what follows from them: volumes, stresses, new places."""

from math import inf, sqrt
from typing import Any, NamedTuple

from numpy import intp, uintp

from pellucid.grid.blocks import (
    about_lanes,
    add_columns,
    expect,
    fetch,
    find_functions,
    functions_like,
    keep,
    keep_where,
    largest_of_column,
    run_end,
)
from pellucid.grid.points import (
    DISSIPATED,
    HEATING,
    INVERTED,
    LOST,
    LOST_POWER,
    NOT_FINITE,
    OK,
    POWER,
    RATE,
    SHIFT,
    STORED,
    MappedPoints,
    cell_of,
    place_of,
)
from pellucid.grid.stencil import gather, gather_gradient
from pellucid.grid.transfer import bounds_of, strays
from pellucid.jit import kernel, pointwise
from pellucid.jit.columns import BLOCK, WIDTH, put, size, take
from pellucid.jit.local import indices, numbers, zeros
from pellucid.jit.parallel import joint_for
from pellucid.jit.vector import LANES, load, total
from pellucid.materials.law import (
    artificial_heating,
    diffusivity,
    dissipated_energy,
    signal_speed,
    stored_energy,
    update,
    volume_growth,
)
from pellucid.materials.point_state import load as load_state
from pellucid.tensors import IDENTITY, ZERO_VECTOR, end_stress_power

GIVEN = IDENTITY, ZERO_VECTOR, ZERO_VECTOR, ZERO_VECTOR, 0.0, 0.0  # velocity gradient, motion; place, velocity, mass, volume
MOVED = ZERO_VECTOR, ZERO_VECTOR, 0.0, 0.0  # the last four of these
# columns of a block: those of GIVEN, in place of some of which comes what was found; MAGNITUDE: at first the speed
PLACE, IN_CELLS, MASS, VOLUME, GROWTH, MAGNITUDE, BAD, OF_LAW, FASTEST, STATE = 12, 15, 18, 19, 20, 21, 22, 24, 28, 29
SUMS = 6  # from BAD on: bad points, points beyond their slab, and of STORED, DISSIPATED, POWER, HEATING


class StrainedPoints(NamedTuple):
    """Points that the velocity gradient strains, and their law."""

    mapped: MappedPoints
    law: Any
    state: Any  # arrays of the state of the law


@pointwise
def gather_motion(mapped, like, arrays, start, n, found, first_node, c):
    """Velocity gradients and velocities of the nodes at the n points of a block, into its first columns.

    arrays: those of which rows like `like` will be fetched for the next block.
    """
    a = 0
    while a < n:
        end = run_end(first_node, a, n)
        while a < end:
            expect(mapped.index, like, arrays, start + a)
            about = about_lanes(mapped.functions, found, first_node, a)
            L = gather_gradient(about, mapped.lattice, mapped.nodes.strain_velocity)
            put(c, a, (L, gather(about, mapped.lattice, mapped.nodes.velocity)))
            a += LANES
        a = end


@pointwise
def _shift_growth(mapped, start, n, c):
    """Add what the points of a cell lack in growth of volume to the velocity gradients of a block, along all axes alike."""
    found, index, counts = mapped.cells.found, mapped.index, mapped.lattice.counts
    along = (1.0 if counts[0] > 1 else 0.0, 1.0 if counts[1] > 1 else 0.0, 1.0 if counts[2] > 1 else 0.0)
    each = 1.0 / (along[0] + along[1] + along[2])
    for q in range(n):
        shift = each * found[cell_of(mapped.lattice, mapped.points.position, place_of(index, start + q)), SHIFT]
        for d in range(3):
            c[uintp(q + 4 * d * WIDTH)] += along[d] * shift


@pointwise
def _move(law, lattice, step, dt, bounds, n, c):
    """New places and volumes of the points of a block, their speeds, and which of them are bad or beyond their slab.

    Like the law, in a loop that writes nothing but columns and becomes vectors; in one loop with the law the processor would
    not see from one round to the next.
    """
    h, low, counts = lattice.inverse_cell, lattice.lower, lattice.counts
    for q in range(n):
        L, (ux, uy, uz), (x, y, z), (vx, vy, vz), m, V = take(GIVEN, c, q)
        x, y, z = x + step * ux, y + step * uy, z + step * uz
        X, Y, Z = (x - low[0]) * h, (y - low[1]) * h, (z - low[2]) * h
        growth = volume_growth(law, L, dt)
        speed = sqrt(vx * vx + vy * vy + vz * vz)
        bad = 0.0 if growth > 0.0 else 1.0
        bad = bad if X >= 0.0 else 1.0
        bad = bad if Y >= 0.0 else 1.0
        bad = bad if Z >= 0.0 else 1.0
        bad = bad if counts[0] >= X else 1.0
        bad = bad if counts[1] >= Y else 1.0
        bad = bad if counts[2] >= Z else 1.0
        put(c, q + PLACE * WIDTH, ((x, y, z), (X, Y, Z), m, growth * V, growth, speed, bad, strays(lattice, X, Y, Z, bounds)))


@pointwise
def _respond(law, lattice, dt, n, state_like, c):
    """The law at the points of a block."""
    h = lattice.inverse_cell
    for q in range(n):
        L, (m, V, _, speed, bad) = take(IDENTITY, c, q), take((0.0, 0.0, 0.0, 0.0, 0.0), c, q + MASS * WIDTH)
        density = m / V
        state = update(law, take(state_like, c, q + STATE * WIDTH), density, L, dt, lattice.cell)
        energy = stored_energy(law, state, density)
        signal = signal_speed(law, state, density, L, lattice.cell)
        magnitude = abs(energy + state.stress[0] + state.stress[1] + state.stress[2] + speed + signal)
        rate, viscous = h * (signal + speed), 2.0 * h * h * diffusivity(law, density)
        sums = (
            m * energy,
            m * dissipated_energy(law, state, density),
            V * end_stress_power(state.stress, L, dt),
            m * artificial_heating(law, state, density, L, lattice.cell),
        )
        put(c, q + MAGNITUDE * WIDTH, (magnitude, bad if magnitude < inf else 1.0))
        put(c, q + OF_LAW * WIDTH, (sums, rate if rate > viscous else viscous, state))


@pointwise
def _fault(c, q, counts):
    """What is wrong with point q of a block."""
    (X, Y, Z), _, _, growth, magnitude = take((ZERO_VECTOR, 0.0, 0.0, 0.0, 0.0), c, q + IN_CELLS * WIDTH)
    if growth <= 0.0:
        return INVERTED
    if not (growth > 0.0 and magnitude < inf and abs(X + Y + Z) < inf):
        return NOT_FINITE
    inside = X >= 0.0 and counts[0] >= X and Y >= 0.0 and counts[1] >= Y and Z >= 0.0 and counts[2] >= Z
    return OK if inside else LOST


@kernel(inner=True)
def _update_stress_slab(s, strained, dt, move):
    mapped, law, arrays = strained.mapped, strained.law, strained.state
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    if slabs.first[s] == slabs.first[s + 1]:
        return
    moved, bounds = (points.position, points.velocity, points.mass, points.volume), bounds_of(slabs, s)
    first_fault = at_fault = 0
    lost_power = 0.0
    state_like = load_state(arrays, uintp(0))
    found, first_node = numbers(WIDTH * size(functions_like(functions))), indices(BLOCK)
    c, sums = numbers(WIDTH * (STATE + size(state_like))), zeros((SUMS + 1) * LANES)
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch(index, MOVED, moved, start, n, c, PLACE * WIDTH)
        fetch(index, state_like, arrays, start, n, c, STATE * WIDTH)
        find_functions(functions, lattice, n, c, PLACE * WIDTH, found, first_node)
        gather_motion(mapped, (MOVED, state_like), (moved, arrays), start, n, found, first_node, c)
        if len(mapped.cells.found) > 0:
            _shift_growth(mapped, start, n, c)
        _move(law, lattice, dt * move, dt, bounds, n, c)
        _respond(law, lattice, dt, n, state_like, c)
        add_columns(c, BAD, n, sums, 0, SUMS)
        largest_of_column(c, FASTEST, n, sums, SUMS)
        if total(load(sums, 0)) > 0.0:
            for q in range(n):
                fault = _fault(c, q, lattice.counts)
                if fault == LOST:
                    lost_power += c[uintp(q + (OF_LAW + 2) * WIDTH)]
                # a point that left may be allowed to: any other fault comes before it
                if fault != OK and (first_fault == OK or (first_fault == LOST and fault != LOST)):
                    first_fault = fault
                    at_fault = intp(place_of(index, start + q))  # type: ignore[assignment]
        # what would turn over stays as it was, to be read afterwards
        sound = total(load(sums, 0)) == 0.0
        keep_where(GROWTH, sound, index, 0.0, points.volume, start, n, c, VOLUME * WIDTH)
        keep_where(GROWTH, sound, index, state_like, arrays, start, n, c, STATE * WIDTH)
        if move:
            keep(index, ZERO_VECTOR, points.position, start, n, c, PLACE * WIDTH)
    slabs.left_slab[s] = 1 if move and total(load(sums, LANES)) > 0.0 else 0
    slabs.fault[s, 0] = first_fault
    slabs.fault[s, 1] = at_fault
    for k, column in enumerate((STORED, DISSIPATED, POWER, HEATING)):
        slabs.sums[s, column] = total(load(sums, (2 + k) * LANES))
    slabs.sums[s, LOST_POWER] = lost_power
    top = 0.0
    for lane in range(LANES):
        top = max(top, sums[SUMS * LANES + lane])
    slabs.sums[s, RATE] = top


@kernel()
def update_stress(n, strained, dt, move):
    """Velocity gradients, new volumes and stresses; where `move` new positions. Fills STORED, DISSIPATED, HEATING,
    POWER, RATE of the sums, and LOST_POWER with the part of POWER of points that left the grid.

    strained: the bundle of `StrainedPoints`.
    """
    joint_for(_update_stress_slab, n, strained, dt, move)
