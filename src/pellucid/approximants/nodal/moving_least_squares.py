"""Moving least squares, and the modified form with a quadratic basis and a regular moment matrix.

Sources: Belytschko, Lu & Gu 1994, Int. J. Numer. Methods Eng. 37, 229; Joldes et al. 2015, Appl. Math. Comput. 266, 893.
"""

from typing import ClassVar, Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator, shape_functions
from pellucid.approximants.nodal.face_distances import SHAPE, FaceDistances, face_distances, no_faces, share_before_faces
from pellucid.approximants.nodal.faced import FacedApproximant
from pellucid.approximants.nodal.least_squares import LINEAR, QUADRATIC, least_squares
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import point_function, pointwise
from pellucid.model import parameter


class MovingLeastSquares(NamedTuple):
    """Parameters of the shape functions: nodes, radii of their supports, and distances from faces on which shape functions
    vanish (most nodes have no such faces)."""

    terms: int  # number of terms of the basis: 4 linear, 10 quadratic
    position: np.ndarray  # (n, 3) node positions [m]
    radius: np.ndarray  # (n,) radius of the support of each node [m]
    distances: FaceDistances  # in units of the mean edge length at a node


class LeastSquaresModel(FacedApproximant):
    """Base of the moving least squares approximants."""

    terms: ClassVar[int]
    """Number of terms of the basis in three dimensions."""
    reach: ClassVar[str | None] = "dilatation"
    remedy: ClassVar[str | None] = "increase it, so that supports have more neighbours, or use a different approximant"

    dilatation: float = parameter("", "radius of a support divided by the mean edge length at its node", 1.6, gt=1, le=5)

    @property
    def nodes_in_a_cell(self) -> float:
        return 88.0 * (self.dilatation / 1.6) ** 3  # measured at 1.6

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        """Build the shape functions for a mesh, with weights that are quartic splines of the distance from the node."""
        from pellucid.approximants.nodal.rings import nodes_in_reach  # scipy is slow to import

        radius = self.dilatation * mesh.spacing
        distances = face_distances(mesh, SHAPE, mesh.spacing, no_faces(len(mesh.nodes)))
        functions = MovingLeastSquares(self.terms, mesh.nodes, radius, distances)
        return Evaluator(nodes_in_reach(mesh, radius), functions, positive=False)


class MovingLeastSquaresModel(LeastSquaresModel):
    """Moving least squares with a linear basis."""

    terms: ClassVar[int] = LINEAR

    kind: Literal["moving-least-squares"] = "moving-least-squares"


class ModifiedMovingLeastSquaresModel(LeastSquaresModel):
    """Modified moving least squares: a quadratic basis with a small penalty on the quadratic coefficients."""

    terms: ClassVar[int] = QUADRATIC

    kind: Literal["modified-moving-least-squares"] = "modified-moving-least-squares"


@pointwise
def _weigh(fn, x, active, scratch, length):
    """Store the quartic weights of the active nodes at x [m], and their gradients times `length` [m], in `scratch`. Return True
    if a weight is zero because x lies on a face of prescribed displacement.

    fn: `MovingLeastSquares`; active: numbers of the n active nodes.
    """
    offset, distances, taken = scratch.offset, fn.distances, False
    for i in range(len(active)):
        a = active[i]
        square = 0.0
        for d in range(3):
            offset[i, d] = (fn.position[a, d] - x[d]) / length
            square += offset[i, d] * offset[i, d]
        ratio = length / fn.radius[a]
        q = square**0.5 * ratio
        rest = max(1.0 - q, 0.0)
        weight, steep = rest * rest * rest * (1.0 + 3.0 * q), 12.0 * rest * rest * ratio * ratio
        share, gx, gy, gz = 1.0, 0.0, 0.0, 0.0
        if distances.first[a] < distances.first[a + 1]:
            share, gx, gy, gz = share_before_faces(distances, x, a, scratch.faces)
            taken = taken or share == 0.0
        by = weight * length / distances.size[a]
        scratch.log_prior[i] = share * weight
        scratch.slope[i, 0] = share * steep * offset[i, 0] + by * gx
        scratch.slope[i, 1] = share * steep * offset[i, 1] + by * gy
        scratch.slope[i, 2] = share * steep * offset[i, 2] + by * gz
    return taken


@point_function(shape_functions, MovingLeastSquares)
def _shape_functions(functions, cell, x, active, scratch, values, gradients):
    length = functions.radius[active[0]]
    taken = _weigh(functions, x, active, scratch, length)
    return least_squares(functions.terms, functions.distances.flat, taken, length, scratch, values, gradients)
