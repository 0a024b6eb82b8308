"""Kernels for the nodal forces of membrane elements (stress, hourglass control, pressure), their stresses and area slopes.

`surface` holds the data of `StrainedElements`. Kernels over elements write the forces on their corners, and a kernel over nodes
sums them in a fixed order. There are no atomic operations, and results are bitwise equal for any number of threads.
"""

from typing import NamedTuple

import numpy as np

from pellucid.bodies.membrane_elements import geometry
from pellucid.bodies.membrane_elements.mesh import Fan
from pellucid.bodies.membrane_elements.quadrilateral import (
    GIVEN,
    press_quadrilateral,
    quadrilateral_forces,
    quadrilateral_stress,
)
from pellucid.bodies.membrane_elements.strain import elements_of
from pellucid.bodies.membrane_elements.triangle import press_triangle, triangle_forces, triangle_stress
from pellucid.jit.columns import BLOCK, WIDTH
from pellucid.jit.loops import parallel_loop
from pellucid.jit.memory import numbers


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
