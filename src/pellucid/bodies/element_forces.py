"""Nodal forces of membrane elements: stress, hourglass control, pressure.

`surface` is the bundle of `pellucid.bodies.element_kernels`. Kernels over elements write the forces on their corners, and a
kernel over nodes adds them up in a fixed order: no atomics, the same bits on any number of threads.
"""

from numba import prange

from pellucid.bodies.element_geometry import cross, frame_of, rotated, spans, steepness, within
from pellucid.bodies.element_kernels import CHUNK
from pellucid.jit import kernel


@kernel()
def _force_chunk(surface, x, forces, chunk):
    corners, n_quads, _, _, _, carried = surface.content
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(corners))):
        quad = e < n_quads
        now = spans(x, corners, e, quad)
        frame = frame_of(now[0], now[1])
        here = within(frame, now)
        old = carried.plane_stress
        s = rotated((old[e, 0], old[e, 1], old[e, 2]), carried.turn[e, 0], carried.turn[e, 1])
        V, bend = carried.volume[e], here[2]
        # what works on the six components of the gradient, and on the rate of η
        P11, P12, P21, P22 = V * s[0], V * s[2], V * s[2], V * s[1]
        P31 = P32 = H1 = H2 = H3 = 0.0
        if quad:
            b = steepness(here)
            tension = V * (s[0] * b[0] + s[1] * b[1] + 2.0 * s[2] * b[2]) * bend[2] / 12.0
            H1, H2, H3 = 0.25 * carried.hourglass[e, 0], 0.25 * carried.hourglass[e, 1], tension
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
            if quad:
                forces[e, 0, d] = X + Y - H
                forces[e, 1, d] = Y - X + H
                forces[e, 2, d] = -X - Y - H
                forces[e, 3, d] = X - Y + H
            else:
                forces[e, 0, d] = X + Y
                forces[e, 1, d] = -X
                forces[e, 2, d] = -Y


@kernel(parallel=True)
def internal_forces(chunks, surface, x, forces):
    """Forces of stress and hourglass control on the corners of each element [N], shape (m, 4, 3)."""
    for chunk in prange(chunks):
        _force_chunk(surface, x, forces, chunk)


@kernel()
def _press_chunk(surface, x, forces, chunk, pressure):
    corners, n_quads, _, _, _, _ = surface.content
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(corners))):
        quad = e < n_quads
        chi, psi, eta = spans(x, corners, e, quad)
        whole = cross(chi, psi)
        if quad:
            # with x = ¼ (χ ξ + ψ ζ + η ξζ) the normal ∂x/∂ξ × ∂x/∂ζ is linear in ξ and ζ, and the integrals are exact
            along, across = cross(chi, eta), cross(eta, psi)
            for d in range(3):
                a, b, c = pressure * whole[d] / 16.0, pressure * along[d] / 48.0, pressure * across[d] / 48.0
                forces[e, 0, d] = a - b - c
                forces[e, 1, d] = a + b - c
                forces[e, 2, d] = a + b + c
                forces[e, 3, d] = a - b + c
        else:
            for d in range(3):
                share = pressure * whole[d] / 6.0
                forces[e, 0, d] = forces[e, 1, d] = forces[e, 2, d] = share


@kernel(parallel=True)
def pressure_forces(chunks, surface, x, forces, pressure):
    """∫ p N_K n dA on the corners of each element [N], shape (m, 4, 3), exact for bilinear and linear surfaces."""
    for chunk in prange(chunks):
        _press_chunk(surface, x, forces, chunk, pressure)


@kernel()
def _add_slab(about, corner_values, target, s):
    slabs, number, fan = about.content
    for p in range(slabs.first[s], slabs.first[s + 1]):
        K = number[p]
        for t in range(fan.start[K], fan.start[K + 1]):
            place = fan.places[t]
            for d in range(3):
                target[p, d] += corner_values[place, d]


@kernel(parallel=True)
def add_corners(n, about, corner_values, target):
    """Add the values at the corners about each node of n slabs, shape (4 m, 3), to `target`, shape (nodes, 3).

    about: the bundle (slabs, numbers of the nodes, `Fan`).
    """
    for s in prange(n):
        _add_slab(about, corner_values, target, s)


@kernel()
def _stress_chunk(surface, x, stress, chunk):
    corners, n_quads, _, _, _, carried = surface.content
    old = carried.plane_stress
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(corners))):
        chi, psi, _ = spans(x, corners, e, e < n_quads)
        t, u, _ = frame_of(chi, psi)
        s = rotated((old[e, 0], old[e, 1], old[e, 2]), carried.turn[e, 0], carried.turn[e, 1])
        stress[e, 0] = s[0] * t[0] * t[0] + s[1] * u[0] * u[0] + 2.0 * s[2] * t[0] * u[0]
        stress[e, 1] = s[0] * t[1] * t[1] + s[1] * u[1] * u[1] + 2.0 * s[2] * t[1] * u[1]
        stress[e, 2] = s[0] * t[2] * t[2] + s[1] * u[2] * u[2] + 2.0 * s[2] * t[2] * u[2]
        stress[e, 3] = s[0] * t[1] * t[2] + s[1] * u[1] * u[2] + s[2] * (t[1] * u[2] + t[2] * u[1])
        stress[e, 4] = s[0] * t[0] * t[2] + s[1] * u[0] * u[2] + s[2] * (t[0] * u[2] + t[2] * u[0])
        stress[e, 5] = s[0] * t[0] * t[1] + s[1] * u[0] * u[1] + s[2] * (t[0] * u[1] + t[1] * u[0])


@kernel(parallel=True)
def cauchy_stresses(chunks, surface, x, stress):
    """Stresses of the elements, components xx, yy, zz, yz, xz, xy [Pa], shape (m, 6)."""
    for chunk in prange(chunks):
        _stress_chunk(surface, x, stress, chunk)
