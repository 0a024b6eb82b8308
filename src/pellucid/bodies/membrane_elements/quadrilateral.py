"""What happens to one quadrilateral in a step (Lian, Liu & Zhang 2014, section 4); inlined into the loops over elements.

It has one point, at its centre. Its strain rate there counts the warping across the plane in the mean over the element,
(∂w/∂x ∂ẇ/∂y) with w = η₃ ξη/4: a sheet that is under tension then resists warping as a fully integrated element would, and one
that is pushed together warps, which the strain at the centre leaves out.

`surface` is the bundle of `pellucid.bodies.membrane_elements.strain`.
"""

from math import inf, sqrt

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
from pellucid.jit import kernel
from pellucid.materials.membrane import plane_response, plane_wave_speed, stretched_midway


@kernel(inline=True)
def strain_quadrilateral(surface, x, v, e, dt):
    """New shape, stress and energies; strain and hourglass energy [J], half its largest eigenfrequency [1/s], fault."""
    corners, law, control, initial, state = surface.corners, surface.law, surface.control, surface.thickness, surface.state
    half = 0.5 * dt
    now, moving = spans(x, corners, e), spans(v, corners, e)
    midway = middle(now, moving, half)
    frame = frame_of(midway[0], midway[1])
    here, change = within(frame, midway), within(frame, moving)
    L = gradient(here, change)
    D = (L[0], L[3], 0.5 * (L[1] + L[2]))
    bend = here[2]
    b = steepness(here)
    warping = bend[2] * (change[2][2] - bend[0] * L[4] - bend[1] * L[5]) / 12.0
    D = (D[0] + b[0] * warping, D[1] + b[1] * warping, D[2] + b[2] * warping)
    z = (state.turn[e, 0], state.turn[e, 1])
    mid, end = turned(z, here, change, 0.5 * (L[2] - L[1]), half)
    E = rotated(D, mid[0], -mid[1])
    s = state.shape
    shape = stretched_midway(law, (s[e, 0], s[e, 1], s[e, 2], s[e, 3]), E, dt)
    s11, s22, s12, ratio = plane_response(law, shape)
    area, bound = size_of(now)
    volume = area * initial * ratio
    old, V = state.plane_stress, state.volume[e]
    state.strain_energy[e] += half * (
        (V * old[e, 0] + volume * s11) * E[0]
        + (V * old[e, 1] + volume * s22) * E[1]
        + 2.0 * (V * old[e, 2] + volume * s12) * E[2]
    )
    m = state.element_mass[e]
    wave = plane_wave_speed(law, shape, m / volume)
    Q = state.hourglass
    q1 = 0.25 * (change[2][0] - bend[0] * L[0] - bend[1] * L[1] + bend[2] * L[4])
    q2 = 0.25 * (change[2][1] - bend[0] * L[2] - bend[1] * L[3] + bend[2] * L[5])
    Q1 = resisted(control, Q[e, 0], q1, dt, m * wave * wave * bound, m * wave * sqrt(bound))
    Q2 = resisted(control, Q[e, 1], q2, dt, m * wave * wave * bound, m * wave * sqrt(bound))
    state.hourglass_energy[e] += half * ((Q[e, 0] + Q1) * q1 + (Q[e, 1] + Q2) * q2)
    Q[e, 0], Q[e, 1] = Q1, Q2
    for d in range(4):
        s[e, d] = shape[d]
    old[e, 0], old[e, 1], old[e, 2] = s11, s22, s12
    state.turn[e, 0], state.turn[e, 1] = end
    state.thickness[e], state.volume[e] = initial * ratio, volume
    tension = 0.5 * (s11 + s22) + sqrt(0.25 * (s11 - s22) * (s11 - s22) + s12 * s12)
    signal = sqrt(bound * (wave * wave + max(tension, 0.0) * volume / m))
    wrong = OK
    if _turn_of(here, change, -half) <= 0.0 or _turn_of(here, change, half) <= 0.0 or ratio <= 0.0:
        wrong = COLLAPSED
    elif not abs(s11 + s22 + s12 + signal + volume) < inf:
        wrong = NOT_FINITE
    return state.strain_energy[e], state.hourglass_energy[e], signal, wrong


@kernel(inline=True)
def _turn_of(here, change, dt):
    """χ × ψ along the normal at the middle of the step, after `dt`."""
    c, p, cr, pr = here[0], here[1], change[0], change[1]
    return (c[0] + dt * cr[0]) * (p[1] + dt * pr[1]) - (c[1] + dt * cr[1]) * (p[0] + dt * pr[0])


@kernel(inline=True)
def quadrilateral_forces(surface, x, forces, e):
    """Forces of stress and hourglass control on its corners [N] into forces[e]."""
    corners, state = surface.corners, surface.state
    now = spans(x, corners, e)
    frame = frame_of(now[0], now[1])
    here = within(frame, now)
    old = state.plane_stress
    s = rotated((old[e, 0], old[e, 1], old[e, 2]), state.turn[e, 0], state.turn[e, 1])
    V, bend = state.volume[e], here[2]
    # what works on the six components of the gradient, and on the rate of η
    P11, P12, P21, P22 = V * s[0], V * s[2], V * s[2], V * s[1]
    b = steepness(here)
    tension = V * (s[0] * b[0] + s[1] * b[1] + 2.0 * s[2] * b[2]) * bend[2] / 12.0
    H1, H2, H3 = 0.25 * state.hourglass[e, 0], 0.25 * state.hourglass[e, 1], tension
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
    for d in range(3):
        X = frame[0][d] * chi[0] + frame[1][d] * chi[1] + frame[2][d] * chi[2]
        Y = frame[0][d] * psi[0] + frame[1][d] * psi[1] + frame[2][d] * psi[2]
        H = frame[0][d] * H1 + frame[1][d] * H2 + frame[2][d] * H3
        forces[e, 0, d] = X + Y - H
        forces[e, 1, d] = Y - X + H
        forces[e, 2, d] = -X - Y - H
        forces[e, 3, d] = X - Y + H


@kernel(inline=True)
def press_quadrilateral(surface, x, forces, e, pressure):
    """∫ p N_K n dA on its corners [N] into forces[e], exact for the bilinear surface."""
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
    """Its Cauchy stress, components xx, yy, zz, yz, xz, xy [Pa], into stress[e]."""
    corners, state = surface.corners, surface.state
    old = state.plane_stress
    chi, psi, _ = spans(x, corners, e)
    t, u, _ = frame_of(chi, psi)
    s = rotated((old[e, 0], old[e, 1], old[e, 2]), state.turn[e, 0], state.turn[e, 1])
    whole = in_space(s, t, u)
    for d in range(6):
        stress[e, d] = whole[d]
