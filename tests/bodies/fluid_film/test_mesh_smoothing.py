import numpy as np
import pytest
from film_surfaces import BOTH, loop, scattered, sphere

from pellucid.bodies.fluid_film.mesh_smoothing import CellFluxes, check_quality, rigid_part
from pellucid.errors import RunStopped
from pellucid.geometry.checks.quality import triangle_qualities
from pellucid.geometry.meshes.triangulation import rings


def cell_areas(surface, x):
    o = surface.operators(x)
    shares = surface.shares
    return np.bincount(shares.part.ravel(), np.einsum("eq,qc->ec", o.area, shares.share).ravel())


def swirl(x):
    """A shear in the surface of a sphere, of rate 1 at the equator."""
    return np.stack([-x[:, 2] * x[:, 1], x[:, 2] * x[:, 0], 0.0 * x[:, 0]], axis=1)


@pytest.mark.parametrize(("kind", "refinements", "spread"), [("loop", 2, 8e-3), ("radial", 2, 3e-3)])
def test_a_shear_of_eight_leaves_the_nodes_where_they_are(kind, refinements, spread):
    surface, x = BOTH[kind](sphere(refinements))
    start, steps = surface.places(x), 200
    mass = cell_areas(surface, x)
    total, dt = mass.sum(), 8.0 / steps
    for _ in range(steps):
        places = surface.places(x)
        v = surface.through(swirl(places + 0.5 * dt * swirl(places)))
        x, mass = surface.redistributed(x + dt * v, mass, dt * v)
    places = surface.places(x)
    assert triangle_qualities(places, surface.rings.triangles).min() > 0.9
    assert mass.sum() == pytest.approx(total, rel=1e-13)
    assert np.abs(mass / cell_areas(surface, x) - 1.0).max() < spread
    assert np.abs(places - start).max() < 0.1  # of the swirl, whose nodes would have gone round


@pytest.mark.parametrize("kind", BOTH)
def test_one_density_stays_so_and_mass_is_kept(kind):
    surface, x = BOTH[kind](sphere(2))
    mass = 1.7 * cell_areas(surface, x)
    moved = 0.04 * np.random.default_rng(1).normal(size=x.shape)
    new, new_mass = surface.redistributed(x, mass, moved)
    assert new_mass.sum() == pytest.approx(mass.sum(), rel=1e-14)
    density = new_mass / cell_areas(surface, new)
    assert np.ptp(density) < 1e-13
    assert np.abs(new - x).max() > 1e-3


def test_a_density_goes_with_the_film_and_makes_no_new_extremes():
    triangles, places = sphere(3)
    surface, x = loop((triangles, places))
    areas = cell_areas(surface, x)
    density = 1.0 + 0.3 * places[:, 0]
    turn = np.cross([0.0, 0.0, 0.02], places)  # nodes that turn by 0.02 in a film at rest
    fluxes = CellFluxes(surface.rings)
    after = places + turn
    after /= np.linalg.norm(after, axis=1)[:, None]
    mass = fluxes.moved(places, after, areas, areas, density * areas)
    assert mass.sum() == pytest.approx((density * areas).sum(), rel=1e-14)
    assert np.abs(mass / areas - (1.0 + 0.3 * after[:, 0])).max() < 0.1 * np.abs(0.3 * turn[:, 0]).max()
    jump = np.where(places[:, 2] > 0.0, 2.0, 1.0)
    for _ in range(20):
        tilt = np.cross([0.02, 0.0, 0.0], places)
        jump = fluxes.moved(places, places + tilt, areas, areas, jump * areas) / areas
    assert jump.min() > 1.0 - 1e-3
    assert jump.max() < 2.0 + 1e-3


def test_scattered_nodes_are_spread():
    triangles, places = scattered(200, 5)
    surface, x = loop((triangles, places))
    before, after = (triangle_qualities(surface.places(nodes), triangles) for nodes in (x, surface.smoothed(x, 20)))
    assert np.sort(after)[10] > 2.0 * np.sort(before)[10]


def test_a_rigid_motion_is_found():
    places = scattered(50, 6)[1]
    moved = np.array([0.1, 0.2, 0.3]) + np.cross([0.3, -0.1, 0.2], places)
    assert np.allclose(rigid_part(places, moved, np.linspace(1.0, 2.0, 50)), moved, atol=1e-14)


def test_a_flat_triangle_stops_the_run_and_is_named():
    triangles, places = sphere(1)
    places = places.copy()
    node = int(triangles[5, 1])
    places[node] = 0.97 * places[triangles[5, 0]] + 0.03 * places[triangles[5, 2]]
    with pytest.raises(RunStopped, match="quality of 0") as stopped:
        check_quality(triangles, places)
    assert np.linalg.norm(np.array(stopped.value.place["position"]) - places[node]) < 0.6
    assert stopped.value.place["node"] in [node, *rings(triangles, len(places)).neighbours[node].tolist()]
