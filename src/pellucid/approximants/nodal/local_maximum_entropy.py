"""Local maximum-entropy approximants: Gaussian priors.

Source: Arroyo & Ortiz 2006, Int. J. Numer. Methods Eng. 65, 2167.
"""

from math import inf, log, log1p, sqrt
from typing import Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator, shape_functions
from pellucid.approximants.nodal.face_distances import VANISHING, FaceDistances, face_distances, inverse_square
from pellucid.approximants.nodal.lists import Lists
from pellucid.approximants.nodal.maximum_entropy import MaximumEntropyModel, entropy_functions, offsets
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.jit import point_function, pointwise
from pellucid.model import parameter

NEGLIGIBLE = 1e-8  # of the prior at its node, where the support is cut off
SMOOTHNESS, SHAPE = 2.0, 0.2  # of distances from faces on which functions vanish: those of cell-based maximum entropy


class LocalMaximumEntropy(NamedTuple):
    """Nodes, the widths of their priors, and distances from faces on which these vanish, of most nodes none."""

    position: np.ndarray  # (n, 3) [m]
    width: np.ndarray  # (n,) of the Gaussian, h/sqrt(γ) [m]
    distances: FaceDistances  # in mean lengths of the edges at a node


class LocalMaximumEntropyModel(MaximumEntropyModel):
    """Local maximum entropy: priors exp(-γ|x - x_a|²/h²), where h is the mean length of the edges at the node."""

    kind: Literal["local-maximum-entropy"] = "local-maximum-entropy"
    locality: float = parameter("", "γ: how local the functions are", 2.4, ge=0.5, le=10)

    @property
    def nodes_in_a_cell(self) -> float:
        """Counted at γ = 2.4; supports grow as its root falls."""
        return 262.0 * (2.4 / self.locality) ** 1.5

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        """Functions whose supports end where the prior is negligible."""
        from pellucid.approximants.nodal.rings import nodes_in_reach  # scipy is heavy

        width = mesh.spacing / sqrt(self.locality)
        active = nodes_in_reach(mesh, width * sqrt(-log(NEGLIGIBLE)))
        none = Lists(np.zeros(len(mesh.nodes) + 1, np.int64), np.zeros(0, np.int64))
        distances = face_distances(mesh, SHAPE, mesh.spacing, none)
        return Evaluator(active, LocalMaximumEntropy(mesh.nodes, width, distances))


@pointwise
def _end(total):
    """ln (1 + D⁻²)^(-s/2), and by what Σ ρ⁻³ ∇ρ is multiplied in its gradient; total: D⁻²."""
    if total * VANISHING * VANISHING >= 1.0:
        return -inf, 0.0
    return -0.5 * SMOOTHNESS * log1p(total), SMOOTHNESS / (1.0 + total)


@point_function(shape_functions, LocalMaximumEntropy)
def _shape_functions(functions, cell, x, active, scratch, values, gradients):
    n, distances = len(active), functions.distances
    length = offsets(functions.position, x, active, scratch.offset)
    for i in range(n):
        ratio = length / functions.width[active[i]]
        square = 0.0
        for d in range(3):
            square += scratch.offset[i, d] * scratch.offset[i, d]
            scratch.slope[i, d] = -2.0 * ratio * ratio * scratch.offset[i, d]
        scratch.log_prior[i] = -ratio * ratio * square
        if distances.first[active[i]] < distances.first[active[i] + 1]:
            total, gx, gy, gz = inverse_square(distances, x, active[i], scratch.faces)
            end, factor = _end(total)
            factor *= length / distances.size[active[i]]
            scratch.log_prior[i] += end
            scratch.slope[i, 0] += factor * gx
            scratch.slope[i, 1] += factor * gy
            scratch.slope[i, 2] += factor * gz
    return entropy_functions(length, distances.flat, scratch, values, gradients)
