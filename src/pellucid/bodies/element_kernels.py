"""Straining of membrane elements (Lian, Liu & Zhang 2014, section 4, with the misprints put right).

Quadrilaterals have one point, at their centre. Their strain rate there counts the warping across the plane in the mean over the
element, (∂w/∂x ∂ẇ/∂y) with w = η₃ ξη/4: a sheet that is under tension then resists warping as a fully integrated element would,
and one that is pushed together warps, which the centre alone does not see.

`surface` is the bundle (corners, number of quadrilaterals, law, hourglass control, initial thickness, `ElementArrays`).
Elements are shared out in chunks whose number does not depend on the threads.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from numba import prange

from pellucid.bodies.element_geometry import frame_of, gradient, middle, rotated, size_of, spans, steepness, turned, within
from pellucid.bodies.hourglass import resisted
from pellucid.grid.points import COLLAPSED, NOT_FINITE, OK
from pellucid.jit import kernel
from pellucid.materials.membrane import plane_response, plane_wave_speed, stretched_midway

CHUNK = 512
STRAIN, HOURGLASS, RATE, SUMS = range(4)  # columns of the sums of a chunk


class ElementArrays(NamedTuple):
    """What elements carry; m elements, quadrilaterals first, in the order of the mesh."""

    element_mass: np.ndarray  # (m,) [kg]
    shape: np.ndarray  # (m, 4) in-plane shape in the material's frame, the law's own
    turn: np.ndarray  # (m, 2) cosine and sine of the angle from the element's frame to the material's
    plane_stress: np.ndarray  # (m, 3) σ₁₁, σ₂₂, σ₁₂ in the material's frame [Pa]
    thickness: np.ndarray  # (m,) [m]
    volume: np.ndarray  # (m,) [m³]
    strain_energy: np.ndarray  # (m,) work of the stress [J]
    hourglass: np.ndarray  # (m, 2) hourglass force Q in the element's frame [N]
    hourglass_energy: np.ndarray  # (m,) work against hourglass forces [J]


@kernel()
def _strain_chunk(surface, x, v, sums, fault, chunk, dt):
    corners, n_quads, law, control, initial, carried = surface.content
    half = 0.5 * dt
    strain_energy = hourglass_energy = rate = 0.0
    first_fault = at_fault = 0
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(corners))):
        quad = e < n_quads
        now, moving = spans(x, corners, e, quad), spans(v, corners, e, quad)
        midway = middle(now, moving, half)
        frame = frame_of(midway[0], midway[1])
        here, change = within(frame, midway), within(frame, moving)
        L = gradient(here, change)
        D = (L[0], L[3], 0.5 * (L[1] + L[2]))
        bend = here[2]
        if quad:
            b = steepness(here)
            warping = bend[2] * (change[2][2] - bend[0] * L[4] - bend[1] * L[5]) / 12.0
            D = (D[0] + b[0] * warping, D[1] + b[1] * warping, D[2] + b[2] * warping)
        z = (carried.turn[e, 0], carried.turn[e, 1])
        mid, end = turned(z, here, change, 0.5 * (L[2] - L[1]), half)
        E = rotated(D, mid[0], -mid[1])
        s = carried.shape
        shape = stretched_midway(law, (s[e, 0], s[e, 1], s[e, 2], s[e, 3]), E, dt)
        s11, s22, s12, ratio = plane_response(law, shape)
        area, bound = size_of(now, quad)
        volume = area * initial * ratio
        old, V = carried.plane_stress, carried.volume[e]
        carried.strain_energy[e] += half * (
            (V * old[e, 0] + volume * s11) * E[0]
            + (V * old[e, 1] + volume * s22) * E[1]
            + 2.0 * (V * old[e, 2] + volume * s12) * E[2]
        )
        m = carried.element_mass[e]
        wave = plane_wave_speed(law, shape, m / volume)
        if quad:
            Q = carried.hourglass
            q1 = 0.25 * (change[2][0] - bend[0] * L[0] - bend[1] * L[1] + bend[2] * L[4])
            q2 = 0.25 * (change[2][1] - bend[0] * L[2] - bend[1] * L[3] + bend[2] * L[5])
            Q1 = resisted(control, Q[e, 0], q1, dt, m * wave * wave * bound, m * wave * sqrt(bound))
            Q2 = resisted(control, Q[e, 1], q2, dt, m * wave * wave * bound, m * wave * sqrt(bound))
            carried.hourglass_energy[e] += half * ((Q[e, 0] + Q1) * q1 + (Q[e, 1] + Q2) * q2)
            Q[e, 0], Q[e, 1] = Q1, Q2
        for d in range(4):
            s[e, d] = shape[d]
        old[e, 0], old[e, 1], old[e, 2] = s11, s22, s12
        carried.turn[e, 0], carried.turn[e, 1] = end
        carried.thickness[e], carried.volume[e] = initial * ratio, volume
        tension = 0.5 * (s11 + s22) + sqrt(0.25 * (s11 - s22) * (s11 - s22) + s12 * s12)
        signal = sqrt(bound * (wave * wave + max(tension, 0.0) * volume / m))
        strain_energy += carried.strain_energy[e]
        hourglass_energy += carried.hourglass_energy[e]
        rate = max(rate, signal)
        wrong = OK
        before = _turn_of(here, change, -half)
        after = _turn_of(here, change, half)
        if before <= 0.0 or after <= 0.0 or ratio <= 0.0:
            wrong = COLLAPSED
        elif not abs(s11 + s22 + s12 + signal + volume) < inf:
            wrong = NOT_FINITE
        if wrong != OK and first_fault == OK:
            first_fault = wrong
            at_fault = e
    sums[chunk, STRAIN], sums[chunk, HOURGLASS], sums[chunk, RATE] = strain_energy, hourglass_energy, rate
    fault[chunk, 0], fault[chunk, 1] = first_fault, at_fault


@kernel(inline=True)
def _turn_of(here, change, dt):
    """χ × ψ along the normal at the middle of the step, after `dt`."""
    c, p, cr, pr = here[0], here[1], change[0], change[1]
    return (c[0] + dt * cr[0]) * (p[1] + dt * pr[1]) - (c[1] + dt * cr[1]) * (p[0] + dt * pr[0])


@kernel(parallel=True)
def strain(chunks, surface, x, v, sums, fault, dt):
    """Shapes, stresses and energies of the elements whose nodes moved to x with velocities v over the step."""
    for chunk in prange(chunks):
        _strain_chunk(surface, x, v, sums, fault, chunk, dt)
