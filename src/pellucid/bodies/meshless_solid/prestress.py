"""Initial stress of a meshless solid, in addition to the stress of its material law.

It is a constant second Piola-Kirchhoff stress S₀ of the points in the reference configuration: P = P(F) + F S₀. At rest it
equals the Cauchy stress. It rotates with the material, and is the derivative of the energy S₀ : E with E = (FᵀF - I)/2.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.bodies.meshless_solid.forces import find_stresses
from pellucid.bodies.meshless_solid.nodal_fields import AtPoints
from pellucid.bodies.meshless_solid.solid import COLUMN, STORED, STRESS, WEIGHT, Solid
from pellucid.jit import point_function
from pellucid.jit.vector import LANES

ROWS = ((0, 5, 4), (5, 1, 3), (4, 3, 2))  # indices of the rows of a symmetric tensor in its components xx, yy, zz, yz, xz, xy


class Prestressed(NamedTuple):
    """Material points of a solid with an initial stress S₀ [Pa], shape (lanes, 6), that is added to the stress of the law.
    Lanes are the entries of SIMD packs, one for each point and padding at the end.
    """

    points: Any  # points without the initial stress, see `find_stresses`
    stress: np.ndarray  # components xx, yy, zz, yz, xz, xy of S₀


def prestressed(solid: Solid, stress: np.ndarray | None) -> Solid:
    """Return the solid with an initial stress of its points [Pa], shape (n, 6); the solid itself if stress is None."""
    if stress is None:
        return solid
    lanes = np.zeros((len(solid.weights), 6))
    lanes[: len(stress)] = stress
    return solid._replace(points=Prestressed(solid.points, lanes))


@point_function(find_stresses, Prestressed)
def _find_stresses(points, first, n, solid, dt, keep, averaged, s):
    lost = find_stresses(points.points, first, n, solid, dt, keep, averaged, s)
    for i in range(n * LANES):
        p = LANES * first + i
        xx, yy, zz, yz, xz, xy = (
            points.stress[p, 0],
            points.stress[p, 1],
            points.stress[p, 2],
            points.stress[p, 3],
            points.stress[p, 4],
            points.stress[p, 5],
        )
        w, twice = s[WEIGHT * COLUMN + i], -(xx + yy + zz)
        for row in range(3):
            a, b, c = s[3 * row * COLUMN + i], s[(3 * row + 1) * COLUMN + i], s[(3 * row + 2) * COLUMN + i]
            x, y, z = a * xx + b * xy + c * xz, a * xy + b * yy + c * yz, a * xz + b * yz + c * zz
            s[(STRESS + 3 * row) * COLUMN + i] += w * x
            s[(STRESS + 3 * row + 1) * COLUMN + i] += w * y
            s[(STRESS + 3 * row + 2) * COLUMN + i] += w * z
            twice += a * x + b * y + c * z
        s[STORED * COLUMN + i] += 0.5 * w * twice
    return lost


def with_prestress(found: AtPoints, solid: Solid, F: np.ndarray) -> AtPoints:
    """Return stresses and energies of n quadrature points with the contributions of the initial stress, if there is one.

    found: stresses and energies of the material law; solid: data of `Solid`; F: deformation gradients, shape (n, 3, 3).
    """
    if not isinstance(solid.points, Prestressed):
        return found
    S = solid.points.stress[: len(F)][:, np.array(ROWS)]
    sigma = F @ S @ F.transpose(0, 2, 1) / np.linalg.det(F)[:, None, None]
    strain = 0.5 * (F.transpose(0, 2, 1) @ F - np.eye(3))
    six = sigma[:, (0, 1, 2, 1, 0, 0), (0, 1, 2, 2, 2, 1)]
    return found._replace(stress=found.stress + six, stored=found.stored + np.einsum("pij,pij->p", S, strain))
