"""Local maximum-entropy approximants: Gaussian priors.

Source: Arroyo & Ortiz 2006, Int. J. Numer. Methods Eng. 65, 2167.
"""

from math import log, sqrt
from typing import Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import NO_FACES, Evaluator, NodalApproximant, shape_functions
from pellucid.approximants.nodal.maximum_entropy import entropy_functions, offsets
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.jit import point_function
from pellucid.model import parameter

NEGLIGIBLE = 1e-8  # of the prior at its node, where the support is cut off


class LocalMaximumEntropy(NamedTuple):
    """Nodes and the widths of their priors."""

    flat: bool
    position: np.ndarray  # (n, 3) [m]
    width: np.ndarray  # (n,) of the Gaussian, h/sqrt(γ) [m]


class LocalMaximumEntropyModel(NodalApproximant):
    """Local maximum entropy: priors exp(-γ|x - x_a|²/h²), where h is the mean length of the edges at the node."""

    kind: Literal["local-maximum-entropy"] = "local-maximum-entropy"
    locality: float = parameter("", "γ: how local the functions are", 2.4, ge=0.5, le=10)

    @property
    def nodes_in_a_cell(self) -> float:
        """Counted at γ = 2.4; supports grow as its root falls."""
        return 262.0 * (2.4 / self.locality) ** 1.5

    def evaluator(self, mesh: SimplexMesh, constrained: np.ndarray = NO_FACES) -> Evaluator:
        """Functions whose supports end where the prior is negligible; constrained faces change nothing."""
        from pellucid.approximants.nodal.rings import nodes_in_reach  # scipy is heavy

        width = mesh.spacing / sqrt(self.locality)
        active = nodes_in_reach(mesh, width * sqrt(-log(NEGLIGIBLE)))
        return Evaluator(active, LocalMaximumEntropy(mesh.dimension == 2, mesh.nodes, width))


@point_function(shape_functions, LocalMaximumEntropy)
def _shape_functions(functions, cell, x, active, scratch, values, gradients):
    n = len(active)
    length = offsets(functions.position, x, active, scratch.offset)
    for i in range(n):
        ratio = length / functions.width[active[i]]
        square = 0.0
        for d in range(3):
            square += scratch.offset[i, d] * scratch.offset[i, d]
            scratch.slope[i, d] = -2.0 * ratio * ratio * scratch.offset[i, d]
        scratch.log_prior[i] = -ratio * ratio * square
    return entropy_functions(length, functions.flat, scratch, values, gradients)
