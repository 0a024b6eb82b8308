"""Straining of membrane elements: loops over quadrilaterals and triangles.

`surface` is the bundle of `StrainedElements`. Elements are divided into chunks whose number does not depend on the number
of threads.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.bodies.membrane_elements.quadrilateral import BAD, COLUMNS, SIGNAL, SUMS, fault_of, strain_quadrilaterals
from pellucid.bodies.membrane_elements.triangle import strain_triangle
from pellucid.grid.passes.blocks import add_columns, largest_of_column
from pellucid.grid.points import OK
from pellucid.jit import pointwise
from pellucid.jit.columns import BLOCK, WIDTH
from pellucid.jit.local import numbers, zeros
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES, load, total

CHUNK = 512
STRAIN, HOURGLASS, FREQUENCY, ELEMENT_SUMS = range(4)  # columns of the sums of a chunk


class ElementArrays(NamedTuple):
    """State arrays of m elements in the order of the mesh: q quadrilaterals, then triangles."""

    element_mass: np.ndarray  # (m,) [kg]
    plane_stress: np.ndarray  # (m, 3) σ₁₁, σ₂₂, σ₁₂ in the material's frame; of triangles S in the axes at rest [Pa]
    thickness: np.ndarray  # (m,) [m]
    volume: np.ndarray  # (m,) [m³]
    strain_energy: np.ndarray  # (m,) work of the stress [J]
    hourglass_energy: np.ndarray  # (m,) work against hourglass forces [J]
    shape: np.ndarray  # (q, 4) in-plane shape in the material's frame, the law's own
    turn: np.ndarray  # (q, 2) cosine and sine of the angle from the element's frame to the material's
    hourglass: np.ndarray  # (q, 2) hourglass force Q in the element's frame [N]
    dissipated_energy: np.ndarray  # (m,) the part of the work of the stress that viscosity took [J]; else of no length


class StrainedElements(NamedTuple):
    """Element data for kernels: of m elements, the first n_quads are quadrilaterals."""

    corners: np.ndarray  # (m, 4) nodes; of triangles the last one twice
    n_quads: int
    law: Any
    control: Any  # of hourglass modes
    thickness: float  # at rest [m]
    rest: np.ndarray  # rest shapes of the triangles
    state: ElementArrays


@pointwise
def elements_of(chunk, n_quads, n):
    """Return the range of elements of a chunk: its first element, its first triangle, and its end."""
    first, end = CHUNK * chunk, min(CHUNK * (chunk + 1), n)
    return first, min(max(first, n_quads), end), end


@parallel_loop()
def strain(chunk, surface, x, v, sums, fault, dt):
    """Update shapes, stresses and energies of the elements of a chunk; their nodes moved to x with velocities v in the
    step."""
    first, middle, end = elements_of(chunk, surface.n_quads, len(surface.corners))
    first_fault = at_fault = 0
    c, block_sums = numbers(WIDTH * COLUMNS), zeros((SUMS + 1) * LANES)
    for start in range(first, middle, BLOCK):
        n = min(BLOCK, middle - start)
        strain_quadrilaterals(surface, x, v, start, n, dt, c)
        add_columns(c, BAD, n, block_sums, 0, SUMS)
        largest_of_column(c, SIGNAL, n, block_sums, SUMS)
        if first_fault == OK and total(load(block_sums, 0)) > 0.0:
            for q in range(n):
                wrong = fault_of(c, q)
                if wrong != OK and first_fault == OK:
                    first_fault = wrong
                    at_fault = start + q
    strain_energy, hourglass_energy, rate = total(load(block_sums, LANES)), total(load(block_sums, 2 * LANES)), 0.0
    for lane in range(LANES):
        rate = max(rate, block_sums[SUMS * LANES + lane])
    for e in range(middle, end):
        strained, signal, wrong = strain_triangle(surface, x, v, e, dt)
        strain_energy += strained
        rate = max(rate, signal)
        if wrong != OK and first_fault == OK:
            first_fault = wrong
            at_fault = e
    sums[chunk, STRAIN], sums[chunk, HOURGLASS], sums[chunk, FREQUENCY] = strain_energy, hourglass_energy, rate
    fault[chunk, 0], fault[chunk, 1] = first_fault, at_fault
