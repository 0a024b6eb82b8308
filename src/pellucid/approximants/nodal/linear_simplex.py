"""Linear functions on simplices: linear finite elements, as a reference for the other approximants."""

from typing import ClassVar, Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import OK, Evaluator, NodalApproximant, shape_functions
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import point_function


class LinearSimplex(NamedTuple):
    """Parameters of linear shape functions on c triangles (d = 2) or tetrahedra (d = 3), for kernels."""

    gradient: np.ndarray  # (c, d + 1, 3) gradients of the functions of each cell's corners, in ascending order [1/m]
    middle: np.ndarray  # (c, 3) centres of the cells [m]


class LinearSimplexModel(NodalApproximant):
    """Linear triangles or tetrahedra."""

    follows_cells: ClassVar[bool] = True

    kind: Literal["linear-simplex"] = "linear-simplex"

    @property
    def nodes_in_a_cell(self) -> float:
        return 4.0

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        from pellucid.approximants.nodal.rings import nodes_of_cells  # scipy is slow to import

        active, d = nodes_of_cells(mesh, 1), mesh.dimension
        corners = mesh.nodes[active.items.reshape(-1, d + 1)]
        inverse = np.linalg.inv(corners[:, 1:, :d] - corners[:, :1, :d])
        gradient = np.zeros((len(corners), d + 1, 3))
        gradient[:, 1:, :d] = np.swapaxes(inverse, 1, 2)
        gradient[:, 0] = -gradient[:, 1:].sum(axis=1)
        return Evaluator(active, LinearSimplex(gradient, corners.mean(axis=1)))


@point_function(shape_functions, LinearSimplex)
def _shape_functions(functions, cell, x, active, scratch, values, gradients):
    n = len(active)
    for a in range(n):
        values[a] = 1.0 / n
        for j in range(3):
            slope = functions.gradient[cell, a, j]
            values[a] += slope * (x[j] - functions.middle[cell, j])
            if gradients.shape[1] > 0:
                gradients[j, a] = slope
    return OK
