"""The heavy elastica: large deflections of a beam that is clamped horizontally and bends under its own weight.

With the angle θ below the horizontal at the arc length s from the clamp, the length L, the bending rigidity D, the weight q
per unit area and the stretching stiffness EA, all per width:

    D θ'' + (1 + e) q (L - s) cos θ = 0,    θ(0) = 0, θ'(L) = 0,    e = q (L - s) sin θ / EA,

where e is the strain caused by the weight below s. Source: Rohde 1953, Q. Appl. Math. 11, 337, without e.
"""

from math import inf

import numpy as np
from scipy.integrate import solve_bvp

from pellucid.references.annotations import Array

START = 200  # places at which the search for the shape begins


def heavy_elastica(
    along: Array, length: float, rigidity: float, weight: float, stretching_stiffness: float = inf
) -> tuple[Array, Array]:
    """Return the horizontal and vertical distances from the clamp [m] of positions on the beam at rest.

    along: arc lengths of the positions from the clamp [m]; length: length L of the beam [m]; rigidity: bending rigidity D
    [J]; weight: weight q per unit area [Pa]; stretching_stiffness: EA per width [N/m].
    """

    def change(s: Array, state: Array) -> Array:
        angle, bend = state[0], state[1]
        below = weight * (length - s)
        stretch = 1.0 + below * np.sin(angle) / stretching_stiffness
        return np.stack([bend, -stretch * below * np.cos(angle) / rigidity, stretch * np.cos(angle), stretch * np.sin(angle)])

    def ends(clamp: Array, tip: Array) -> Array:
        return np.array([clamp[0], tip[1], clamp[2], clamp[3]])

    s = np.linspace(0.0, length, START)
    found = solve_bvp(change, ends, s, np.zeros((4, START)), tol=1e-9)
    if not found.success:
        raise ValueError(f"no shape of the heavy elastica was found: {found.message}")
    shape = found.sol(along)
    return shape[2], shape[3]
