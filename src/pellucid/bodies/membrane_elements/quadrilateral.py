"""Strains, stresses and forces of quadrilaterals in a step (Lian, Liu & Zhang 2014, section 4), by blocks of elements.

Each has one quadrature point, at its centre. Its strain rate includes the average warping rate over the element, (∂w/∂x
∂ẇ/∂y) with w = η₃ ξη/4. A sheet under tension then resists warping like a fully integrated element; a compressed sheet
warps, which does not change the strain at the centre. Element data of a block are copied into columns; loops that write
only to columns are vectorized. `surface` holds the data of `StrainedElements`.
"""

from math import inf, sqrt

from numpy import uintp

from pellucid.bodies.membrane_elements.geometry import (
    cross,
    frame_of,
    gradient,
    in_space,
    middle,
    rotated,
    size_of,
    spans,
    steepness,
    turned,
    within,
)
from pellucid.bodies.membrane_elements.hourglass import resisted
from pellucid.grid.points import COLLAPSED, NOT_FINITE, OK
from pellucid.jit import kernel, pointwise
from pellucid.jit.columns import WIDTH, put, take
from pellucid.materials.membrane import (
    damped_rate,
    plane_diffusivity,
    plane_response,
    plane_wave_speed,
    principal_tension,
    record_loss,
    stretched_midway,
    with_viscosity,
)
from pellucid.tensors import ZERO_VECTOR

SPANS = ZERO_VECTOR, ZERO_VECTOR, ZERO_VECTOR
PAIR = 0.0, 0.0
SHAPE_LIKE = 0.0, 0.0, 0.0, 0.0
GRADIENT_LIKE = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
# columns of a block: χ, ψ, η and their rates, first in space, then in the element's frame
NOW, MOVING = 0, 9
# rotation of the material (cosine, sine), shape, stress; volume, mass, energies, hourglass forces
TURN, SHAPE, STRESS, VOLUME, MASS, ENERGY, HOURGLASS, WARPED = 18, 20, 24, 27, 28, 29, 30, 32
# in-plane velocity gradient, rate of deformation in the material's frame; area, (ω/2c)², thickness ratio, wave speed
GRADIENT, RATE, AREA, BOUND, RATIO, WAVE = 33, 39, 42, 43, 44, 45
# values that indicate faults; number of faults and both energies again, for sums; half the largest eigenfrequency
TURNED_OVER, MAGNITUDE, BAD, SIGNAL, COLUMNS = 46, 47, 48, 51, 52
SUMS = 3  # number of summed columns, from BAD on
GIVEN = 14  # in the columns for forces: first column of volume and hourglass forces, after spans, rotation and stress


@pointwise
def strain_quadrilaterals(surface, x, v, first, n, dt, c):
    """Compute the new geometry, stresses and energies of n quadrilaterals, starting with element `first`, in the columns of the
    work array `c`, one row per element. The caller sums the last SUMS columns, from BAD on (number of faults, energies), over
    the elements.

    surface: data of `StrainedElements`; x, v: nodal positions [m] and velocities [m/s], shape (n, 3); dt: time step [s].
    """
    _fetch(surface, x, v, first, n, c)
    _find_rates(n, dt, c)
    _respond(surface.law, surface.control, surface.thickness, n, dt, c)
    _keep(surface.law, surface.state, surface.thickness, first, n, dt, c)


@pointwise
def _fetch(surface, x, v, first, n, c):
    corners, state = surface.corners, surface.state
    turn, shape, stress, Q = state.turn, state.shape, state.plane_stress, state.hourglass
    for q in range(n):
        e = uintp(first + q)
        put(c, q + NOW * WIDTH, (spans(x, corners, e), spans(v, corners, e)))
        put(c, q + TURN * WIDTH, ((turn[e, 0], turn[e, 1]), (shape[e, 0], shape[e, 1], shape[e, 2], shape[e, 3])))
        put(c, q + STRESS * WIDTH, ((stress[e, 0], stress[e, 1], stress[e, 2]), state.volume[e], state.element_mass[e]))
        put(c, q + ENERGY * WIDTH, (state.strain_energy[e], (Q[e, 0], Q[e, 1]), state.hourglass_energy[e]))


@pointwise
def _find_rates(n, dt, c):
    """Compute the velocity gradients, rates of deformation and rotations of n quadrilaterals at the middle of the step dt
    [s], and their tangents χ, ψ and hourglass vectors η in the frame at the middle of the step; all in the columns of the
    work array c."""
    half = 0.5 * dt
    for q in range(n):
        now, moving = take((SPANS, SPANS), c, q + NOW * WIDTH)
        midway = middle(now, moving, half)
        frame = frame_of(midway[0], midway[1])
        put(c, q + AREA * WIDTH, size_of(now))
        put(c, q + NOW * WIDTH, (within(frame, midway), within(frame, moving)))
    for q in range(n):
        here, change, z = take((SPANS, SPANS, PAIR), c, q + NOW * WIDTH)
        L, b, bend = gradient(here, change), steepness(here), here[2]
        warping = bend[2] * (change[2][2] - bend[0] * L[4] - bend[1] * L[5]) / 12.0
        D = (L[0] + b[0] * warping, L[3] + b[1] * warping, 0.5 * (L[1] + L[2]) + b[2] * warping)
        mid, end = turned(z, here, change, 0.5 * (L[2] - L[1]), half)
        before, after = _turn_of(here, change, -half), _turn_of(here, change, half)
        over = 0.0 if before > 0.0 else 1.0
        put(c, q + GRADIENT * WIDTH, (L, rotated(D, mid[0], -mid[1])))
        put(c, q + TURN * WIDTH, end)
        put(c, q + TURNED_OVER * WIDTH, over if after > 0.0 else 1.0)


@pointwise
def _turn_of(here, change, dt):
    """Return the component of χ × ψ along the normal of a quadrilateral [m²]; negative if the element turned over. Normal
    and frame are those at the middle of the step; χ and ψ are taken at a time `dt` [s] after (negative: before) the middle.

    here, change: tangents χ, ψ and hourglass vector η [m] and their rates [m/s] at the middle of the step, in the frame of
    the element.
    """
    c, p, cr, pr = here[0], here[1], change[0], change[1]
    return (c[0] + dt * cr[0]) * (p[1] + dt * pr[1]) - (c[1] + dt * cr[1]) * (p[0] + dt * pr[0])


@pointwise
def _respond(law, control, thickness, n, dt, c):
    """Compute in-plane deformations, stresses, hourglass forces, energies and the terms of the step limit of the n elements in
    the columns of the work array c.

    law: material law; control: hourglass control; thickness: at rest [m]; dt: time step [s].
    """
    half = 0.5 * dt
    for q in range(n):
        E, area = take((ZERO_VECTOR, 0.0), c, q + RATE * WIDTH)
        shape = stretched_midway(law, take(SHAPE_LIKE, c, q + SHAPE * WIDTH), E, dt)
        s11, s22, s12, ratio = plane_response(law, shape)
        s11, s22, s12 = with_viscosity(law, (s11, s22, s12), E, ratio)
        (o11, o22, o12), V, m, energy = take((ZERO_VECTOR, 0.0, 0.0, 0.0), c, q + STRESS * WIDTH)
        volume = area * thickness * ratio
        work = (V * o11 + volume * s11) * E[0] + (V * o22 + volume * s22) * E[1] + 2.0 * (V * o12 + volume * s12) * E[2]
        put(c, q + SHAPE * WIDTH, (shape, (s11, s22, s12), volume, m, energy + half * work))
        put(c, q + RATIO * WIDTH, (ratio, plane_wave_speed(law, shape, m / volume)))
    for q in range(n):
        here, change = take((SPANS, SPANS), c, q + NOW * WIDTH)
        (s11, s22, s12), volume, m, energy, (Q1, Q2), warped = take(
            (ZERO_VECTOR, 0.0, 0.0, 0.0, PAIR, 0.0), c, q + STRESS * WIDTH
        )
        L, _, _, bound, ratio, wave, over = take((GRADIENT_LIKE, ZERO_VECTOR, 0.0, 0.0, 0.0, 0.0, 0.0), c, q + GRADIENT * WIDTH)
        bend, rate = here[2], change[2]
        q1 = 0.25 * (rate[0] - bend[0] * L[0] - bend[1] * L[1] + bend[2] * L[4])
        q2 = 0.25 * (rate[1] - bend[0] * L[2] - bend[1] * L[3] + bend[2] * L[5])
        stiffness, impedance = m * wave * wave * bound, m * wave * sqrt(bound)
        R1 = resisted(control, Q1, q1, dt, stiffness, impedance)
        R2 = resisted(control, Q2, q2, dt, stiffness, impedance)
        warped += half * ((Q1 + R1) * q1 + (Q2 + R2) * q2)
        signal = sqrt(bound * (wave * wave + principal_tension(s11, s22, s12) * volume / m))
        spread = bound * plane_diffusivity(law, take(SHAPE_LIKE, c, q + SHAPE * WIDTH), m / volume)
        signal = damped_rate(law, signal, spread)
        magnitude = abs(s11 + s22 + s12 + signal + volume)
        over = over if ratio > 0.0 else 1.0
        put(c, q + HOURGLASS * WIDTH, ((R1, R2), warped))
        put(c, q + TURNED_OVER * WIDTH, (over, magnitude, over if magnitude < inf else 1.0, energy, warped, signal))


@pointwise
def _keep(law, state, thickness, first, n, dt, c):
    turn, shape, stress, Q = state.turn, state.shape, state.plane_stress, state.hourglass
    for q in range(n):
        e = uintp(first + q)
        z, F, s, V, _, energy, R, warped = take((PAIR, SHAPE_LIKE, ZERO_VECTOR, 0.0, 0.0, 0.0, PAIR, 0.0), c, q + TURN * WIDTH)
        turn[e, 0], turn[e, 1] = z
        for d in range(4):
            shape[e, d] = F[d]
        stress[e, 0], stress[e, 1], stress[e, 2] = s
        Q[e, 0], Q[e, 1] = R
        state.volume[e], state.strain_energy[e], state.hourglass_energy[e] = V, energy, warped
        state.thickness[e] = thickness * c[uintp(q + RATIO * WIDTH)]
        D = take(ZERO_VECTOR, c, q + RATE * WIDTH)
        record_loss(law, state.dissipated_energy, e, D, c[uintp(q + RATIO * WIDTH)], dt * V)


@pointwise
def fault_of(c, q):
    """Return the fault code (see `pellucid.grid.points`) of quadrilateral q of a block, from the columns of the work array
    c.
    """
    if c[uintp(q + TURNED_OVER * WIDTH)] > 0.0:
        return COLLAPSED
    return OK if c[uintp(q + MAGNITUDE * WIDTH)] < inf else NOT_FINITE


@pointwise
def quadrilateral_forces(surface, x, forces, first, n, c):
    """Write the forces of stress and hourglass control on the corners of n quadrilaterals, starting at element `first`, to
    `forces` [N], shape (m, 4, 3).

    surface: data of `StrainedElements`; x: nodal positions [m], shape (n, 3); c: work array.
    """
    corners, state = surface.corners, surface.state
    turn, stress, Q = state.turn, state.plane_stress, state.hourglass
    for q in range(n):
        e = uintp(first + q)
        put(c, q, (spans(x, corners, e), (turn[e, 0], turn[e, 1]), (stress[e, 0], stress[e, 1], stress[e, 2])))
        put(c, q + GIVEN * WIDTH, (state.volume[e], Q[e, 0], Q[e, 1]))
    for q in range(n):
        now, z, s, V, Q1, Q2 = take((SPANS, PAIR, ZERO_VECTOR, 0.0, 0.0, 0.0), c, q)
        put(c, q, _span_forces(now, rotated(s, z[0], z[1]), V, Q1, Q2))
    for q in range(n):
        e = uintp(first + q)
        X, Y, H = take(SPANS, c, q)
        for d in range(3):
            forces[e, 0, d] = X[d] + Y[d] - H[d]
            forces[e, 1, d] = Y[d] - X[d] + H[d]
            forces[e, 2, d] = -X[d] - Y[d] - H[d]
            forces[e, 3, d] = X[d] - Y[d] + H[d]


@pointwise
def _span_forces(now, s, V, Q1, Q2):
    """Return the forces [N], as vectors in space, that are conjugate to the tangents χ, ψ and the hourglass vector η of a
    quadrilateral: their power with the rates of these vectors is the power of stress and hourglass control.

    now: χ, ψ, η [m]; s: stress 11, 22, 12 in the frame of the element [Pa]; V: volume [m³]; Q1, Q2: hourglass forces [N].
    """
    frame = frame_of(now[0], now[1])
    here = within(frame, now)
    bend = here[2]
    # what works on the six components of the gradient, and on the rate of η
    P11, P12, P21, P22 = V * s[0], V * s[2], V * s[2], V * s[1]
    b = steepness(here)
    tension = V * (s[0] * b[0] + s[1] * b[1] + 2.0 * s[2] * b[2]) * bend[2] / 12.0
    H1, H2, H3 = 0.25 * Q1, 0.25 * Q2, tension
    P11 -= H1 * bend[0]
    P12 -= H1 * bend[1]
    P21 -= H2 * bend[0]
    P22 -= H2 * bend[1]
    P31 = H1 * bend[2] - H3 * bend[0]
    P32 = H2 * bend[2] - H3 * bend[1]
    c, p = here[0], here[1]
    inverse = 1.0 / (c[0] * p[1] - c[1] * p[0])
    chi = (
        inverse * (P11 * p[1] - P12 * p[0]),
        inverse * (P21 * p[1] - P22 * p[0]),
        inverse * (P31 * p[1] - P32 * p[0]),
    )
    psi = (
        inverse * (P12 * c[0] - P11 * c[1]),
        inverse * (P22 * c[0] - P21 * c[1]),
        inverse * (P32 * c[0] - P31 * c[1]),
    )
    return _along(frame, chi), _along(frame, psi), _along(frame, (H1, H2, H3))


@pointwise
def _along(frame, a):
    """Return a vector in space, components x, y, z, from its components a in an orthonormal frame."""
    t, u, n = frame
    return (
        t[0] * a[0] + u[0] * a[1] + n[0] * a[2],
        t[1] * a[0] + u[1] * a[1] + n[1] * a[2],
        t[2] * a[0] + u[2] * a[1] + n[2] * a[2],
    )


@kernel(inline=True)
def press_quadrilateral(surface, x, forces, e, pressure):
    """Write the forces ∫ p N_K n dA of a pressure p [Pa] at the corners K of quadrilateral e [N] to forces[e], exact for the
    bilinear surface. surface: data of `StrainedElements`; x: nodal positions [m], shape (n, 3).
    """
    corners = surface.corners
    chi, psi, eta = spans(x, corners, e)
    whole = cross(chi, psi)
    # with x = ¼ (χ ξ + ψ ζ + η ξζ) the normal ∂x/∂ξ × ∂x/∂ζ is linear in ξ and ζ, and the integrals are exact
    along, across = cross(chi, eta), cross(eta, psi)
    for d in range(3):
        a, b, c = pressure * whole[d] / 16.0, pressure * along[d] / 48.0, pressure * across[d] / 48.0
        forces[e, 0, d] = a - b - c
        forces[e, 1, d] = a + b - c
        forces[e, 2, d] = a + b + c
        forces[e, 3, d] = a - b + c


@kernel(inline=True)
def quadrilateral_stress(surface, x, stress, e):
    """Write the Cauchy stress of quadrilateral e, components xx, yy, zz, yz, xz, xy [Pa], to stress[e]. surface: data of
    `StrainedElements`; x: nodal positions [m], shape (n, 3).
    """
    corners, state = surface.corners, surface.state
    old = state.plane_stress
    chi, psi, _ = spans(x, corners, e)
    t, u, _ = frame_of(chi, psi)
    s = rotated((old[e, 0], old[e, 1], old[e, 2]), state.turn[e, 0], state.turn[e, 1])
    whole = in_space(s, t, u)
    for d in range(6):
        stress[e, d] = whole[d]
