"""New velocities of points from the nodes, with the heat of the transfer and the work of internal forces on the grid.

Forces at the nodes work along the nodes' mean velocity; a body that keeps heat takes up that work where its stress did it.
"""

from math import sqrt

from numpy import uintp

from pellucid.grid.affine import COUNT as AFFINE_COUNT
from pellucid.grid.affine import FIELD, renew_affine
from pellucid.grid.blocks import (
    about_lanes,
    add_columns,
    expect,
    fetch,
    find_functions,
    functions_like,
    keep,
    run_end,
)
from pellucid.grid.points import (
    AFFINE,
    GAINED,
    KEPT,
    KINETIC,
    LOSS,
    LUMPING,
    MOMENTUM_X,
    MOMENTUM_Y,
    MOMENTUM_Z,
    RATES,
    SPEED,
    VECTORS,
    cell_of,
    place_of,
)
from pellucid.grid.scatter import WEIGHTS, add_block
from pellucid.grid.stencil import gather, gather_gradient, gather_scalar
from pellucid.grid.transfer_heat import further_heat, lumping_heat
from pellucid.grid.velocity_transfer import HEAT, MASS, NEW, OLD, new_velocity
from pellucid.jit import kernel, pointwise
from pellucid.jit.columns import BLOCK, WIDTH, put, size, take, take_lanes
from pellucid.jit.local import indices, numbers, zeros
from pellucid.jit.parallel import joint_by_colour
from pellucid.jit.vector import LANES, load, total
from pellucid.tensors import IDENTITY, NO_STRESS, ZERO_VECTOR, stress_power

# columns of a block after HEAT: gradient of the mean velocity, sums from MOVED on, energy, volume, stress, place
GRADIENT, MOVED, WORKED, ENERGY, PLACE, COUNT = 9, 18, 25, 27, 35, 38
MOVED_POINT = ZERO_VECTOR, ZERO_VECTOR, 0.0  # place, velocity, mass
WORKED_ON = 0.0, 0.0, NO_STRESS  # energy, volume, stress
SUMS = KINETIC, MOMENTUM_X, MOMENTUM_Y, MOMENTUM_Z, SPEED, LUMPING, LOSS, GAINED, KEPT
"""Of the columns from MOVED on."""


@pointwise
def _gather_block(mapped, energy, strained, start, n, found, first_node, c):
    """New velocities, heats and gradients of the mean velocity of a block; how many vectors of points these took."""
    points, index = mapped.points, mapped.index
    functions, transfer, lattice, nodes = mapped.functions, mapped.transfer, mapped.lattice, mapped.nodes
    a = vectors = 0
    while a < n:
        end = run_end(first_node, a, n)
        vectors += (end - a + LANES - 1) // LANES
        while a < end:
            expect(index, MOVED_POINT, (points.position, points.velocity, points.mass), start + a)
            if len(mapped.affine) > 0:
                expect(index, FIELD, mapped.affine, start + a)
            if len(energy) > 0:
                expect(index, (*WORKED_ON, 0.0), (energy, points.volume, points.stress, mapped.heat), start + a)
            about = about_lanes(functions, found, first_node, a)
            v = take_lanes(ZERO_VECTOR, c, a + OLD * WIDTH)
            change, mean = gather(about, lattice, nodes.velocity_increment), gather(about, lattice, nodes.velocity)
            lumping = lumping_heat(gather_scalar(about, lattice, nodes.increment_energy), change)
            new = (
                new_velocity(transfer, v[0], mean[0], change[0]),
                new_velocity(transfer, v[1], mean[1], change[1]),
                new_velocity(transfer, v[2], mean[2], change[2]),
            )
            heat = lumping + further_heat(transfer, about, lattice, nodes, v, mean, change)
            put(c, a + NEW * WIDTH, (new, lumping, heat))
            if strained:
                put(c, a + GRADIENT * WIDTH, gather_gradient(about, lattice, nodes.mean_velocity))
            a += LANES
        a = end
    return vectors


@pointwise
def _take_work(mapped, energy, dt, start, n, c):
    """Add the work on the points of a block to their energies, and keep their heat; what was gained, and of it the heat, into
    columns."""
    points, index, keeps_losses = mapped.points, mapped.index, len(mapped.affine) > 0
    fetch(index, WORKED_ON, (energy, points.volume, points.stress), start, n, c, ENERGY * WIDTH)
    for q in range(n):
        before, V, s = take(WORKED_ON, c, q + ENERGY * WIDTH)
        m, heat = c[uintp(q + MASS * WIDTH)], c[uintp(q + HEAT * WIDTH)]
        kept = heat if heat > 0.0 or keeps_losses else 0.0
        more = V / m * (dt * stress_power(s, take(IDENTITY, c, q + GRADIENT * WIDTH))) + kept
        put(c, q + WORKED * WIDTH, (m * more, m * kept, before + more))
    keep(index, 0.0, energy, start, n, c, ENERGY * WIDTH)
    keep(index, 0.0, mapped.heat, start, n, c, HEAT * WIDTH)


@pointwise
def _add_rates(mapped, start, n, c):
    """Add the rates of volume of the points of a block to those of their cells."""
    rates, position, volume, index = mapped.cells.sums, mapped.points.position, mapped.points.volume, mapped.index
    for q in range(n):
        p = place_of(index, start + q)
        L = take(IDENTITY, c, q + GRADIENT * WIDTH)
        rates[cell_of(mapped.lattice, position, p), RATES] += volume[p] * (L[0] + L[4] + L[8])


@kernel(inner=True)
def _update_velocities_slab(s, mapped, energy, dt, remap):
    functions, transfer, lattice = mapped.functions, mapped.transfer, mapped.lattice
    points, slabs, index = mapped.points, mapped.slabs, mapped.index
    if slabs.first[s] == slabs.first[s + 1]:
        return
    worked, in_cells = len(energy) > 0, len(mapped.cells.found) > 0
    found, first_node = numbers(WIDTH * size(functions_like(functions))), indices(BLOCK)
    c, sums = zeros(WIDTH * COUNT), zeros(len(SUMS) * LANES)
    fields, field_energies = numbers(WIDTH * AFFINE_COUNT), zeros(LANES)
    weights, vectors = numbers(WIDTH * WEIGHTS), 0
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch(index, (ZERO_VECTOR, 0.0), (points.velocity, points.mass), start, n, c, OLD * WIDTH)
        fetch(index, ZERO_VECTOR, points.position, start, n, c, PLACE * WIDTH)
        find_functions(functions, lattice, n, c, PLACE * WIDTH, found, first_node)
        vectors += _gather_block(mapped, energy, worked or in_cells, start, n, found, first_node, c)
        renew_affine(transfer, mapped, start, n, found, first_node, c, fields, field_energies)
        keep(index, ZERO_VECTOR, points.velocity, start, n, c, NEW * WIDTH)
        if in_cells:
            _add_rates(mapped, start, n, c)
        if worked:
            _take_work(mapped, energy, dt, start, n, c)
        for q in range(n):
            (x, y, z), lumping, lost = take((ZERO_VECTOR, 0.0, 0.0), c, q + NEW * WIDTH)
            m, vv = c[uintp(q + MASS * WIDTH)], x * x + y * y + z * z
            put(c, q + MOVED * WIDTH, (0.5 * m * vv, m * x, m * y, m * z, m * sqrt(vv), m * lumping, m * lost))
        add_columns(c, MOVED, n, sums, 0, len(SUMS))
        if remap:
            add_block(functions, mapped, start, n, found, first_node, weights, (1, 0, 0.0))
    for number, column in enumerate(SUMS):
        slabs.sums[s, column] = total(load(sums, number * LANES))
    slabs.sums[s, AFFINE], slabs.sums[s, VECTORS] = total(load(field_energies, 0)), vectors


@kernel()
def update_velocities(n, mapped, energy, dt, remap):
    """New velocities of the points; where `remap` their momentum mapped to the nodes again.

    Fills LUMPING and LOSS of the sums, and `heat` where it is kept, with what the transfer loses of kinetic energy; of APIC the
    affine fields too, AFFINE with their kinetic energy [J], and the heat holds what the way of the points since the last step
    lost of it.
    energy, shape (points,), or (0,) of a body that keeps no heat: specific energy [J/kg], to which dt V σ:∇v̄ is added, with
    volume, stress and functions of the forces on the nodes and the mean velocity v̄ along which these did their work over the
    step dt [s], and the heat of the transfer where it is a loss; of APIC always, since it swings with the way of the points.
    GAINED and KEPT of the sums: what was added, and the heat in it [J]. VECTORS: how many vectors of points with the same nodes
    there were.
    """
    joint_by_colour(_update_velocities_slab, n, mapped.slabs.across, mapped, energy, dt, remap)
