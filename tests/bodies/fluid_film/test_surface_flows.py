"""Films on closed surfaces against exact solutions; small meshes, so that tolerances are those of the error that these have."""

from math import exp, pi, sqrt

import numpy as np
import pytest
from film_surfaces import BOTH, sphere

from pellucid.bodies.fluid_film.assembly import NodalSums, rows
from pellucid.bodies.fluid_film.balance import Driving, FilmBalance, Led
from pellucid.bodies.fluid_film.forces import Drag, FilmPhysics, Tension, bending_energies, forms
from pellucid.bodies.fluid_film.loop_surface import LoopSurface
from pellucid.bodies.fluid_film.model import FluidFilmCase
from pellucid.bodies.fluid_film.solvers import SparseSolver
from pellucid.materials.lipid_film import LipidFilm
from pellucid.parts.capabilities import ActingTraction

COLUMN = 0


def film(kind, mesh, density=1.0, viscosity=1.0, dilatational=1.0, bending=0.0, drag=0.0, stiffness=1.0):
    surface, x = BOTH[kind](mesh)
    material = LipidFilm(density=1.0, viscosity=viscosity, stiffness=stiffness)
    solver = SparseSolver(surface.nodes, surface.held, surface.places(x))
    physics = FilmPhysics(viscosity, dilatational, bending, 0.0, Drag(drag, drag))
    balance = FilmBalance(surface, material, physics, 1.0, solver)
    return balance, x, density * balance.part_areas(surface.operators(x))


def driving(x, traction=None, volume=None, area=None):
    tractions = [] if traction is None else [ActingTraction(COLUMN, traction, "load.0")]
    led = Led(np.zeros(len(x), bool), np.zeros(len(x)), np.zeros_like(x))
    return Driving(tractions, [], np.zeros(x.shape, bool), np.zeros_like(x), led, volume, area)


def legendre(degree, z):
    return np.polynomial.legendre.legval(z, np.eye(degree + 1)[degree])


@pytest.mark.parametrize("kind", BOTH)
def test_a_compressed_sphere_grows_as_it_must(kind):
    """R² = 2 - exp(-a ρ₀ t / (μ + λ)); the midpoint rule is of second order."""
    exact, errors = sqrt(2.0 - exp(-0.5)), []
    for steps in (10, 20):
        balance, x, mass = film(kind, sphere(2), density=2.0)
        for _ in range(steps):
            x = balance.step(x, balance.geometry.operators(x), mass, 1.0 / steps, 0.5, driving(x)).x
        radii = np.linalg.norm(balance.geometry.places(x), axis=1)
        assert np.ptp(radii) < 1e-6
        errors.append(abs(radii.mean() - exact))
    assert errors[1] < 1e-5
    assert np.log2(errors[0] / errors[1]) > 1.9


def test_an_uneven_film_without_drag_comes_to_rest_under_a_pressure():
    """P R / 2 = a (ρ₀ - ρ), ρ R² = ρ₀: R = 1.041504 for P = 0.15. Near rest all forces cancel but what quadrature leaves."""
    triangles, places = sphere(2)
    shift = 0.03 * np.random.default_rng(7).normal(size=places.shape)
    places = places + shift - np.einsum("ni,ni->n", shift, places)[:, None] * places
    places /= np.linalg.norm(places, axis=1)[:, None]
    balance, x, mass = film("radial", (triangles, places))
    for _ in range(80):
        x = balance.step(
            x, balance.geometry.operators(x), mass, 0.5, 0.5, driving(x, lambda points, after: 0.15 * points.normal)
        ).x
    assert np.linalg.norm(x, axis=1).mean() == pytest.approx(1.041504, abs=2e-5)


@pytest.mark.parametrize("kind", BOTH)
def test_a_sphere_under_a_wind_goes_on_rigidly(kind):
    """b = p (n·e) n with drag ζ: V = p/(3ζ)."""
    balance, x, mass = film(kind, sphere(2), drag=1.0, stiffness=100.0)

    def wind(points, after):
        return points.normal * (0.6 + points.normal[..., 2:])

    for _ in range(10):
        done = balance.step(x, balance.geometry.operators(x), mass, 0.05, 0.5, driving(x, wind))
        x = done.x
    v = balance.geometry.places(done.velocity)
    assert np.abs(v - [0.0, 0.0, 1.0 / 3.0]).max() < 5e-4
    assert v[:, 2].mean() == pytest.approx(1.0 / 3.0, rel=2e-5)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_bending_smooths_a_sphere_at_the_exact_rate(degree):
    """ω = κ_c L ((2μ + λ) L - 2μ) / (4μ (μ + λ) R⁴), L = l (l + 1)."""
    triangles, places = sphere(3)
    L, small = degree * (degree + 1), 1e-4
    rate = L * (3.0 * L - 2.0) / 8.0
    wave = legendre(degree, places[:, 2])
    radial = []
    for amplitude in (0.0, small):
        balance, x, mass = film("loop", (triangles, places * (1.0 + amplitude * wave)[:, None]), bending=1.0, stiffness=1e-9)
        v = balance.geometry.places(balance.step(x, balance.geometry.operators(x), mass, 1e-9, 0.5, driving(x)).velocity)
        radial.append(np.einsum("ni,ni->n", v, places))
    found = -((radial[1] - radial[0]) @ wave) / (wave @ wave) / small
    assert found == pytest.approx(rate, rel=2e-3)


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize(("degree", "dilatational"), [(2, 1.0), (4, 1000.0)])
def test_flow_along_a_gradient_dissipates_as_it_must_and_does_not_lock(kind, degree, dilatational):
    """For w = ∇Y_l: -∫ w · div σ = (2μ (L - 1) + λ L) ∫ w²."""
    _, places = mesh = sphere(3)
    surface, _ = BOTH[kind](mesh)
    z, L = places[:, 2:], degree * (degree + 1)
    slope = np.polynomial.legendre.legval(z[:, 0], np.polynomial.legendre.legder(np.eye(degree + 1)[degree]))
    w = surface.through(slope[:, None] * (np.array([0.0, 0.0, 1.0]) - z * places))
    o, sums = surface.operators(surface.through(places)), NodalSums(surface.nodes, len(places), 3)
    squares = [rows(o.strain, o.area[..., None] * np.array([2.0, 2.0, 1.0])), rows(o.dilatation(), dilatational * o.area)]
    power = sum(np.sum(square.factor * sums.rates(square, w) ** 2) for square in squares)
    field = np.einsum("eqmi,emi->eqi", o.value, w[surface.nodes])
    exact = (2.0 * (L - 1.0) + dilatational * L) * np.sum(o.area[..., None] * field**2)
    assert power == pytest.approx(exact, rel=4e-4)


def test_the_force_of_bending_is_the_derivative_of_its_energy():
    triangles, places = sphere(1)
    surface, x = BOTH["loop"]((triangles, places * (1.0, 0.9, 1.2)))
    physics = FilmPhysics(1.0, 0.0, 0.7, 1.3, Drag(0.0, 0.0))
    o, v, h = surface.operators(x), np.random.default_rng(4).normal(size=x.shape), 1e-6
    none = np.zeros_like(o.area)
    force = NodalSums(surface.nodes, *x.shape).gathered(forms(o, physics, Tension(none, none), 0.0).force)
    more, less = (bending_energies(surface.operators(x + step * v), physics).sum() for step in (h, -h))
    assert np.sum(force * v) == pytest.approx((less - more) / (2.0 * h), rel=1e-7)


def test_a_prolate_vesicle_finds_its_energy():
    """E / 8πκ_c = 1.18964 at reduced volume 0.9."""
    triangles, places = sphere(2)
    balance, x, mass = film("loop", (triangles, places * (1.0, 1.0, 1.79)), bending=1.0, stiffness=1e-9)
    surface = balance.geometry
    x = surface.smoothed(x)
    o = surface.operators(x)
    area = o.area.sum()
    volume, dt = 0.9 * area**1.5 / (6.0 * sqrt(pi)), 0.01
    for _ in range(40):
        done = balance.step(x, balance.geometry.operators(x), mass, dt, 0.5, driving(x, None, volume, area))
        x, mass = surface.redistributed(done.x, mass, dt * done.velocity)
        dt = min(1.1 * dt, 0.2)
    o = surface.operators(x)
    assert bending_energies(o, balance.physics).sum() / (8.0 * pi) == pytest.approx(1.18964, rel=1e-3)
    assert o.area.sum() == pytest.approx(area, rel=1e-5)
    assert o.volume() == pytest.approx(volume, rel=1e-5)


def test_a_start_from_a_mesh():
    sphere_of_radius_one = {"surface": {"icosphere": {"centre": (0.0, 0.0, 0.0), "radius": 1.0, "refinements": 2}}}
    lipid = {"kind": "lipid-film", "density": 1.0, "viscosity": 1.0, "dilatational_viscosity": 1.0, "stiffness": 1.0}
    film = FluidFilmCase.model_validate({"name": "film", "shape": sphere_of_radius_one, "material": lipid})
    surface, x = film.geometry()
    assert surface.operators(x).volume() == pytest.approx(4.0 * pi / 3.0, rel=2e-3)
    triangles = film.shape.surface.triangulate().triangles
    near = np.abs(np.diff(surface.rings.triangles, axis=1))
    assert np.median(near) < 0.5 * np.median(np.abs(np.diff(triangles, axis=1)))
    with pytest.raises(ValueError, match="is not closed"):
        LoopSurface(triangles[1:], len(x))


@pytest.mark.parametrize("share", [0.0, 0.2])
def test_a_load_drives_a_gradient_flow_whether_nodes_are_even_or_not(share):
    """-div σ of w = ∇Y₂, n its normal: (2μ (L - 1) + λ L) w - 2 (μ + λ) L Y₂ n.

    Nodes are moved by 20 % of their distances, at random. Then the velocity's error hardly falls on: 1.9e-3 with 642 nodes,
    1.6e-3 with 2562; Loop surfaces, whose nodes must be even, have 0.17. Even nodes have 4.9e-4. Its energy is of higher order.
    """
    triangles, places = sphere(3)
    surface, _ = BOTH["radial"]((triangles, places))
    shift = np.random.default_rng(1).normal(size=places.shape)
    shift -= np.einsum("ni,ni->n", shift, places)[:, None] * places
    places = places + shift * (share * surface.spacing(places) / np.linalg.norm(shift, axis=1))[:, None]
    places /= np.linalg.norm(places, axis=1)[:, None]
    balance, x, mass = film("radial", (triangles, places), stiffness=1e-12)

    def mode(points):
        z = points.position[..., 2:] / np.linalg.norm(points.position, axis=-1, keepdims=True)
        n = points.position / np.linalg.norm(points.position, axis=-1, keepdims=True)
        return n, 3.0 * z * (np.array([0.0, 0.0, 1.0]) - z * n), 1.5 * z**2 - 0.5

    def load(points, after):
        n, w, wave = mode(points)
        return 16.0 * w - 24.0 * wave * n

    o = balance.geometry.operators(x)
    done = balance.step(x, o, mass, 1e-9, 0.5, driving(x, load))
    w = mode(o)[1]
    wrong = np.einsum("eqmi,emi->eqi", o.value, done.velocity[balance.geometry.nodes]) - w
    error = np.sqrt(np.sum(o.area[..., None] * wrong**2) / np.sum(o.area[..., None] * w**2))
    assert error < (2.4e-3 if share else 6e-4)
    assert done.loads[0][1] == pytest.approx(16.0 * np.sum(o.area[..., None] * w**2), rel=1e-5)
