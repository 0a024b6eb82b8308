import numpy as np
import pytest
from film_surfaces import BOTH, loop, scattered, sphere, torus

from pellucid.bodies.fluid_film.loop_surface import VALUE, LoopSurface, _functions
from pellucid.bodies.fluid_film.triangle_surface import SIX
from pellucid.errors import RunStopped

EGG = (1.0, 0.8, 1.3)


def egg(kind):
    """A surface without symmetry."""
    triangles, places = sphere(2)
    return BOTH[kind]((triangles, places * EGG + 0.1 * places[:, [2]] ** 2))


def rates(rows, v, nodes):
    return np.einsum("eq...mi,emi->eq...", rows, v[nodes])


@pytest.mark.parametrize("kind", BOTH)
def test_rigid_motions_strain_nothing_and_bend_nothing(kind):
    surface, x = egg(kind)
    o = surface.operators(x)
    for v in (np.tile([0.3, -1.0, 0.5], (len(x), 1)), np.cross([0.4, 0.2, -0.7], x)):
        assert np.abs(rates(o.strain, v, surface.nodes)).max() < 1e-13
        assert np.abs(rates(o.bending, v, surface.nodes)).max() < 1e-11  # second derivatives are larger by 1/h


@pytest.mark.parametrize("kind", BOTH)
def test_rows_are_the_changes_of_area_curvature_and_normal(kind):
    surface, x = egg(kind)
    o, v, h = surface.operators(x), np.random.default_rng(1).normal(size=x.shape), 1e-6
    more, less = surface.operators(x + h * v), surface.operators(x - h * v)
    assert np.allclose(np.log(more.area / less.area) / (2.0 * h), rates(o.dilatation(), v, surface.nodes), atol=1e-7, rtol=1e-6)
    bent = rates(o.bending, v, surface.nodes)
    assert np.abs((more.curvature - less.curvature) / (2.0 * h) - bent).max() < 1e-6 * np.abs(bent).max()
    turned = np.linalg.norm((more.normal - less.normal) / (2.0 * h), axis=2)
    sloped = rates(o.slope, v, surface.nodes)
    # δn = -(n·v|i) e_i at rest; along the frame both have the same size
    assert np.abs(turned - np.linalg.norm(sloped, axis=2)).max() < 1e-6 * turned.max()


@pytest.mark.parametrize("kind", BOTH)
def test_shear_in_the_frame_is_that_of_the_metric(kind):
    surface, x = egg(kind)
    o, v, h = surface.operators(x), np.random.default_rng(2).normal(size=x.shape), 1e-6

    def metric(x):
        a = np.einsum("epdm,emi->epdi", surface.tables.first[surface.tables.kind], x[surface.nodes])
        return np.einsum("epai,epbi->epab", a, a)

    g, change = metric(x), (metric(x + h * v) - metric(x - h * v)) / (2.0 * h)
    mixed = np.linalg.solve(g, change)  # twice the rate of deformation; its invariants do not depend on the frame
    D = rates(o.strain, v, surface.nodes)
    square = 4.0 * (D[..., 0] ** 2 + D[..., 1] ** 2) + 2.0 * D[..., 2] ** 2
    assert np.allclose(np.einsum("epab,epba->ep", mixed, mixed), square, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("kind", BOTH)
def test_functions_are_a_partition_of_unity(kind):
    surface, _ = egg(kind)
    assert np.abs(surface.tables.value.sum(axis=-1) - 1.0).max() < 1e-13
    assert np.abs(surface.tables.first.sum(axis=-1)).max() < 1e-12
    assert np.abs(surface.tables.second.sum(axis=-1)).max() < 1e-10


@pytest.mark.parametrize("kind", BOTH)
def test_places_of_nodes_lie_on_the_surface(kind):
    surface, x = egg(kind)
    places, t = surface.places(x), np.arange(len(surface.rings.triangles))
    assert np.allclose(surface.through(places), x, atol=1e-13)
    for corner in range(3):
        share = np.eye(3)[np.full(len(t), corner)]
        assert np.allclose(surface.at(x, t, share), places[surface.rings.triangles[:, corner]], atol=2e-9)


@pytest.mark.parametrize(("kind", "order", "largest"), [("loop", 2.0, 2e-4), ("radial", 5.0, 6e-5)])
def test_area_volume_and_curvature_of_a_sphere(kind, order, largest):
    errors = []
    for refinements in (2, 3):
        surface, x = BOTH[kind](sphere(refinements))
        o = surface.operators(x)
        errors.append((abs(o.area.sum() / (4.0 * np.pi) - 1.0), abs(o.volume() / (4.0 * np.pi / 3.0) - 1.0)))
        mean = np.sum(o.area * o.curvature) / o.area.sum()
        assert mean == pytest.approx(2.0, rel=2e-3)
        assert np.all(np.einsum("eqi,eqi->eq", o.normal, o.position) > 0.9)
    assert max(errors[0]) < 2.0 * largest
    assert np.all(np.log2(np.array(errors[0]) / np.array(errors[1])) > order)


def test_willmore_energies():
    """8π of a sphere, 4π² of the torus of Clifford; half the square of the sum of the principal curvatures."""
    surface, x = loop(sphere(3))
    o = surface.operators(x)
    assert 0.5 * np.sum(o.area * o.curvature**2) == pytest.approx(8.0 * np.pi, rel=5e-5)
    errors = []
    for n in (24, 48):
        surface, x = loop(torus(n, int(n / np.sqrt(2.0)), np.sqrt(2.0)))
        o = surface.operators(x)
        errors.append(abs(0.5 * np.sum(o.area * o.curvature**2) / (4.0 * np.pi**2) - 1.0))
    assert errors[1] < 1e-4
    assert np.log2(errors[0] / errors[1]) > 1.8


@pytest.mark.parametrize("valences", [(6, 6, 6), (5, 6, 6), (3, 6, 4), (4, 10, 6), (9, 7, 8), (3, 4, 5), (10, 3, 10)])
def test_loop_functions_on_triangles_with_any_neighbours(valences):
    """Derivatives against differences; the functions sum to 1 and none is negative."""
    share, h = np.array([[0.25, 0.4, 0.35], [0.7, 0.2, 0.1], [0.15, 0.15, 0.7]]), 1e-5
    m = sum(valences) - 6

    def at(shares):
        return _functions(np.array(valences), shares, m)

    found = at(share)
    assert np.allclose(found[:, VALUE].sum(axis=1), 1.0, atol=1e-14)
    assert found[:, VALUE].min() > -1e-15
    for first, change in ((1, [-1.0, 1.0, 0.0]), (2, [-1.0, 0.0, 1.0])):
        more, less = at(share + h * np.array(change)), at(share - h * np.array(change))
        assert np.allclose((more[:, 0] - less[:, 0]) / (2.0 * h), found[:, first], atol=1e-8)
        for second, of in ((3, 1), (4, 2)) if first == 1 else ((4, 1), (5, 2)):
            assert np.allclose((more[:, of] - less[:, of]) / (2.0 * h), found[:, second], atol=1e-6)


def test_a_loop_surface_has_no_gaps_whatever_the_neighbours():
    """On an edge two triangles meet that are cut differently, some not at all."""
    limit = loop(scattered(60, 3))[0]
    x = np.random.default_rng(4).normal(size=(60, 3))
    t, b = np.arange(len(limit.rings.triangles)), 0.3
    here = limit.at(x, t, np.tile([1.0 - b, b, 0.0], (len(t), 1)))
    twin = limit.rings.twin[3 * t]
    back = np.zeros((len(t), 3))
    back[np.arange(len(t)), twin % 3] = b
    back[np.arange(len(t)), (twin + 1) % 3] = 1.0 - b
    assert np.allclose(limit.at(x, twin // 3, back), here, atol=1e-12)
    assert len(np.unique(limit.rings.valence)) > 4


def test_a_loop_surface_has_no_kinks_whatever_the_neighbours():
    surface, x = loop(scattered(60, 3))
    t, b, h = np.arange(len(surface.rings.triangles)), 0.4, 1e-6
    along = np.tile([1.0 - b, b, 0.0], (len(t), 1))
    middle = surface.at(x, t, along)
    in_one = surface.at(x, t, along + h * np.array([-0.5, -0.5, 1.0])) - middle
    twin = surface.rings.twin[3 * t]
    rows = np.arange(len(t))
    back = np.zeros((len(t), 3))
    back[rows, twin % 3], back[rows, (twin + 1) % 3], back[rows, (twin + 2) % 3] = b - 0.5 * h, 1.0 - b - 0.5 * h, h
    in_other = surface.at(x, twin // 3, back) - middle
    edge = surface.at(x, t, along + h * np.array([-1.0, 1.0, 0.0])) - middle
    volume = np.einsum("ei,ei->e", np.cross(in_one, edge), in_other)
    size = np.linalg.norm(in_one, axis=1) * np.linalg.norm(edge, axis=1) * np.linalg.norm(in_other, axis=1)
    assert np.abs(volume / size).max() < 2e-4


def test_three_points_of_a_triangle_are_enough():
    triangles, places = sphere(2)
    few, many = LoopSurface(triangles, len(places)), LoopSurface(triangles, len(places), SIX)
    x = few.through(places)
    assert few.operators(x).area.sum() == pytest.approx(many.operators(x).area.sum(), rel=2e-4)


def test_a_tetrahedron_is_refused():
    with pytest.raises(ValueError, match="refine it"):
        LoopSurface(np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]), 4)


def test_radial_functions_are_made_anew_where_nodes_moved_far_and_after_a_resume():
    triangles, places = sphere(2)
    surface = BOTH["radial"]((triangles, places))[0]
    nodes, value = surface.nodes.copy(), surface.tables.value.copy()
    surface.renew(places * 1.001 + 3.0)  # a motion of all that strains little
    assert np.array_equal(surface.tables.value, value)
    stretched = places * (1.0, 1.0, 1.4)
    surface.renew(stretched)
    assert not np.array_equal(surface.tables.value, value)
    assert np.array_equal(surface.nodes, nodes)  # matrices keep their places
    fresh = BOTH["radial"]((triangles, stretched))[0].operators(stretched).area.sum()
    assert surface.operators(stretched).area.sum() == pytest.approx(
        fresh, rel=3e-4
    )  # with other neighbours, within what 162 nodes resolve
    other = BOTH["radial"]((triangles, places))[0]
    other.restore(surface.state_arrays())
    assert np.array_equal(other.tables.second, surface.tables.second)


def test_a_surface_that_folds_under_a_stencil_stops_the_run():
    triangles, places = sphere(2)
    surface = BOTH["radial"]((triangles, places))[0]
    with pytest.raises(RunStopped, match="folds over itself") as stopped:
        surface.renew(places * (1.0, 1.0, 0.02))
    assert stopped.value.place["position"][2] == pytest.approx(0.0, abs=0.02)
