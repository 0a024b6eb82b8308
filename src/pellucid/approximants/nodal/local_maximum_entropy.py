"""Local maximum-entropy approximants with Gaussian priors.

Source: Arroyo & Ortiz 2006, Int. J. Numer. Methods Eng. 65, 2167.
"""

from math import inf, log, sqrt
from typing import Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator, shape_functions
from pellucid.approximants.nodal.face_distances import SHAPE, FaceDistances, face_distances, no_faces, share_before_faces
from pellucid.approximants.nodal.maximum_entropy import MaximumEntropyModel, entropy_functions, offsets
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import point_function
from pellucid.model import parameter

NEGLIGIBLE = 1e-8  # prior relative to its value at the node, at which the support is cut off


class LocalMaximumEntropy(NamedTuple):
    """Parameters of the priors: nodes, widths of the Gaussian priors, and distances from faces on which priors vanish (most
    nodes have no such faces)."""

    position: np.ndarray  # (n, 3) node positions [m]
    width: np.ndarray  # (n,) width of the Gaussian prior of each node, h/sqrt(γ) [m]
    distances: FaceDistances  # in units of the mean edge length at a node


class LocalMaximumEntropyModel(MaximumEntropyModel):
    """Local maximum entropy with priors exp(-γ|x - x_a|²/h²), where h is the mean edge length at the node."""

    kind: Literal["local-maximum-entropy"] = "local-maximum-entropy"
    locality: float = parameter("", "locality γ: larger values give smaller supports", 2.4, ge=0.5, le=10)

    @property
    def nodes_in_a_cell(self) -> float:
        return 262.0 * (2.4 / self.locality) ** 1.5  # measured at γ = 2.4; the radius of a support is proportional to γ^(-1/2)

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        from pellucid.approximants.nodal.rings import nodes_in_reach  # scipy is slow to import

        width = mesh.spacing / sqrt(self.locality)
        active = nodes_in_reach(mesh, width * sqrt(-log(NEGLIGIBLE)))
        distances = face_distances(mesh, SHAPE, mesh.spacing, no_faces(len(mesh.nodes)))
        return Evaluator(active, LocalMaximumEntropy(mesh.nodes, width, distances))


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
            share, gx, gy, gz = share_before_faces(distances, x, active[i], scratch.faces)
            scratch.log_prior[i] += log(share) if share > 0.0 else -inf
            factor = length / (distances.size[active[i]] * share) if share > 0.0 else 0.0
            scratch.slope[i, 0] += factor * gx
            scratch.slope[i, 1] += factor * gy
            scratch.slope[i, 2] += factor * gz
    return entropy_functions(length, distances.flat, scratch, values, gradients)
