"""Nodal forces of membrane elements: stress, hourglass control, pressure.

`surface` is the bundle of `StrainedElements`. Kernels over elements write the forces on their corners,
and a kernel over nodes adds them up in a fixed order: no atomics, the same bits on any number of threads.
"""

from typing import NamedTuple

import numpy as np

from pellucid.bodies.membrane_elements.mesh import Fan
from pellucid.bodies.membrane_elements.quadrilateral import (
    GIVEN,
    press_quadrilateral,
    quadrilateral_forces,
    quadrilateral_stress,
)
from pellucid.bodies.membrane_elements.strain import elements_of
from pellucid.bodies.membrane_elements.triangle import press_triangle, triangle_forces, triangle_stress
from pellucid.jit import kernel
from pellucid.jit.columns import BLOCK, WIDTH
from pellucid.jit.local import numbers
from pellucid.jit.parallel import parallel_for


@kernel(inner=True)
def _force_chunk(chunk, surface, x, forces):
    first, middle, end = elements_of(chunk, surface.n_quads, len(surface.corners))
    c = numbers(WIDTH * (GIVEN + 3))
    for start in range(first, middle, BLOCK):
        quadrilateral_forces(surface, x, forces, start, min(BLOCK, middle - start), c)
    for e in range(middle, end):
        triangle_forces(surface, x, forces, e)


@kernel()
def internal_forces(chunks, surface, x, forces):
    """Forces of stress and hourglass control on the corners of each element [N], shape (m, 4, 3)."""
    parallel_for(_force_chunk, chunks, surface, x, forces)


@kernel(inner=True)
def _press_chunk(chunk, surface, x, forces, pressure):
    first, middle, end = elements_of(chunk, surface.n_quads, len(surface.corners))
    for e in range(first, middle):
        press_quadrilateral(surface, x, forces, e, pressure)
    for e in range(middle, end):
        press_triangle(surface, x, forces, e, pressure)


@kernel()
def pressure_forces(chunks, surface, x, forces, pressure):
    """∫ p N_K n dA on the corners of each element [N], shape (m, 4, 3), exact for bilinear and linear surfaces."""
    parallel_for(_press_chunk, chunks, surface, x, forces, pressure)


class CornersAbout(NamedTuple):
    """The corners of elements about each node."""

    first: np.ndarray  # (ranges + 1,) nodes first[r]:first[r+1] are worked on together
    number: np.ndarray  # (n,) of the node in the mesh
    fan: Fan


@kernel(inner=True)
def _add_range(r, about, corner_values, target):
    first, number, fan = about.first, about.number, about.fan
    for p in range(first[r], first[r + 1]):
        K = number[p]
        for t in range(fan.start[K], fan.start[K + 1]):
            place = fan.places[t]
            for d in range(3):
                target[p, d] += corner_values[place, d]


@kernel()
def add_corners(n, about, corner_values, target):
    """Add the values at the corners about each node of n ranges, shape (4 m, 3), to `target`, shape (nodes, 3).

    about: the bundle of `CornersAbout`.
    """
    parallel_for(_add_range, n, about, corner_values, target)


@kernel(inner=True)
def _stress_chunk(chunk, surface, x, stress):
    first, middle, end = elements_of(chunk, surface.n_quads, len(surface.corners))
    for e in range(first, middle):
        quadrilateral_stress(surface, x, stress, e)
    for e in range(middle, end):
        triangle_stress(surface, x, stress, e)


@kernel()
def cauchy_stresses(chunks, surface, x, stress):
    """Stresses of the elements, components xx, yy, zz, yz, xz, xy [Pa], shape (m, 6)."""
    parallel_for(_stress_chunk, chunks, surface, x, stress)
