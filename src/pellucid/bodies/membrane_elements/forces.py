"""Nodal forces of membrane elements: stress, hourglass control, pressure.

`surface` is the bundle of `pellucid.bodies.membrane_elements.strain`. Kernels over elements write the forces on their corners,
and a kernel over nodes adds them up in a fixed order: no atomics, the same bits on any number of threads.
"""

from numba import prange

from pellucid.bodies.membrane_elements.quadrilateral import press_quadrilateral, quadrilateral_forces, quadrilateral_stress
from pellucid.bodies.membrane_elements.strain import elements_of
from pellucid.bodies.membrane_elements.triangle import press_triangle, triangle_forces, triangle_stress
from pellucid.jit import kernel


@kernel()
def _force_chunk(surface, x, forces, chunk):
    corners, n_quads, _, _, _, _, _ = surface.content
    first, middle, end = elements_of(chunk, n_quads, len(corners))
    for e in range(first, middle):
        quadrilateral_forces(surface, x, forces, e)
    for e in range(middle, end):
        triangle_forces(surface, x, forces, e)


@kernel(parallel=True)
def internal_forces(chunks, surface, x, forces):
    """Forces of stress and hourglass control on the corners of each element [N], shape (m, 4, 3)."""
    for chunk in prange(chunks):
        _force_chunk(surface, x, forces, chunk)


@kernel()
def _press_chunk(surface, x, forces, chunk, pressure):
    corners, n_quads, _, _, _, _, _ = surface.content
    first, middle, end = elements_of(chunk, n_quads, len(corners))
    for e in range(first, middle):
        press_quadrilateral(surface, x, forces, e, pressure)
    for e in range(middle, end):
        press_triangle(surface, x, forces, e, pressure)


@kernel(parallel=True)
def pressure_forces(chunks, surface, x, forces, pressure):
    """∫ p N_K n dA on the corners of each element [N], shape (m, 4, 3), exact for bilinear and linear surfaces."""
    for chunk in prange(chunks):
        _press_chunk(surface, x, forces, chunk, pressure)


@kernel()
def _add_range(about, corner_values, target, s):
    first, number, fan = about.content
    for p in range(first[s], first[s + 1]):
        K = number[p]
        for t in range(fan.start[K], fan.start[K + 1]):
            place = fan.places[t]
            for d in range(3):
                target[p, d] += corner_values[place, d]


@kernel(parallel=True)
def add_corners(n, about, corner_values, target):
    """Add the values at the corners about each node of n ranges, shape (4 m, 3), to `target`, shape (nodes, 3).

    about: the bundle (first nodes of the ranges, numbers of the nodes, `Fan`).
    """
    for r in prange(n):
        _add_range(about, corner_values, target, r)


@kernel()
def _stress_chunk(surface, x, stress, chunk):
    corners, n_quads, _, _, _, _, _ = surface.content
    first, middle, end = elements_of(chunk, n_quads, len(corners))
    for e in range(first, middle):
        quadrilateral_stress(surface, x, stress, e)
    for e in range(middle, end):
        triangle_stress(surface, x, stress, e)


@kernel(parallel=True)
def cauchy_stresses(chunks, surface, x, stress):
    """Stresses of the elements, components xx, yy, zz, yz, xz, xy [Pa], shape (m, 6)."""
    for chunk in prange(chunks):
        _stress_chunk(surface, x, stress, chunk)
