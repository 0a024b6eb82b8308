"""Update of membrane points in blocks (groups of successive points): inputs are copied to the columns of a work array, results
back.

Loops that write only to columns are vectorized. Failed points are processed like the others, but their results are not copied
back. The records of damage are updated point by point.
"""

from math import inf, sqrt

from numpy import uintp

from pellucid.bodies.membrane_points.point import in_frame, in_space, spun, turned
from pellucid.grid.passes.blocks import expect, fetch, keep_where
from pellucid.grid.points import FOLDED, INVERTED, NOT_FINITE, OK, place_of
from pellucid.jit import pointwise
from pellucid.jit.columns import WIDTH, put, take
from pellucid.jit.vector import LANES
from pellucid.materials.damage import dissipate, driving_strain, has_failed, upright, weaken
from pellucid.materials.membrane import (
    damped_rate,
    fastest_wave,
    plane_diffusivity,
    plane_response,
    plane_wave_speed,
    principal_tension,
    record_loss,
    stretched,
    with_viscosity,
)
from pellucid.tensors import IDENTITY, NO_STRESS, ZERO_VECTOR, end_stress_power

NO_SHAPE = (0.0, 0.0, 0.0, 0.0)
# columns of a block: velocity gradient, frame, sum of the normals around a point, share of area, shape, 1 for a point that has
# not failed, rate of deformation, cosine of the angle between old and new normal, strain that drives damage
GRADIENT, FRAME, NORMALS, SHARE, SHAPE, BEARS, STRETCHING, COSINE, STRAIN = 0, 9, 18, 21, 22, 26, 27, 30, 31
# mass, strain energy, speed, volume, stress in the frame, remaining stiffness and its ratio to the one before, thickness ratio
MASS, ENERGY, SPEED, VOLUME, PLANE_STRESS, LEFT, KEPT, RATIO = 32, 33, 34, 35, 36, 39, 40, 41
# stress in space; value that indicates faults; number of faults, STORED, POWER, largest signal rate
STRESS, MAGNITUDE, BAD, FASTEST, COLUMNS = 44, 50, 51, 54, 55
SUMS = 3  # number of summed columns, from BAD on


@pointwise
def fetch_shapes(surface, start, n, c):
    """Copy frames, in-plane deformations and velocity gradients of a block of n points to the columns of the work array c.

    surface: a `StrainedMembrane`; start: number of the first point of the block, in the order of slabs (layers of grid
    cells).
    """
    index, damage, record, state = surface.index, surface.damage, surface.record, surface.state
    fetch(index, (IDENTITY, IDENTITY), (surface.gradient, state.frame), start, n, c, GRADIENT * WIDTH)
    fetch(index, NO_SHAPE, state.in_plane, start, n, c, SHAPE * WIDTH)
    for q in range(n):
        c[uintp(q + BEARS * WIDTH)] = 0.0 if has_failed(damage, record, place_of(index, start + q)) else 1.0


@pointwise
def all_bear(c, n):
    """Return True if none of the n points of a block has failed, so that all carry stress. c: work array."""
    q = 0
    while q < n and c[uintp(q + BEARS * WIDTH)] > 0.0:
        q += 1
    return q == n


@pointwise
def turn_and_stretch(surface, dt, start, n, c, stress_too):
    """Compute the new frames and in-plane deformations of n points from the moved triangles and the velocity gradients, and
    the strains that drive damage.

    surface: a `StrainedMembrane`; dt: time step [s]; start: first point, in the order of slabs; c: work array; stress_too:
    True if stresses are computed in the same loop; inputs of the stress update are then prefetched.
    """
    index, law, damage = surface.index, surface.law, surface.damage
    first, triangle, normals = surface.fans.start, surface.fans.triangle, surface.fans.normals
    points, state = surface.points, surface.state
    for q in range(n):
        if stress_too and q % LANES == 0:
            expect(index, (0.0, 0.0, 0.0), (points.mass, points.volume, state.strain_energy), start + q)
            expect(
                index, (ZERO_VECTOR, ZERO_VECTOR, NO_STRESS), (points.velocity, state.plane_stress, points.stress), start + q
            )
        p = place_of(index, start + q)
        mx, my, mz = take(ZERO_VECTOR, c, q + (FRAME + 6) * WIDTH)
        nx = ny = nz = area = 0.0
        for t in range(uintp(first[p]), uintp(first[p + uintp(1)])):
            k = uintp(4) * uintp(triangle[t])
            cx, cy, cz = normals[k], normals[k + uintp(1)], normals[k + uintp(2)]
            area += normals[k + uintp(3)]
            if upright(damage, cx * mx + cy * my + cz * mz):
                nx += cx
                ny += cy
                nz += cz
        put(c, q + NORMALS * WIDTH, (nx, ny, nz, 1.0 / 3.0 * area))
    # not one loop: a processor works on several rounds of a short one at once, and waits for roots and quotients in a long one
    for q in range(n):
        L, frame = take((IDENTITY, IDENTITY), c, q + GRADIENT * WIDTH)
        put(c, q + STRETCHING * WIDTH, in_frame(L, frame))
    for q in range(n):
        frame, normals = take((IDENTITY, ZERO_VECTOR), c, q + FRAME * WIDTH)
        tangent, normal, cosine = turned(damage, normals, frame)
        put(c, q + FRAME * WIDTH, tangent)
        put(c, q + NORMALS * WIDTH, normal)
        put(c, q + COSINE * WIDTH, cosine)
    for q in range(n):
        L, tangent = take((IDENTITY, ZERO_VECTOR), c, q + GRADIENT * WIDTH)
        normal = take(ZERO_VECTOR, c, q + NORMALS * WIDTH)
        frame, D = spun(L, take(ZERO_VECTOR, c, q + STRETCHING * WIDTH), tangent, normal, dt)
        put(c, q + FRAME * WIDTH, frame)
        put(c, q + STRETCHING * WIDTH, D)
    for q in range(n):
        before, bears, D = take((NO_SHAPE, 0.0, ZERO_VECTOR), c, q + SHAPE * WIDTH)
        after = stretched(law, before, D, dt)
        shape = after if bears > 0.0 else before
        put(c, q + SHAPE * WIDTH, shape)
        put(c, q + STRAIN * WIDTH, driving_strain(damage, law, shape))


@pointwise
def keep_shapes(surface, start, n, c):
    """Copy the new frames and in-plane deformations of a block of n points from the columns of the work array c back to the
    arrays of the points, except for failed points.

    surface: a `StrainedMembrane`; start: first point of the block, in the order of slabs (layers of grid cells).
    """
    index, state, whole = surface.index, surface.state, all_bear(c, n)
    keep_where(BEARS, whole, index, IDENTITY, state.frame, start, n, c, FRAME * WIDTH)
    keep_where(BEARS, whole, index, NO_SHAPE, state.in_plane, start, n, c, SHAPE * WIDTH)


@pointwise
def fetch_stresses(surface, start, n, c):
    """Copy the input of the stress update of a block of n points (masses, energies, volumes, stresses, speeds) to the columns
    of the work array c.

    surface: a `StrainedMembrane`; start: first point of the block, in the order of slabs (layers of grid cells).
    """
    index, points, state = surface.index, surface.points, surface.state
    fetch(index, (0.0, 0.0), (points.mass, state.strain_energy), start, n, c, MASS * WIDTH)
    fetch(index, (0.0, ZERO_VECTOR), (points.volume, state.plane_stress), start, n, c, VOLUME * WIDTH)
    fetch(index, ZERO_VECTOR, points.velocity, start, n, c, STRESS * WIDTH)
    for q in range(n):
        x, y, z = take(ZERO_VECTOR, c, q + STRESS * WIDTH)
        c[uintp(q + SPEED * WIDTH)] = sqrt(x * x + y * y + z * z)


@pointwise
def weaken_points(surface, start, n, c):
    """Update the damage of a block of n points from the strains that drive it, which the work array c contains. Writes to
    the columns of c the fraction of the stiffness that remains, and the ratio of this fraction to the fraction before the
    step; both are 0 for failed points.

    surface: a `StrainedMembrane`; start: first point of the block, in the order of slabs (layers of grid cells).
    """
    index, damage, record = surface.index, surface.damage, surface.record
    for q in range(n):
        if c[uintp(q + BEARS * WIDTH)] > 0.0:
            put(c, q + LEFT * WIDTH, weaken(damage, record, place_of(index, start + q), c[uintp(q + STRAIN * WIDTH)]))
        else:
            put(c, q + LEFT * WIDTH, (0.0, 0.0))


@pointwise
def respond_to_shapes(law, lattice, thickness, dt, n, c):
    """Compute volumes, stresses, strain energies and the terms of the step limit of the n points in the columns of the work
    array c.

    law: material law; lattice: cells of the grid; thickness: at rest [m]; dt: time step [s].
    """
    h = lattice.inverse_cell
    for q in range(n):
        share, shape, bears = take((0.0, NO_SHAPE, 0.0), c, q + SHARE * WIDTH)
        m, _, _, before = take((0.0, 0.0, 0.0, 0.0), c, q + MASS * WIDTH)
        s11, s22, s12, ratio = plane_response(law, shape)
        after = share * thickness * ratio
        V = after if bears > 0.0 else before
        density = m / V
        put(c, q + RATIO * WIDTH, (ratio, plane_wave_speed(law, shape, density), plane_diffusivity(law, shape, density)))
        put(c, q + STRESS * WIDTH, (s11, s22, s12))
        put(c, q + VOLUME * WIDTH, V)
    for q in range(n):
        L, frame = take((IDENTITY, IDENTITY), c, q + GRADIENT * WIDTH)
        bears, (E11, E22, E12), cosine = take((0.0, ZERO_VECTOR, 0.0), c, q + BEARS * WIDTH)
        m, energy, speed, V, (o11, o22, o12), left = take((0.0, 0.0, 0.0, 0.0, ZERO_VECTOR, 0.0), c, q + MASS * WIDTH)
        ratio, wave, diffusivity, (s11, s22, s12) = take((0.0, 0.0, 0.0, ZERO_VECTOR), c, q + RATIO * WIDTH)
        s11, s22, s12 = with_viscosity(law, (s11, s22, s12), (E11, E22, E12), ratio)
        s11, s22, s12 = left * s11, left * s22, left * s12
        power = 0.5 * ((o11 + s11) * E11 + (o22 + s22) * E22) + (o12 + s12) * E12
        more = dt * power * V / m
        energy += more if bears > 0.0 else 0.0
        stress = in_space((s11, s22, s12), frame)
        new_power = V * end_stress_power(stress, L, dt)
        magnitude = abs(s11 + s22 + s12 + wave + frame[6] + frame[7] + frame[8])
        magnitude = speed + (magnitude if bears > 0.0 else 0.0)
        bad = 1.0 if cosine < -0.999 else 0.0
        bad = 1.0 if ratio <= 0.0 else bad
        bad = bad if bears > 0.0 else 0.0
        bad = bad if magnitude < inf else 1.0
        fastest = fastest_wave(wave, principal_tension(s11, s22, s12), m / V)
        spread = h * h * diffusivity
        spread = spread if bears > 0.0 else 0.0
        rate = damped_rate(law, h * (fastest + speed), spread)
        sums = bad, m * energy, new_power if bears > 0.0 else 0.0
        put(c, q + ENERGY * WIDTH, energy)
        put(c, q + PLANE_STRESS * WIDTH, (s11, s22, s12))
        put(c, q + STRESS * WIDTH, (stress, magnitude, sums, rate))


@pointwise
def fault_in(c, q):
    """Return the fault code (see `pellucid.grid.points`) of point q of a block, from the columns of the work array c."""
    if c[uintp(q + BEARS * WIDTH)] > 0.0:
        if c[uintp(q + COSINE * WIDTH)] < -0.999:
            return FOLDED
        if c[uintp(q + RATIO * WIDTH)] <= 0.0:
            return INVERTED
    return OK if c[uintp(q + MAGNITUDE * WIDTH)] < inf else NOT_FINITE


@pointwise
def keep_stresses(surface, dt, start, n, c):
    """Copy the new volumes, stresses and strain energies of a block of n points from the columns of the work array c back to
    the arrays of the points, and add the energy dissipated in the step dt [s]; failed points are left out.

    surface: a `StrainedMembrane`; start: first point of the block, in the order of slabs (layers of grid cells).
    """
    index, damage, record, points, state = surface.index, surface.damage, surface.record, surface.points, surface.state
    law = surface.law
    of_plane, whole = (points.volume, state.plane_stress), all_bear(c, n)
    keep_where(BEARS, whole, index, 0.0, state.strain_energy, start, n, c, ENERGY * WIDTH)
    keep_where(BEARS, whole, index, (0.0, ZERO_VECTOR), of_plane, start, n, c, VOLUME * WIDTH)
    keep_where(BEARS, whole, index, NO_STRESS, points.stress, start, n, c, STRESS * WIDTH)
    for q in range(n):
        if c[uintp(q + BEARS * WIDTH)] > 0.0:
            p = place_of(index, start + q)
            share = dt * c[uintp(q + LEFT * WIDTH)] * c[uintp(q + VOLUME * WIDTH)] / c[uintp(q + MASS * WIDTH)]
            D = take(ZERO_VECTOR, c, q + STRETCHING * WIDTH)
            record_loss(law, record.dissipated_energy, p, D, c[uintp(q + RATIO * WIDTH)], share)
            work, kept = c[uintp(q + ENERGY * WIDTH)], c[uintp(q + KEPT * WIDTH)]
            dissipate(damage, record, p, work, kept)
