"""Approximate factors for solids whose own stiffness has too large ones: those of linear tetrahedra on the same nodes.

The tetrahedra are those of the background mesh, with the moduli of the points in them. A node is linked to some 15 others, not
to 150, so that the factors of a compact solid need a fifth of the memory and an eighth to a twentieth of the time. If the
volume ratio is averaged, the tetrahedra have the same unknown pressures at the nodes (Bonet & Burton 1998, Commun. Numer.
Methods Eng. 14, 437), with the volumes around the nodes as functions of the positions of the corners.

Nodal values u of a meshless solid are not the values S u of its field at the nodes, with the shape functions S_ab = p_b(x_a),
but those of linear tetrahedra are. The stiffness of the solid is therefore close to Sᵀ K S with that of the tetrahedra, K. Its
inverse is R K⁻¹ Rᵀ with R = 1 + (1 - S) + (1 - S)², nearly S⁻¹: with maximum entropy, a quarter of the iterations are needed.
Further terms would enlarge displacements of which its field has hardly any trace (eigenvalues of S about 0).

The search for equilibria uses these factors as its first approximation, and corrects them by its iterations: see
`pellucid.simulation.minimum`. Displacements under given forces follow by conjugate gradients with products that are differences
of the forces. No entry of the stiffness itself is computed.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from pellucid.approximants.nodal.linear_simplex import LinearSimplexModel
from pellucid.bodies.meshless_solid.solid import Solid, deformation_gradients
from pellucid.bodies.meshless_solid.stiffness import AveragedStiffness
from pellucid.bodies.own_nodes.stiffness import FREE_SHIFT, conjugate_gradients
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh, in_parts
from pellucid.jit import kernel

ACCURACY = 1e-3
"""Error of displacements under given forces, in the norm of the energy: they are the first estimate of a search, and the
tangents from which works follow, whose errors by the size of the load step are as large."""
SPREADS = 2  # terms of the series that inverts the values of the functions at the nodes, after the first


class LinearTetrahedra(NamedTuple):
    """Linear tetrahedra on the nodes of a solid."""

    mesh: SimplexMesh  # background mesh of the solid
    at_nodes: sparse.csr_array  # values at the nodes of the shape functions of the solid, shape (n, n)


@kernel()
def _assemble(cells, gradients, moduli, entry, place, values):
    """Add the stiffness of linear tetrahedra to `values`.

    cells: corners, shape (c, 4); gradients: of the functions of the corners [1/m], shape (c, 4, 3); moduli: sums over the
    points of a cell, shape (c, 81); entry: entries of `values` of each pair of linked nodes, shape (pairs, d, d); place: index
    of the pair of each two corners, shape (c, 4, 4).
    """
    for c in range(len(cells)):
        A = moduli[c].reshape(3, 3, 3, 3)
        for b in range(4):
            for i in range(3):
                for k in range(3):
                    for J in range(3):
                        x = 0.0
                        for L in range(3):
                            x += A[i, J, k, L] * gradients[c, b, L]
                        for a in range(4):
                            values[entry[place[c, a, b], i, k]] += gradients[c, a, J] * x


@kernel()
def _assemble_volumes(cells, gradients, cofactors, unit, entry, place, values):
    """Add the derivatives of the volumes around the nodes to `values`: a quarter of the volume of each tetrahedron belongs to
    each corner.

    cofactors: sums of w cof F over the points of a cell [m³], shape (c, 3, 3); unit: factor; other arguments as for
    `_assemble`.
    """
    for c in range(len(cells)):
        for b in range(4):
            for k in range(3):
                x = 0.0
                for J in range(3):
                    x += 0.25 * unit * cofactors[c, k, J] * gradients[c, b, J]
                for a in range(4):
                    values[entry[place[c, a, b], 3, k]] += x
                    values[entry[place[c, b, a], k, 3]] += x


class LinearStiffness(AveragedStiffness):
    """Stiffness of linear tetrahedra in the state of the last forces of a solid, as an approximation of its own.

    solid: data of the solid, as in its forces; tetrahedra: linear tetrahedra on its nodes; resisted: function that returns the
    forces with which the solid itself resists displacements from this state [N], for displacements [m], shape (n, 3) both.
    """

    def __init__(self, solid: Solid, tetrahedra: LinearTetrahedra, resisted: Callable[[np.ndarray], np.ndarray]) -> None:
        mesh = tetrahedra.mesh
        super().__init__(solid, mesh.neighbours.copy(), mesh.nodes)
        self._resisted_by_solid = resisted
        evaluator = LinearSimplexModel().evaluator(mesh)
        functions: Any = evaluator.functions
        self._cells, self._gradients = evaluator.active.items.reshape(-1, 4), functions.gradient
        corners = np.repeat(self._cells, 4, axis=1).ravel(), np.tile(self._cells, (1, 4)).ravel()
        self._place = self._pairs(*corners).reshape(-1, 4, 4)
        self._at_nodes, self._at_nodes_turned = tetrahedra.at_nodes, sparse.csr_array(tetrahedra.at_nodes.T)

    def _find(self, dt: float) -> None:
        self._values.fill(0.0)
        given = self._cells, self._gradients
        _assemble(*given, self._moduli(dt, self._solid.n_points), self._entry, self._place, self._values)
        if self._averages:
            unit = self._add_pressures()
            _assemble_volumes(*given, self._cofactors(), unit, self._entry, self._place, self._values)

    def _cofactors(self) -> np.ndarray:
        """Return the sums of w cof F over the points of each cell [m³], shape (cells, 3, 3)."""
        solid, n = self._solid, len(self._cells)
        F = deformation_gradients(solid, n)
        weights = solid.weights[: n * solid.n_points].reshape(n, -1)
        found = np.empty((n, 3, 3))
        for some in in_parts(n):
            for row in range(3):
                one, other = F[some, :, (row + 1) % 3], F[some, :, (row + 2) % 3]
                found[some, row] = (weights[some, :, None] * np.cross(one, other)).sum(axis=1)
        return found

    def solve(self, force: np.ndarray) -> np.ndarray:
        of_field = self._unspread(self._at_nodes_turned, np.where(self._free[:, :3], force, 0.0))
        return self._unspread(self._at_nodes, super().solve(of_field))

    def _unspread(self, at_nodes: sparse.csr_array, given: np.ndarray) -> np.ndarray:
        """Return the solution of S x = given, nearly, for the values S of the functions at the nodes or their transpose, shape
        (n, n), and free components, shape (n, 3): the first terms of the series of powers of 1 - S."""
        free, found = self._free[:, :3], given
        matrix: Any = at_nodes
        for _ in range(SPREADS):
            found = given + np.where(free, found - matrix @ found, 0.0)
        return found

    def follow(self, force: np.ndarray, prescribed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        free, given = self._free[:, :3], np.zeros_like(force)
        if prescribed.any():
            given = self._resisted_by_solid(prescribed)

        def resisted(moved: np.ndarray) -> np.ndarray:
            found = self._resisted_by_solid(moved)
            if self._motions:
                found += FREE_SHIFT * self._weights[:, :3] * moved
            return np.where(free, found, 0.0)

        right = np.where(free, force - given, 0.0)
        found = prescribed + conjugate_gradients(resisted, self.solve, right, ACCURACY)
        return found, self._resisted_by_solid(found)
