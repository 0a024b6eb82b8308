"""Kernels for the strains and stresses of membrane elements in a step, and for their nodal forces (stress, hourglass control,
pressure) and area slopes.

`surface` holds the data of `StrainedElements`. Elements are divided into chunks whose number does not depend on the number of
threads. Kernels over elements write the forces on their corners, and a kernel over nodes sums them in a fixed order. There are
no atomic operations, and results are bitwise equal for any number of threads.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.bodies.membrane_elements import geometry
from pellucid.bodies.membrane_elements.mesh import Fan
from pellucid.bodies.membrane_elements.quadrilateral import (
    BAD,
    COLUMNS,
    GIVEN,
    SIGNAL,
    SUMS,
    fault_of,
    press_quadrilateral,
    quadrilateral_forces,
    quadrilateral_stress,
    strain_quadrilaterals,
)
from pellucid.bodies.membrane_elements.triangle import (
    press_triangle,
    strain_triangle,
    triangle_energy,
    triangle_forces,
    triangle_stress,
)
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


@parallel_loop()
def find_energies(chunk, surface, x):
    """Set the strain energies of the triangles of a chunk to those of their present shapes; in a run with motion, they are the
    works of the stress in the steps. The stress is set to 0 until it is computed. surface: data of `StrainedElements`; x: nodal
    positions [m], shape (n, 3).
    """
    _, middle, end = elements_of(chunk, surface.n_quads, len(surface.corners))
    for e in range(middle, end):
        surface.state.strain_energy[e] = triangle_energy(surface, x, e)
        for i in range(3):
            surface.state.plane_stress[e, i] = 0.0


@parallel_loop()
def internal_forces(chunk, surface, x, forces):
    """Compute the forces of stress and hourglass control on the corners of each element of a chunk [N]; they are written to
    `forces`, shape (m, 4, 3). surface: data of `StrainedElements`; x: nodal positions [m], shape (n, 3).
    """
    first, middle, end = elements_of(chunk, surface.n_quads, len(surface.corners))
    c = numbers(WIDTH * (GIVEN + 3))
    for start in range(first, middle, BLOCK):
        quadrilateral_forces(surface, x, forces, start, min(BLOCK, middle - start), c)
    for e in range(middle, end):
        triangle_forces(surface, x, forces, e)


@parallel_loop()
def pressure_forces(chunk, surface, x, forces, pressure):
    """Compute the forces ∫ p N_K n dA of a pressure p [Pa], with the normal n, on the corners K of each element of a chunk
    [N], exact for bilinear and linear surfaces; they are written to `forces`, shape (m, 4, 3). surface: data of
    `StrainedElements`; x: nodal positions [m], shape (n, 3).
    """
    first, middle, end = elements_of(chunk, surface.n_quads, len(surface.corners))
    for e in range(first, middle):
        press_quadrilateral(surface, x, forces, e, pressure)
    for e in range(middle, end):
        press_triangle(surface, x, forces, e, pressure)


class CornersAbout(NamedTuple):
    """The corners of elements around each node, for sums over elements at the nodes."""

    first: np.ndarray  # (ranges + 1,) nodes first[r]:first[r+1] are processed together
    number: np.ndarray  # (n,) number in the mesh of the node in each row
    fan: Fan  # corners around each node of the mesh


@parallel_loop()
def add_corners(r, about, corner_values, target):
    """Add the values at the element corners around each node, shape (4 m, 3), to `target`, shape (nodes, 3), for the nodes of
    range r (a group that one thread processes). about: data of `CornersAbout`.
    """
    first, number, fan = about.first, about.number, about.fan
    for p in range(first[r], first[r + 1]):
        K = number[p]
        for t in range(fan.start[K], fan.start[K + 1]):
            place = fan.places[t]
            for d in range(3):
                target[p, d] += corner_values[place, d]


@parallel_loop()
def cauchy_stresses(chunk, surface, x, stress):
    """Compute the Cauchy stresses of the elements of a chunk, components xx, yy, zz, yz, xz, xy [Pa]; they are written to
    `stress`, shape (m, 6). surface: data of `StrainedElements`; x: nodal positions [m], shape (n, 3).
    """
    first, middle, end = elements_of(chunk, surface.n_quads, len(surface.corners))
    for e in range(first, middle):
        quadrilateral_stress(surface, x, stress, e)
    for e in range(middle, end):
        triangle_stress(surface, x, stress, e)


@parallel_loop()
def area_slopes(chunk, surface, x, slopes):
    """Compute the derivatives ∂A/∂x of the triangle areas of a chunk with respect to the corners of each triangle [m]; they
    are written to `slopes`, shape (m, 4, 3). surface: data of `StrainedElements`; x: nodal positions [m], shape (n, 3).
    """
    _, middle, end = elements_of(chunk, surface.n_quads, len(surface.corners))
    for e in range(middle, end):
        chi, psi = geometry.edges(x, surface.corners, e)
        at_b, at_c = geometry.area_slopes(chi, psi)
        for d in range(3):
            slopes[e, 1, d], slopes[e, 2, d] = at_b[d], at_c[d]
            slopes[e, 0, d] = -(at_b[d] + at_c[d])
