"""Membrane points in blocks: what straining needs of them is fetched into columns, and what it finds is brought back.

Loops that write nothing but columns become vectors. Failed points go through them as the others do, and nothing is brought back
to them; damage has its records, which are kept point by point.
"""

from math import inf, sqrt

from numpy import uintp

from pellucid.bodies.membrane_points.point import in_frame, in_space, spun, turned
from pellucid.grid.points import FOLDED, INVERTED, NOT_FINITE, OK, place_of
from pellucid.jit import pointwise
from pellucid.jit.columns import WIDTH, put, take
from pellucid.materials.damage import dissipate, driving_strain, has_failed, upright, weaken
from pellucid.materials.membrane import plane_diffusivity, plane_response, plane_wave_speed, stretched
from pellucid.tensors import IDENTITY, NO_STRESS, ZERO_VECTOR, end_stress_power

NO_SHAPE = (0.0, 0.0, 0.0, 0.0)
# columns of a block: velocity gradient, frame, sum of the normals about a point, share of area, shape, 1 where it bears stress,
# stretching, cosine of its old normal with the new, the strain that drives damage
GRADIENT, FRAME, NORMALS, SHARE, SHAPE, BEARS, STRETCHING, COSINE, STRAIN = 0, 9, 18, 21, 22, 26, 27, 30, 31
# mass, strain energy, speed, volume, stress in the frame, shares of the stiffness left and kept, what the law says
MASS, ENERGY, VOLUME, PLANE_STRESS, LEFT, KEPT, RATIO = 32, 33, 35, 36, 39, 40, 41
# stress in space; what tells faults; bad points, STORED and POWER, and the fastest signal
STRESS, MAGNITUDE, BAD, FASTEST, COLUMNS = 44, 50, 51, 54, 55
SUMS = 3  # from BAD on


@pointwise
def fetch_shapes(surface, start, n, c):
    """Frames and shapes of the n points that slabs count from `start` on, and the gradients that strain them."""
    index, damage, record, gradient = surface.index, surface.damage, surface.record, surface.gradient
    frame, shape = surface.state.frame, surface.state.in_plane
    for q in range(n):
        p = place_of(index, start + q)
        g, t, f = gradient[p], frame[p], shape[p]
        L, Q = (g[0], g[1], g[2], g[3], g[4], g[5], g[6], g[7], g[8]), (t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8])
        put(c, q + GRADIENT * WIDTH, (L, Q))
        put(c, q + SHAPE * WIDTH, (f[0], f[1], f[2], f[3], 0.0 if has_failed(damage, record, p) else 1.0))


@pointwise
def turn_and_stretch(surface, dt, start, n, c):
    """New frames and shapes, from the moved triangles and the gradients, and the strains that drive damage."""
    index, law, damage = surface.index, surface.law, surface.damage
    first, triangle, normals = surface.fans.start, surface.fans.triangle, surface.fans.normals
    for q in range(n):
        p = place_of(index, start + q)
        mx, my, mz = take(ZERO_VECTOR, c, q + (FRAME + 6) * WIDTH)
        nx = ny = nz = area = 0.0
        for t in range(uintp(first[p]), uintp(first[p + uintp(1)])):
            k = uintp(triangle[t])
            cx, cy, cz = normals[k, 0], normals[k, 1], normals[k, 2]
            area += normals[k, 3]
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
    """Bring the frames and shapes back."""
    index, frame, shape = surface.index, surface.state.frame, surface.state.in_plane
    for q in range(n):
        if c[uintp(q + BEARS * WIDTH)] > 0.0:
            p = place_of(index, start + q)
            Q, F = take(IDENTITY, c, q + FRAME * WIDTH), take(NO_SHAPE, c, q + SHAPE * WIDTH)
            for d in range(9):
                frame[p, d] = Q[d]
            for d in range(4):
                shape[p, d] = F[d]


@pointwise
def fetch_stresses(surface, start, n, c):
    """What the points had before their stresses are found."""
    index, points = surface.index, surface.points
    v, energy, old = points.velocity, surface.state.strain_energy, surface.state.plane_stress
    for q in range(n):
        p = place_of(index, start + q)
        speed = sqrt(v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2])
        put(c, q + MASS * WIDTH, (points.mass[p], energy[p], speed, points.volume[p], (old[p, 0], old[p, 1], old[p, 2])))


@pointwise
def weaken_points(surface, start, n, c):
    """Damage by the strains that drive it: the shares of the stiffness left, and kept of what there was."""
    index, damage, record = surface.index, surface.damage, surface.record
    for q in range(n):
        if c[uintp(q + BEARS * WIDTH)] > 0.0:
            put(c, q + LEFT * WIDTH, weaken(damage, record, place_of(index, start + q), c[uintp(q + STRAIN * WIDTH)]))


@pointwise
def respond_to_shapes(law, lattice, thickness, dt, n, c):
    """Volumes and stresses, strain energies and what bounds the step."""
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
        rate, viscous = h * (wave + speed), 2.0 * h * h * diffusivity
        viscous = viscous if bears > 0.0 else 0.0
        sums = bad, m * energy, new_power if bears > 0.0 else 0.0
        put(c, q + ENERGY * WIDTH, energy)
        put(c, q + PLANE_STRESS * WIDTH, (s11, s22, s12))
        put(c, q + STRESS * WIDTH, (stress, magnitude, sums, rate if rate > viscous else viscous))


@pointwise
def fault_in(c, q):
    """What is wrong with point q of a block."""
    if c[uintp(q + BEARS * WIDTH)] > 0.0:
        if c[uintp(q + COSINE * WIDTH)] < -0.999:
            return FOLDED
        if c[uintp(q + RATIO * WIDTH)] <= 0.0:
            return INVERTED
    return OK if c[uintp(q + MAGNITUDE * WIDTH)] < inf else NOT_FINITE


@pointwise
def keep_stresses(surface, start, n, c):
    """Bring volumes, stresses and energies back."""
    index, damage, record, points = surface.index, surface.damage, surface.record, surface.points
    volume, stress, energy, in_plane = points.volume, points.stress, surface.state.strain_energy, surface.state.plane_stress
    for q in range(n):
        if c[uintp(q + BEARS * WIDTH)] > 0.0:
            p = place_of(index, start + q)
            new, work = take(NO_STRESS, c, q + STRESS * WIDTH), c[uintp(q + ENERGY * WIDTH)]
            for d in range(6):
                stress[p, d] = new[d]
            in_plane[p, 0], in_plane[p, 1], in_plane[p, 2] = take(ZERO_VECTOR, c, q + PLANE_STRESS * WIDTH)
            volume[p] = c[uintp(q + VOLUME * WIDTH)]
            energy[p] = work
            dissipate(damage, record, p, work, c[uintp(q + KEPT * WIDTH)])
