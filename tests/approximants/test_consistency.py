"""Corrected gradients: the quadrature of the divergence theorem is exact, and what was reproduced still is."""

import numpy as np
import pytest
from meshes import irregular
from scipy import sparse

from pellucid.approximants.nodal import NODAL_APPROXIMANTS, two_level
from pellucid.approximants.nodal.consistency import boundary_integrals, correct, make_fits, system
from pellucid.approximants.nodal.table import evaluate
from pellucid.geometry.meshes.quadrature import TETRAHEDRON
from pellucid.jit import set_threads

# of the gradients themselves: quadratic moments are regular by a penalty of 1e-7, which costs that many digits
ROUNDING = {"modified-moving-least-squares": 1e-8}


@pytest.mark.parametrize("points", [1, 4])
@pytest.mark.parametrize("kind", [kind for kind in NODAL_APPROXIMANTS.entries if kind != "linear-simplex"])
def test_the_divergence_theorem_holds_after_the_correction(kind, points):
    mesh = irregular(3, 3)
    evaluator = NODAL_APPROXIMANTS.entries[kind]().evaluator(mesh)
    rule = TETRAHEDRON[points]
    places = np.einsum("qk,cki->cqi", rule, mesh.nodes[mesh.cells]).reshape(-1, 3)
    weights = np.repeat(mesh.volumes / points, points)
    rows = evaluate(evaluator, np.repeat(np.arange(len(mesh.cells)), points), places)
    exact = boundary_integrals(mesh, evaluator)

    def error():
        total = np.zeros_like(exact)
        for k in range(len(places)):
            nodes, _, slopes = rows.at(k)
            total[nodes] += weights[k] * slopes.T
        return abs(total - exact).max() / abs(exact).max()

    assert error() > 1e-3, "quadrature alone is not consistent"
    correct(mesh, evaluator, rows, weights)
    assert error() < 1e-11
    for k in range(len(places)):
        nodes, _, slopes = rows.at(k)
        assert slopes.sum(axis=1) == pytest.approx(0.0, abs=ROUNDING.get(kind, 1e-11))
        assert slopes @ mesh.nodes[nodes] == pytest.approx(np.eye(3), abs=ROUNDING.get(kind, 1e-11))


def test_linear_functions_are_consistent_as_they_are():
    mesh = irregular(3, 3)
    evaluator = NODAL_APPROXIMANTS.entries["linear-simplex"]().evaluator(mesh)
    rows = evaluate(evaluator, np.arange(len(mesh.cells)), mesh.nodes[mesh.cells].mean(axis=1))
    total = np.zeros((len(mesh.nodes), 3))
    for k, volume in enumerate(mesh.volumes):
        nodes, _, slopes = rows.at(k)
        total[nodes] += volume * slopes.T
    assert total == pytest.approx(boundary_integrals(mesh, evaluator), abs=1e-14)


def rows_of(mesh, points):
    """An evaluator with its rows at quadrature points, and the weights of these."""
    evaluator = NODAL_APPROXIMANTS.entries["cell-based-maximum-entropy"]().evaluator(mesh)
    places = np.einsum("qk,cki->cqi", TETRAHEDRON[points], mesh.nodes[mesh.cells]).reshape(-1, 3)
    rows = evaluate(evaluator, np.repeat(np.arange(len(mesh.cells)), points), places)
    return evaluator, rows, np.repeat(mesh.volumes / points, points)


def system_of(n):
    mesh = irregular(n, 3)
    evaluator, rows, weights = rows_of(mesh, 1)
    return mesh, rows, weights, system(make_fits(mesh.nodes, evaluator.active, rows, weights))


def test_the_system_is_what_affine_fits_leave():
    mesh, rows, weights, matrix = system_of(3)
    eta = np.random.default_rng(5).normal(size=len(mesh.nodes))
    expected = np.zeros(len(eta))
    for k, weight in enumerate(weights):  # weighted least squares, point by point
        nodes, shares, _ = rows.at(k)
        root, linear = np.sqrt(shares), np.column_stack([np.ones(len(nodes)), mesh.nodes[nodes]])
        fit = np.linalg.lstsq(root[:, None] * linear, root * eta[nodes], rcond=None)[0]
        expected[nodes] += weight * shares * (eta[nodes] - linear @ fit)
    assert matrix @ eta == pytest.approx(expected, abs=1e-13 * abs(expected).max())


class Counted(sparse.csr_array):
    products = 0

    def __matmul__(self, other):
        type(self).products += 1
        return super().__matmul__(other)


@pytest.mark.parametrize("n", [4, 8, 12])
def test_the_system_is_solved_in_as_many_iterations_whatever_its_size(n):
    mesh, _, _, matrix = system_of(n)
    wanted = matrix @ np.random.default_rng(6).normal(size=(len(mesh.nodes), 3))
    counted, Counted.products = Counted(matrix), 0
    found = two_level.solve(counted, wanted, mesh.nodes)
    assert matrix @ found == pytest.approx(wanted, abs=1e-12 * abs(wanted).max())
    assert Counted.products < 90, "with the diagonal alone 52, 136 and 254"


def test_a_system_without_a_solution_is_refused():
    mesh, _, _, matrix = system_of(4)
    broken = sparse.csr_array(sparse.diags_array(np.arange(len(mesh.nodes)) % 2 * 1.0) @ matrix)
    with pytest.raises(ValueError, match="the relative residual is"):
        two_level.solve(broken, np.ones((len(mesh.nodes), 1)) * mesh.nodes[:, :1] ** 2, mesh.nodes)


def test_the_correction_has_the_same_bits_on_any_number_of_threads():
    mesh, found = irregular(6, 3), []
    for threads in (1, 2, 4):
        set_threads(threads)
        evaluator, rows, weights = rows_of(mesh, 1)
        correct(mesh, evaluator, rows, weights)
        found.append(rows.gradients.tobytes())
    assert found[0] == found[1] == found[2]
