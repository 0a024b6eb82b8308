"""Corrected gradients: the quadrature of the divergence theorem is exact, and what was reproduced still is."""

import numpy as np
import pytest
from meshes import irregular

from pellucid.approximants.nodal import NODAL_APPROXIMANTS
from pellucid.approximants.nodal.consistency import boundary_integrals, correct
from pellucid.approximants.nodal.table import evaluate
from pellucid.geometry.quadrature import TETRAHEDRON

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
