"""Modified moving least squares with supports of rings of cells: weights from smooth distances to the boundaries of rings.

The quadratic basis with its penalty follows Joldes et al. 2015, Appl. Math. Comput. 266, 893; the weights are the priors of
cell-based maximum entropy (Millán, Sukumar & Arroyo 2015, Comput. Methods Appl. Mech. Eng. 284, 712). The corners of a cell
have positive weights everywhere in it, so that shape functions exist in every cell with a volume.
"""

from typing import Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator, shape_functions
from pellucid.approximants.nodal.face_distances import VANISHING, FaceDistances, face_distances, inverse_square
from pellucid.approximants.nodal.faced import FacedApproximant
from pellucid.approximants.nodal.least_squares import QUADRATIC, least_squares
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import point_function, pointwise
from pellucid.model import parameter


class CellLeastSquares(NamedTuple):
    """Parameters of cell-based least-squares shape functions for kernels. The weight of a node depends on the distance from
    the faces that bound the ring of cells around the node."""

    smoothness: float  # exponent s of the weights
    position: np.ndarray  # (n, 3) node positions [m]
    distances: FaceDistances  # faces that bound the ring of cells around each node


class CellLeastSquaresModel(FacedApproximant):
    """Least squares with a quadratic basis and supports of rings of cells."""

    kind: Literal["cell-based-least-squares"] = "cell-based-least-squares"
    rings: int = parameter("", "size of a node's support: number of rings of cells around it", 2, ge=2, le=3)
    smoothness: float = parameter(
        "", "exponent s: the weight of a node is the distance to the edge of its support to the power s", 2.0, ge=1, le=8
    )
    shape: float = parameter(
        "", "smoothing factor α of the distance function of a triangle, which has kinks for α = 0", 0.2, gt=0, le=8
    )

    @property
    def nodes_in_a_cell(self) -> float:
        return {2: 35.0, 3: 116.0}[self.rings]  # measured

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        from pellucid.approximants.nodal.rings import nodes_of_cells, ring_boundaries  # scipy is slow to import

        bounds, size = ring_boundaries(mesh, self.rings)
        distances = face_distances(mesh, self.shape, size, bounds)
        return Evaluator(nodes_of_cells(mesh, self.rings), CellLeastSquares(self.smoothness, mesh.nodes, distances), False)


@pointwise
def _weight(fn, x, a, faces):
    """Return the weight D^s of node a at x [m], and the gradient of this weight times the size of the ring of cells around
    the node. D is the smooth distance of x from the faces that bound the ring, divided by the ring size.

    fn: `CellLeastSquares`, with the exponent s; faces: scratch memory for a block of faces.
    """
    total, gx, gy, gz = inverse_square(fn.distances, x, a, faces)
    if total == 0.0:  # the ring covers the whole mesh
        return 1.0, 0.0, 0.0, 0.0
    if total * VANISHING * VANISHING >= 1.0:
        return 0.0, 0.0, 0.0, 0.0
    weight = total ** (-0.5 * fn.smoothness)
    factor = weight * fn.smoothness / total
    return weight, factor * gx, factor * gy, factor * gz


@point_function(shape_functions, CellLeastSquares)
def _shape_functions(functions, cell, x, active, scratch, values, gradients):
    distances = functions.distances
    length = distances.size[active[0]]
    for i in range(len(active)):
        a = active[i]
        weight, gx, gy, gz = _weight(functions, x, a, scratch.faces)
        factor = length / distances.size[a]
        scratch.log_prior[i] = weight
        scratch.slope[i, 0], scratch.slope[i, 1], scratch.slope[i, 2] = factor * gx, factor * gy, factor * gz
        for d in range(3):
            scratch.offset[i, d] = (functions.position[a, d] - x[d]) / length
    return least_squares(QUADRATIC, distances.flat, True, length, scratch, values, gradients)
