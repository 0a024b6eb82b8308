"""Update of the strains and stresses of membrane elements in a step: loops over quadrilaterals and triangles.

`surface` holds the data of `StrainedElements`. Elements are divided into chunks whose number does not depend on the number of
threads.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.bodies.membrane_elements.quadrilateral import BAD, COLUMNS, SIGNAL, SUMS, fault_of, strain_quadrilaterals
from pellucid.bodies.membrane_elements.triangle import strain_triangle
from pellucid.grid.passes.blocks import add_columns, largest_of_column
from pellucid.grid.points import OK
from pellucid.jit import pointwise
from pellucid.jit.columns import BLOCK, WIDTH
from pellucid.jit.loops import parallel_loop
from pellucid.jit.memory import numbers, zeros
from pellucid.jit.vector import LANES, load, total

CHUNK = 512  # elements
STRAIN, HOURGLASS, FREQUENCY, ELEMENT_SUMS = range(4)  # columns of the sums of a chunk


class ElementArrays(NamedTuple):
    """State arrays of m membrane elements in the order of the mesh (q quadrilaterals, then triangles): masses, in-plane
    stresses and deformations, hourglass forces, energies.
    """

    element_mass: np.ndarray  # (m,) masses of the elements [kg]
    plane_stress: np.ndarray  # (m, 3) σ₁₁, σ₂₂, σ₁₂ in the material's frame; for triangles S in the axes at rest [Pa]
    thickness: np.ndarray  # (m,) present thickness [m]
    volume: np.ndarray  # (m,) present volume [m³]
    strain_energy: np.ndarray  # (m,) work of the stress [J]
    hourglass_energy: np.ndarray  # (m,) work against hourglass forces [J]
    shape: np.ndarray  # (q, 4) in-plane deformation in the material's frame, in the form of the law
    turn: np.ndarray  # (q, 2) cosine and sine of the angle from the element's frame to the material's
    hourglass: np.ndarray  # (q, 2) hourglass force Q in the element's frame [N]
    dissipated_energy: np.ndarray  # (m,) energy dissipated by viscosity [J]; empty without viscosity


class StrainedElements(NamedTuple):
    """Data of m membrane elements for kernels: nodes, material law, hourglass control and state arrays. The first n_quads
    elements are quadrilaterals, the others triangles.
    """

    corners: np.ndarray  # (m, 4) storage rows of the nodes; the fourth of a triangle repeats the third
    n_quads: int  # number of quadrilaterals
    law: Any  # material law in plane stress
    control: Any  # hourglass control, see `hourglass`
    thickness: float  # thickness of the membrane at rest [m]
    rest: np.ndarray  # (triangles, 4) shape of the triangles at rest, see `rest_gradients`
    state: ElementArrays  # stresses, deformations and energies, updated in each step


@pointwise
def elements_of(chunk, n_quads, n):
    """Return the range of the n elements that belong to a chunk: its first element, its first triangle, and the element after
    its last. n_quads: number of quadrilaterals, which are stored first.
    """
    first, end = CHUNK * chunk, min(CHUNK * (chunk + 1), n)
    return first, min(max(first, n_quads), end), end


@parallel_loop()
def strain(chunk, surface, x, v, sums, fault, dt):
    """Update deformations, stresses and energies of the elements of a chunk, after their nodes moved to x [m] with velocities
    v [m/s] in a step dt [s]. surface: data of `StrainedElements`.

    Energies and the largest frequency of the chunk are written to `sums`, the code and element of its first fault to `fault`.
    """
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
