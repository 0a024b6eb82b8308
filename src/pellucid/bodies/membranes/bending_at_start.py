"""The step limit of bending at the start, computed without compilation."""

from math import sqrt

import numpy as np

from pellucid.bodies.membrane_elements.mesh import hinges_of
from pellucid.geometry.meshes.enclosure import rims_of


def bending_rate(triangles: np.ndarray, position: np.ndarray, mass: np.ndarray, rigidity: float, poisson_ratio: float) -> float:
    """Return an upper bound of half the largest eigenfrequency of bending of a membrane [1/s], which limits the time step.

    triangles: shape (t, 3); position: nodal positions [m], shape (n, 3); mass: nodal masses [kg], shape (n,); rigidity: κ
    [J]; poisson_ratio: ν, for an open surface. `Bending` and, for an open membrane without supports, `PlateBending` compute
    the same bound in a run. The bound depends on lengths and areas, not on angles.
    """
    n, hinges = len(position), hinges_of(triangles)
    if len(rims_of(triangles).edges):
        from pellucid.bodies.membranes.plate_operators import build_plate_operators, no_supports  # imports scipy

        supports = no_supports(len(triangles), n)
        operators = build_plate_operators(triangles, position, rigidity, poisson_ratio, supports)
        return operators.rate(position, mass, supports.fixed)
    a, b, c, d = (position[corner] for corner in hinges.T)
    along, left, right = b - a, c - a, d - a
    square = np.sum(along * along, axis=1)
    length = np.sqrt(square)
    one, two = (length / np.linalg.norm(np.cross(along, way), axis=1) for way in (left, right))
    s, t = (np.sum(way * along, axis=1) / square for way in (left, right))
    # |∂φ/∂x| at the corners: across, and at most at the ends of the edge
    turned = np.stack([np.abs(1.0 - s) * one + np.abs(1.0 - t) * two, np.abs(s) * one + np.abs(t) * two, one, two], axis=1)
    edges = position[triangles] - position[triangles[:, [1, 2, 0]]]
    thirds = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 6.0
    area = np.bincount(triangles.ravel(), np.repeat(thirds, 3), n)
    reach = np.bincount(hinges[:, :2].ravel(), np.repeat(0.5 * length * turned.sum(axis=1), 2), n)
    stiff = rigidity * reach / area
    values = (0.5 * length * stiff[hinges[:, :2]].sum(axis=1))[:, None] * turned
    return 0.5 * sqrt(float((np.bincount(hinges.ravel(), values.ravel(), n) / mass).max()))
