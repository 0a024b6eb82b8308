"""Partition of unity, linear reproduction, gradients, positivity and boundaries, for every registered nodal approximant."""

from typing import NamedTuple

import numpy as np
import pytest
from meshes import irregular, points_within

from pellucid.approximants.nodal import NODAL_APPROXIMANTS
from pellucid.approximants.nodal.contract import Evaluator, NodalApproximant, NoFunctions
from pellucid.approximants.nodal.table import evaluate
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh

N = 60


class Held(NamedTuple):
    """An approximant whose functions vanish on a part of the face where x is 0."""

    of: NodalApproximant

    @property
    def kind(self):
        return self.of.kind

    def evaluator(self, mesh):
        corners = mesh.nodes[mesh.faces[0][mesh.boundary]]
        patch = mesh.boundary[(corners[:, :, 0] == 0.0).all(axis=1) & (corners[:, :, 1] < 0.6 * corners.max()).all(axis=1)]
        plain = self.of.evaluator(mesh)
        return self.of.vanishing(plain, mesh, *strangers(plain, mesh, patch))


OTHERS = {
    "cell-based-maximum-entropy": [{"rings": 1}, {"rings": 3}, {"smoothness": 4.0, "shape": 2.0}, {"smoothness": 3.0}],
    "moving-least-squares": [{"dilatation": 2.0}],
}
# of gradients of linear fields: derivatives of solutions of small linear systems. Quadratic moments at the edge of
# what 1.6 spacings reach are regular by the penalty of 1e-7 alone, which costs that many more digits
ROUNDING = {"modified-moving-least-squares": 1e-8}


VANISH = {
    "cell-based-maximum-entropy": 0.05,
    "local-maximum-entropy": 0.005,
    "cell-based-least-squares": 0.03,
    "moving-least-squares": 0.003,
    "modified-moving-least-squares": 0.005,
}
"""Those that can vanish on parts of a face, and how far neighbours reach into one at least where they do not."""


def strangers(evaluator: Evaluator, mesh, patch):
    """Active nodes that are on none of the faces of a patch, and faces of it on which they are active."""
    faces, owners = mesh.faces
    first, node = evaluator.active.of(owners[patch, 0])
    away = ~np.isin(node, faces[patch])
    return node[away], np.repeat(patch, np.diff(first))[away]


def registered():
    for kind, model in NODAL_APPROXIMANTS.entries.items():
        for number, settings in enumerate([{}, *OTHERS.get(kind, [])]):
            yield pytest.param(model(**settings), id=f"{kind}-{number}")


every_approximant = pytest.mark.parametrize("approximant", list(registered()))
held = [pytest.param(Held(NODAL_APPROXIMANTS.entries[kind]()), id=f"{kind}-held") for kind in VANISH]
with_held = pytest.mark.parametrize("approximant", [*registered(), *held])
every_dimension = pytest.mark.parametrize("dimension", [2, 3])
MESHES = {dimension: irregular(4, dimension) for dimension in (2, 3)}


def gradients(approximant, mesh, cells, points):
    """Values and gradients at points as dense arrays, shapes (m, n) and (m, 3, n)."""
    rows = evaluate(approximant.evaluator(mesh), cells, points)
    values, slopes = np.zeros((len(cells), len(mesh.nodes))), np.zeros((len(cells), 3, len(mesh.nodes)))
    for k in range(len(cells)):
        nodes, values_here, slopes_here = rows.at(k)
        values[k, nodes], slopes[k][:, nodes] = values_here, slopes_here
    return values, slopes


@every_dimension
@with_held
def test_one_and_linear_fields_are_reproduced(approximant, dimension):
    mesh = MESHES[dimension]
    cells, points = points_within(mesh, N)
    values, slopes = gradients(approximant, mesh, cells, points)
    rounding = ROUNDING.get(approximant.kind, 1e-12)
    assert values.sum(axis=1) == pytest.approx(1.0, abs=rounding)
    assert values @ mesh.nodes == pytest.approx(points, abs=rounding)
    inverse_length = 4.0 / rounding**0.1  # of the thinnest cells
    assert slopes.sum(axis=2) == pytest.approx(0.0, abs=inverse_length * rounding)
    identity = np.diag([1.0, 1.0, float(dimension == 3)])
    assert slopes @ mesh.nodes == pytest.approx(np.broadcast_to(identity, (N, 3, 3)), abs=inverse_length * rounding)


@every_dimension
@with_held
def test_gradients_are_those_of_the_values(approximant, dimension):
    mesh = MESHES[dimension]
    cells, points = points_within(mesh, N)
    _, slopes = gradients(approximant, mesh, cells, points)
    step = 1e-5  # of the unit square: the error of central differences is its square times third derivatives
    for axis in range(dimension):
        shift = step * np.eye(3)[axis]
        difference = (
            (gradients(approximant, mesh, cells, points + shift)[0]) - gradients(approximant, mesh, cells, points - shift)[0]
        )
        scale = 1.0 + abs(slopes).max(axis=(1, 2))
        assert (abs(difference / (2.0 * step) - slopes[:, axis]).max(axis=1) < 1e-5 * scale**3 / 4.0**2).all()


@every_dimension
@with_held
def test_functions_do_not_depend_on_the_unit_of_length(approximant, dimension):
    mesh = MESHES[dimension]
    cells, points = points_within(mesh, N)
    values, slopes = gradients(approximant, mesh, cells, points)
    small = SimplexMesh(1e-6 * mesh.nodes, mesh.cells)
    others, steeper = gradients(approximant, small, cells, 1e-6 * points)
    rounding = ROUNDING.get(approximant.kind, 1e-11)
    assert others == pytest.approx(values, abs=rounding)
    assert 1e-6 * steeper == pytest.approx(slopes, abs=rounding * (1.0 + abs(slopes).max()) ** 2)


@every_dimension
@pytest.mark.parametrize("kind", ["cell-based-maximum-entropy", "local-maximum-entropy", "linear-simplex"])
def test_maximum_entropy_and_linear_functions_are_positive(kind, dimension):
    mesh = MESHES[dimension]
    values, _ = gradients(NODAL_APPROXIMANTS.entries[kind](), mesh, *points_within(mesh, N))
    assert values.min() >= 0.0


def on_face(mesh, axis, n=40):
    """Points on the face where a coordinate is 0, with cells that have them."""
    faces, owners = mesh.faces
    there = mesh.boundary[(mesh.nodes[faces[mesh.boundary]][:, :, axis] == 0.0).all(axis=1)]
    rng = np.random.default_rng(2)
    chosen = there[rng.integers(len(there), size=n)]
    shares = rng.dirichlet(np.full(mesh.dimension, 2.0), n)
    return owners[chosen, 0], np.einsum("ka,kad->kd", shares, mesh.nodes[faces[chosen]])


@every_dimension
@every_approximant
def test_nodes_off_a_flat_face_have_no_part_in_the_field_on_it(approximant, dimension):
    mesh = MESHES[dimension]
    cells, points = on_face(mesh, 0)
    rows = evaluate(approximant.evaluator(mesh), cells, points, gradients=False)
    others = max(abs(values[mesh.nodes[nodes, 0] > 0.0]).max(initial=0.0) for nodes, values, _ in map(rows.at, range(40)))
    assert (others < 1e-11) == approximant.evaluator(mesh).positive


def test_one_ring_of_maximum_entropy_is_the_linear_simplex():
    for mesh in MESHES.values():
        cells, points = points_within(mesh, N)
        one = gradients(NODAL_APPROXIMANTS.entries["cell-based-maximum-entropy"](rings=1), mesh, cells, points)
        linear = gradients(NODAL_APPROXIMANTS.entries["linear-simplex"](), mesh, cells, points)
        assert one[0] == pytest.approx(linear[0], abs=1e-12)
        assert one[1] == pytest.approx(linear[1], abs=1e-10)  # gradients by cancellation of steep priors


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", VANISH)
def test_a_constrained_part_of_a_face_takes_the_prescribed_field(kind, dimension):
    mesh = MESHES[dimension]
    faces, owners = mesh.faces
    corners = mesh.nodes[faces[mesh.boundary]]
    patch = mesh.boundary[(corners[:, :, 0] == 0.0).all(axis=1) & (corners[:, :, 1] < 0.6).all(axis=1)]
    approximant = NODAL_APPROXIMANTS.entries[kind]()
    plain = approximant.evaluator(mesh)
    nodes = np.unique(faces[patch])
    field = np.isin(np.arange(len(mesh.nodes)), nodes).astype(float)
    points = mesh.nodes[faces[patch]].mean(axis=1)

    def error(evaluator: Evaluator) -> float:
        rows = evaluate(evaluator, owners[patch, 0], points, gradients=False)
        return max(abs(values @ field[active] - 1.0) for active, values, _ in map(rows.at, range(len(patch))))

    assert error(plain) > VANISH[kind], "nodes beside the patch reach in"
    assert error(approximant.vanishing(plain, mesh, *strangers(plain, mesh, patch))) < 1e-12


def test_too_few_neighbours_are_named():
    mesh = MESHES[3]
    approximant = NODAL_APPROXIMANTS.entries["moving-least-squares"](dilatation=1.01)
    lonely = SimplexMesh(mesh.nodes[mesh.cells[0]], np.array([[0, 1, 2, 3]]))
    cells, points = np.zeros(1, np.int64), lonely.nodes[:1] * 0.97 + 0.03 * lonely.nodes.mean(axis=0)
    with pytest.raises(NoFunctions, match=r"no shape functions at \(.*\) m: the moment matrix is singular: there are too few"):
        evaluate(approximant.evaluator(lonely), cells, points)


@every_approximant
def test_the_nodes_in_a_cell_are_about_as_many_as_stated(approximant):
    mesh = irregular(14, 3)
    within = (abs(mesh.nodes[mesh.cells].mean(axis=1) - 0.5) < 0.12).all(axis=1)
    count = np.diff(approximant.evaluator(mesh).active.first)[within]
    assert approximant.nodes_in_a_cell == pytest.approx(count.mean(), rel=0.5)
