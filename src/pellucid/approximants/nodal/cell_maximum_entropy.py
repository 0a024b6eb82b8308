"""Cell-based maximum-entropy approximants: priors from smooth distances to the boundaries of rings.

Source: Millán, Sukumar & Arroyo 2015, Comput. Methods Appl. Mech. Eng. 284, 712, in two dimensions; Mountris et al. 2019,
section 3, in three.
"""

from math import inf, log
from typing import Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator, shape_functions
from pellucid.approximants.nodal.face_distances import VANISHING, FaceDistances, face_distances, inverse_square
from pellucid.approximants.nodal.maximum_entropy import MaximumEntropyModel, entropy_functions, offsets
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import point_function, pointwise
from pellucid.model import parameter


class CellMaximumEntropy(NamedTuple):
    """Parameters of cell-based maximum-entropy shape functions for kernels. The prior (weight) of a node depends on the
    distance from the faces that bound the ring of cells around the node."""

    smoothness: float  # exponent s of the priors
    position: np.ndarray  # (n, 3) node positions [m]
    distances: FaceDistances  # faces that bound the ring of cells around each node


class CellMaximumEntropyModel(MaximumEntropyModel):
    """Cell-based maximum entropy: smooth, positive shape functions with supports of rings of cells.

    Lengths in a prior are divided by the size of the ring of its node (the largest distance from the node to a vertex of the
    ring), so that the functions do not depend on the unit of length.
    """

    kind: Literal["cell-based-maximum-entropy"] = "cell-based-maximum-entropy"
    rings: int = parameter(
        "", "size of a node's support: number of rings of cells around it; 1 gives linear simplex functions", 2, ge=1, le=3
    )
    smoothness: float = parameter(
        "", "exponent s: the prior weight of a node is the distance to the edge of its support to the power s", 2.0, ge=1, le=8
    )
    shape: float = parameter(
        "", "smoothing factor α of the distance function of a triangle, which has kinks for α = 0", 0.2, gt=0, le=8
    )

    @property
    def nodes_in_a_cell(self) -> float:
        return {1: 4.0, 2: 35.0, 3: 116.0}[self.rings]  # measured

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        from pellucid.approximants.nodal.rings import nodes_of_cells, ring_boundaries  # scipy is slow to import

        bounds, size = ring_boundaries(mesh, self.rings)
        distances = face_distances(mesh, self.shape, size, bounds)
        return Evaluator(nodes_of_cells(mesh, self.rings), CellMaximumEntropy(self.smoothness, mesh.nodes, distances))


@pointwise
def _prior(fn, x, a, faces):
    """Return ln w_a = s ln D_a, the logarithm of the prior (weight) of node a at x [m], and the gradient of this logarithm
    times the ring size.

    D_a: smooth distance of x from the faces that bound the ring of cells around the node, divided by the ring size; faces:
    scratch memory for a block of faces. fn: `CellMaximumEntropy`, with the exponent s.
    """
    total, gx, gy, gz = inverse_square(fn.distances, x, a, faces)
    if total == 0.0:  # the ring covers the whole mesh
        return 0.0, 0.0, 0.0, 0.0
    if total * VANISHING * VANISHING >= 1.0:
        return -inf, 0.0, 0.0, 0.0
    factor = fn.smoothness / total
    return -0.5 * fn.smoothness * log(total), factor * gx, factor * gy, factor * gz


@point_function(shape_functions, CellMaximumEntropy)
def _shape_functions(functions, cell, x, active, scratch, values, gradients):
    n = len(active)
    length = offsets(functions.position, x, active, scratch.offset)
    for i in range(n):
        prior, gx, gy, gz = _prior(functions, x, active[i], scratch.faces)
        factor = length / functions.distances.size[active[i]]
        scratch.log_prior[i] = prior
        scratch.slope[i, 0], scratch.slope[i, 1], scratch.slope[i, 2] = factor * gx, factor * gy, factor * gz
    return entropy_functions(length, functions.distances.flat, scratch, values, gradients)
