"""Delta property, partition of unity, polynomials, derivatives, units and order of curvature, of every radial function."""

import numpy as np
import pytest
from pydantic import ValidationError

from pellucid.approximants.radial import RADIAL_FUNCTIONS
from pellucid.approximants.radial.stencils import Monomials, StencilError, along_curve, functions_at, interpolants, on_surface
from pellucid.geometry.surfaces.triangles import Icosphere

STENCILS = 30
OTHERS = {
    "polyharmonic": [{"power": 3, "degree": 1}, {"power": 7}, {"degree": 2}, {"degree": 6}],
    "thin-plate": [{"order": 1, "degree": 1}, {"order": 3}],
    "multiquadric": [{"shape": 0.5, "degree": 2}, {"degree": 0}],
    "gaussian": [{"shape": 0.5, "degree": 2}, {"degree": 0}],
}


def registered():
    for kind, model in RADIAL_FUNCTIONS.entries.items():
        for number, settings in enumerate([{}, *OTHERS.get(kind, [])]):
            yield pytest.param(model(**settings), id=f"{kind}-{number}")


every_function = pytest.mark.parametrize("radial", list(registered()))
every_dimension = pytest.mark.parametrize("dimension", [1, 2])


def stencils(radial, dimension, spacing=1.0):
    """Nodes of a lattice about one of them, each moved by up to 0.3 of the spacing, and places between them."""
    rng, size = np.random.default_rng(3), radial.stencil_size(dimension)
    reach = np.arange(-size, size + 1) if dimension == 1 else np.arange(-5, 6)
    lattice = np.stack(np.meshgrid(*[reach] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    nodes = lattice + rng.uniform(-0.3, 0.3, (STENCILS, *lattice.shape))
    order = np.argsort((nodes**2).sum(axis=2), axis=1)[:, :size]
    places = rng.uniform(-0.7, 0.7, (STENCILS, 5, dimension))
    return spacing * np.take_along_axis(nodes, order[:, :, None], axis=1), spacing * places


def stencil_functions(nodes, places, radial, derivatives=2):
    """The shape functions of stencils with nodes (s, m, d) at places (s, q, d) [m]."""
    return functions_at(interpolants(nodes, radial), places, derivatives=derivatives)


def most(radial):
    """As many derivatives as it has."""
    return min(radial.derivatives, 2)


@every_dimension
@every_function
def test_functions_are_one_at_their_node_and_zero_at_the_others(radial, dimension):
    nodes, _ = stencils(radial, dimension)
    value = stencil_functions(nodes, nodes, radial, derivatives=1).value
    assert value == pytest.approx(np.broadcast_to(np.eye(nodes.shape[1]), value.shape), abs=1e-10)


@every_dimension
@every_function
def test_polynomials_up_to_the_degree_are_reproduced_with_their_derivatives(radial, dimension):
    nodes, places = stencils(radial, dimension)
    size = np.abs(nodes).max()
    found = stencil_functions(nodes / size, places / size, radial, derivatives=most(radial))
    at_nodes, at_places = Monomials(nodes / size, radial.degree).value, Monomials(places / size, radial.degree)
    assert found.value.sum(axis=2) == pytest.approx(1.0, abs=1e-12)
    assert found.value @ at_nodes == pytest.approx(at_places.value, abs=1e-12)
    assert np.einsum("sqdm,smp->sqdp", found.first, at_nodes) == pytest.approx(at_places.first, abs=1e-11)
    if most(radial) == 2:
        second = np.einsum("sqdem,smp->sqdep", found.second, at_nodes)
        assert second == pytest.approx(at_places.second, abs=1e-10)


@every_dimension
@every_function
def test_derivatives_are_those_of_the_values(radial, dimension):
    nodes, places = stencils(radial, dimension)
    found, step = interpolants(nodes, radial), 1e-4
    exact = functions_at(found, places, derivatives=most(radial))
    for axis in range(dimension):
        shift = step * np.eye(dimension)[axis]
        after, before = (functions_at(found, places + sign * shift, derivatives=1) for sign in (1.0, -1.0))
        # third derivatives of lattices of spacing 1 are below 100, but for those of r² ln r and r³ close to a node
        rough = 1e-3 if radial.derivatives < 3 else 1e-6
        assert (after.value - before.value) / (2.0 * step) == pytest.approx(exact.first[:, :, axis], abs=rough)
        if most(radial) == 2:
            difference = (after.first - before.first) / (2.0 * step)
            assert difference == pytest.approx(exact.second[:, :, axis], abs=10.0 * rough)


@every_dimension
@every_function
def test_functions_do_not_depend_on_the_unit_of_length_or_the_origin(radial, dimension):
    nodes, places = stencils(radial, dimension)
    found = stencil_functions(nodes, places, radial, derivatives=1)
    small = stencil_functions(2.0**-20 * nodes, 2.0**-20 * places, radial, derivatives=1)
    assert np.array_equal(small.value, found.value)
    assert np.array_equal(2.0**-20 * small.first, found.first)
    moved = stencil_functions(nodes + 3.0, places + 3.0, radial, derivatives=1)
    assert moved.value == pytest.approx(found.value, abs=1e-8)  # rounding of the places times the condition number


@every_dimension
@every_function
def test_a_stencil_is_the_same_alone_and_among_others(radial, dimension):
    nodes, places = stencils(radial, dimension)
    found = functions_at(interpolants(nodes, radial), places[:2], of=np.array([7, 3]), derivatives=1)
    for number, stencil in enumerate((7, 3)):
        alone = stencil_functions(nodes[[stencil]], places[[number]], radial, derivatives=1)
        assert alone.value[0] == pytest.approx(found.value[number], abs=1e-13)


def test_a_quadratic_function_is_interpolated_as_in_the_thesis():
    """x² + x + 2 on 21 nodes (Benet 2015, section 4.0.2: 3.5e-15)."""
    x = np.linspace(0.0, 1.0, 21)[:, None]
    field = x[:, 0] ** 2 + x[:, 0] + 2.0
    for kind in RADIAL_FUNCTIONS.entries.values():
        radial = kind()
        near = along_curve(x, radial.stencil_size(1), closed=False)
        places = np.linspace(-0.025, 0.025, 9)[None, :, None].repeat(21, axis=0)
        found = stencil_functions(near.coordinates, places, radial)
        where = x + places[:, :, 0]
        values = np.einsum("sqm,sm->sq", found.value, field[near.nodes])
        slopes = np.einsum("sqdm,sm->sq", found.first, field[near.nodes])
        assert values == pytest.approx(where**2 + where + 2.0, abs=1e-14)
        assert slopes == pytest.approx(2.0 * where + 1.0, abs=1e-12)


def test_as_many_nodes_as_polynomials_give_the_interpolation_of_lagrange():
    radial = RADIAL_FUNCTIONS.entries["polyharmonic"](degree=4, neighbours=5)
    nodes, places = stencils(radial, 1)
    found = stencil_functions(nodes, places, radial).value
    for k in range(STENCILS):
        x, at = nodes[k, :, 0], places[k, :, 0]
        for j in range(5):
            others = np.delete(x, j)
            assert found[k, :, j] == pytest.approx(np.prod((at[:, None] - others) / (x[j] - others), axis=1), abs=1e-11)


def curvature_error(radial, refinements):
    """Of twice the mean curvature of a unit sphere, from heights over the tangent planes; nodes moved by up to a fifth."""
    points = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=refinements).mesh().vertices
    spacing = np.sqrt(4.0 * np.pi / len(points))
    points = points + 0.2 * spacing * np.random.default_rng(5).uniform(-1.0, 1.0, points.shape)
    points /= np.linalg.norm(points, axis=1)[:, None]
    near = on_surface(points, points, radial.stencil_size(2))
    heights = np.einsum("nmk,nk->nm", points[near.nodes] - points[:, None], points)
    second = stencil_functions(near.coordinates, np.zeros((len(points), 1, 2)), radial).second
    return np.sqrt(np.mean((np.einsum("sqddm,sm->s", second, heights) + 2.0) ** 2))


@pytest.mark.parametrize("kind", list(RADIAL_FUNCTIONS.entries))
def test_curvature_of_a_sphere_converges(kind):
    """Polynomials of degree 4 leave an error of order 3 in second derivatives; a sphere has no odd terms, so of order 4."""
    radial = RADIAL_FUNCTIONS.entries[kind]()
    coarse, fine = curvature_error(radial, 3), curvature_error(radial, 4)
    assert np.log2(coarse / fine) > 3.8
    assert fine < 6e-5


def test_the_degree_sets_the_order():
    """Degree 2: order 1 in second derivatives, and 2 on a sphere."""
    radial = RADIAL_FUNCTIONS.entries["polyharmonic"](degree=2)
    assert np.log2(curvature_error(radial, 3) / curvature_error(radial, 4)) == pytest.approx(2.0, abs=0.2)


def ellipse_error(radial, n):
    """Of the curvature of an ellipse through unevenly spread points, over its largest."""
    angle = 2.0 * np.pi * (np.arange(n) + np.random.default_rng(n).uniform(-0.2, 0.2, n)) / n
    points = np.stack([2.0 * np.cos(angle), np.sin(angle)], axis=1)
    near = along_curve(points, radial.stencil_size(1), closed=True)
    found = stencil_functions(near.coordinates, np.zeros((n, 1, 1)), radial)
    first = np.einsum("sqdm,smk->sk", found.first, points[near.nodes])
    second = np.einsum("sqdem,smk->sk", found.second, points[near.nodes])
    curvature = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / np.linalg.norm(first, axis=1) ** 3
    exact = 2.0 / (4.0 * np.sin(angle) ** 2 + np.cos(angle) ** 2) ** 1.5
    return np.sqrt(np.mean((curvature - exact) ** 2)) / 2.0


def test_curvature_of_an_ellipse_converges():
    """Third order at least: degree 4, second derivatives."""
    radial = RADIAL_FUNCTIONS.entries["polyharmonic"]()
    errors = [ellipse_error(radial, n) for n in (40, 80, 160)]
    assert np.log2(errors[1] / errors[2]) > 3.0
    assert errors[2] < 1e-4


def test_ill_conditioned_systems_raise_the_shape_parameter():
    """Gaussians alone on a line of 15 nodes have a condition number above 1e20 with ε = 1."""
    radial = RADIAL_FUNCTIONS.entries["gaussian"](degree=0, neighbours=15)
    found = interpolants(stencils(radial, 1)[0], radial)
    assert found.shape.min() > 1.0
    squares = ((found.nodes[:, :, None] - found.nodes[:, None]) ** 2).sum(axis=3)
    kernel = radial.profile(squares, found.shape[:, None, None]).value
    assert np.linalg.cond(kernel).max() < 1e12
    assert interpolants(stencils(radial, 2)[0], radial).shape.max() == 1.0


def test_stencils_on_a_curve():
    x = np.arange(9.0)[:, None]
    open_ = along_curve(x, 4, closed=False)
    assert open_.nodes[0].tolist() == [0, 1, 2, 3]
    assert open_.nodes[4].tolist() == [2, 3, 4, 5]
    assert open_.nodes[8].tolist() == [5, 6, 7, 8]
    assert open_.coordinates[8, :, 0].tolist() == [-3, -2, -1, 0]
    angle = np.arange(20) * np.pi / 10.0
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    closed = along_curve(circle, 5, closed=True)
    assert closed.nodes[0].tolist() == [18, 19, 0, 1, 2]
    assert closed.coordinates[0, :, 0] == pytest.approx(np.sin(angle[[18, 19, 0, 1, 2]]), abs=1e-15)


def test_stencils_on_a_surface_do_not_reach_to_another_sheet():
    """Two flat sheets, nearer to each other than their points."""
    u, v = np.meshgrid(np.arange(8.0), np.arange(8.0), indexing="ij")
    sheet = np.stack([u.ravel(), v.ravel(), np.zeros(64)], axis=1)
    points = np.concatenate([sheet, sheet + np.array([0.0, 0.0, 0.1])])
    normals = np.repeat([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], 64, axis=0)
    near = on_surface(points, normals, 12)
    assert (near.nodes[:64] < 64).all()
    assert (near.nodes[64:] >= 64).all()
    assert (near.nodes[:, 0] == np.arange(128)).all()
    distance = np.linalg.norm(near.coordinates, axis=2)
    assert distance == pytest.approx(np.linalg.norm(points[near.nodes] - points[:, None], axis=2), abs=1e-14)


@pytest.mark.parametrize(
    ("nodes", "words"),
    [
        (np.array([[0, 0], [1, 0], [2, 0], [3, 0], [0, 0.5], [1, 0.5], [2, 0.5]]), "do not determine polynomials of degree 2"),
        (np.array([[0, 0], [1, 0], [0, 1], [1, 1]]), "has 4 nodes, too few for the 6 polynomials of degree 2"),
        (np.array([[0, 0], [1, 0], [0, 1], [2, 1], [1, 2], [2, 2.5], [1, 1e-9]]), "has two .nearly. coincident nodes"),
        (np.zeros((7, 2)), "has only coincident nodes"),
    ],
)
def test_stencils_without_an_interpolant_are_named(nodes, words):
    good = np.random.default_rng(1).uniform(size=nodes.shape)
    radial = RADIAL_FUNCTIONS.entries["polyharmonic"](degree=2)
    several = np.stack([nodes if "few" in words else good, nodes, good]).astype(float)
    with pytest.raises(StencilError, match=words) as error:
        stencil_functions(several, several[:, :1], radial)
    assert error.value.number == (0 if "few" in words else 1)


def test_too_few_points_and_folded_stencils_are_named():
    with pytest.raises(StencilError, match="needs 7 points, but the curve has 5"):
        along_curve(np.arange(5.0)[:, None], 7, closed=False)
    angle = np.arange(8) * np.pi / 4.0
    with pytest.raises(StencilError, match="too wide for the curvature of the curve"):
        along_curve(np.stack([np.cos(angle), np.sin(angle)], axis=1), 7, closed=True)
    sphere = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=0).mesh().vertices
    with pytest.raises(StencilError, match="needs 21 points, but the surface has 12"):
        on_surface(sphere, sphere, 21)
    with pytest.raises(StencilError, match="too wide for the curvature of the surface"):
        on_surface(sphere, sphere, 9)


def test_second_derivatives_of_the_thin_plate_are_refused():
    radial = RADIAL_FUNCTIONS.entries["thin-plate"](order=1)
    nodes, places = stencils(radial, 2)
    with pytest.raises(
        ValueError, match="has only 1 derivative at its nodes, but 2 are needed; use a smoother radial function"
    ):
        stencil_functions(nodes, places, radial)


@pytest.mark.parametrize(
    ("kind", "degree", "least"),
    [("polyharmonic", 1, 2), ("thin-plate", 1, 2), ("multiquadric", None, 0), ("gaussian", None, -1)],
)
def test_a_degree_without_interpolants_is_refused(kind, degree, least):
    model = RADIAL_FUNCTIONS.entries[kind]
    assert model().least_degree == least
    if degree is not None:
        with pytest.raises(ValidationError, match=f"`degree` = {degree} is too low.*to {least} or more"):
            model(degree=degree)
