"""Rheologies: laws against their formulas and limits, plane channel flows against exact profiles, the same bits, errors."""

import json

import numpy as np
import pytest
from samples import fluid
from scipy.integrate import quad
from scipy.optimize import brentq
from small_cases import advance, assert_same_arrays, box, case, copied_state, finished

from pellucid.grid.implicit_viscosity import ImplicitViscosity
from pellucid.grid.passes.gifts import scatter
from pellucid.materials.fluid import FluidMaterial
from pellucid.materials.law import diffusivity, update
from pellucid.materials.rheology import RHEOLOGIES, shear_rate, shear_viscosity
from pellucid.simulation.simulation import Simulation

BLOOD = {"zero_viscosity": 2.0, "infinite_viscosity": 0.2, "time": 2.0, "exponent": 0.4, "transition": 1.25}
POWER = {"zero_viscosity": 50.0, "infinite_viscosity": 0.0, "time": 1000.0, "exponent": 0.5}
GEL = {"plastic_viscosity": 1.0, "yield_stress": 1.5, "time": 100.0}
CARREAU, BINGHAM = {"kind": "carreau-yasuda"} | BLOOD, {"kind": "bingham"} | GEL
CASSON = {"kind": "casson"} | GEL | {"yield_stress": 0.4}
RATES = np.array([1e-9, 1e-4, 0.01, 0.3, 1.0, 7.0, 400.0, 1e6])
LIQUID = {"kind": "fluid", "density": 0.01, "eos": {"kind": "tait", "sound_speed": 30.0, "carries_tension": True}}
EXPLICIT, VISCOUS = {}, {"implicit_viscosity": True}
PRESSED = {"implicit_pressure": True}
WALLS = [{"where": "y-lower", "velocity": (0, 0, 0)}, {"where": "y-upper", "velocity": (0, 0, 0)}]
FORCE = 8.0
"""Body force [N/m³] along a channel of 1 m width."""


def law_of(table):
    return RHEOLOGIES.validated(table).law()


def viscosity_by_formula(table, rate):
    """The formulas of the laws in numpy."""
    if table["kind"] == "carreau-yasuda":
        mu0, mu1, a = table["zero_viscosity"], table["infinite_viscosity"], table.get("transition", 2.0)
        return mu1 + (mu0 - mu1) * (1.0 + (table["time"] * rate) ** a) ** ((table["exponent"] - 1.0) / a)
    mu, tau, m = (table[name] for name in ("plastic_viscosity", "yield_stress", "time"))
    if table["kind"] == "bingham":
        return mu - tau * np.expm1(-m * rate) / rate
    return (np.sqrt(mu) - np.sqrt(tau / rate) * np.expm1(-np.sqrt(m * rate))) ** 2


@pytest.mark.parametrize("table", [CARREAU, {"kind": "carreau-yasuda", **POWER}, BINGHAM, CASSON])
def test_the_laws_are_their_formulas_and_decrease(table):
    found = np.array([shear_viscosity(law_of(table), rate) for rate in RATES])
    assert found == pytest.approx(viscosity_by_formula(table, RATES), rel=1e-13)
    assert np.all(np.diff([shear_viscosity(law_of(table), 0.0), *found]) <= 0.0)


def test_limits_of_the_laws():
    assert shear_viscosity(law_of(CARREAU), 0.0) == 2.0
    assert shear_viscosity(law_of(CARREAU), 1e12) == pytest.approx(0.2, rel=1e-6)
    assert shear_viscosity(law_of(BINGHAM), 0.0) == 1.0 + 1.5 * 100.0
    assert shear_viscosity(law_of(CASSON), 0.0) == pytest.approx((1.0 + np.sqrt(0.4 * 100.0)) ** 2, rel=1e-15)
    for table in (BINGHAM, CASSON):
        assert shear_viscosity(law_of(table), 1e14) == pytest.approx(1.0, rel=1e-6)
        assert shear_viscosity(law_of(table | {"yield_stress": 0.0}), 0.7) == 1.0
    for rate in (0.0, 0.7, 1e5):
        assert shear_viscosity(law_of(CARREAU | {"exponent": 1.0}), rate) == pytest.approx(2.0, rel=1e-15)


def test_the_yield_stress_is_that_of_the_stress_at_small_rates():
    """At rates that are small, but large compared with 1/m."""
    for table in (BINGHAM, CASSON):
        law = law_of(table | {"time": 1e12})
        assert shear_viscosity(law, 1e-8) * 1e-8 == pytest.approx(table["yield_stress"], rel=1e-3)


def test_the_shear_rate_is_that_of_the_deviator():
    assert shear_rate((0.0, 0.0, 0.0, 0.0, 0.0, -1.5)) == pytest.approx(3.0, rel=1e-15)
    assert shear_rate((2.0, -1.0, -1.0, 0.0, 0.0, 0.0)) == pytest.approx(2.0 * np.sqrt(3.0), rel=1e-15)
    assert shear_rate((2.0, 2.0, 2.0, 0.0, 0.0, 0.0)) == 0.0
    D = np.random.default_rng(1).normal(size=(3, 3))
    D += D.T
    deviator = D - np.trace(D) / 3.0 * np.eye(3)
    flat = tuple(float(D[i]) for i in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))
    assert shear_rate(flat) == pytest.approx(np.sqrt(2.0 * np.sum(deviator**2)), rel=1e-14)


@pytest.mark.parametrize("table", [CARREAU, BINGHAM, CASSON])
@pytest.mark.parametrize("second", [None, 7.0])
def test_the_stress_of_a_fluid_has_the_viscosity_at_its_shear_rate(table, second):
    material = fluid("tait", rheology=table, second_viscosity=second, pressure=0.0)
    L, dt = (4.0, 3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), 1e-15  # so short that the pressure stays
    state = update(material.law(), material.initial_state(), material.density, L, dt, 0.01)
    mu = viscosity_by_formula(table, np.sqrt(2.0 * (4.0 + 1.0 + 1.0 + 2.0 * 1.5**2)))
    bulk = 6.0 * (-2.0 / 3.0 * mu if second is None else second)
    assert state.viscosity == pytest.approx(mu, rel=1e-13)
    assert state.stress == pytest.approx((8.0 * mu + bulk, *(2.0 * mu + bulk,) * 2, 0.0, 0.0, 3.0 * mu), abs=1e-5)
    at_rest = shear_viscosity(law_of(table), 0.0)
    assert material.initial_state().viscosity == at_rest
    least = diffusivity(material.law(), material.density) * material.density
    assert least == pytest.approx(4.0 / 3.0 * at_rest if second is None else 2.0 * at_rest + second, rel=1e-15)


def channel(rheology, how, n=16, end=0.03, threads=1, **more):
    """A fluid between two walls, pushed along them."""
    material = LIQUID | ({"viscosity": rheology} if isinstance(rheology, float) else {"rheology": rheology}) | how
    h = 1.0 / n
    push = [{"kind": "body-force", "body": "block", "acceleration": (FORCE / 0.01, 0, 0)}]
    if "implicit_pressure" in how:
        more = {"functions": "quadratic-bspline", "scheme": "usl"} | more
    table = {"periodic": ["x"], "support": WALLS, "load": push, "end": end} | more
    body = box((0, -0.5, 0), (4.0 * h, 0.5, h), material, (2, 2, 1))
    return Simulation(case(body, counts=(4, n, 1), cell=h, lower=(0, -0.5, 0), **table), threads=threads)


def profile(sim):
    """Heights [m] of the nodes and velocities [m/s] that strain the points."""
    n, stride = sim.grid.lattice.counts[1], sim.grid.lattice.strides[1]
    return np.linspace(-0.5, 0.5, n + 1), sim.grid.nodes.strain_velocity[stride * np.arange(n + 1), 0]


def mean_velocity(sim):
    return sim.momentum()[0] / sim.bodies[0].mass


def exact(table):
    """Velocity as a function of the height and its mean, of a law of the stress τ = μ(γ̇) γ̇ = f |y|."""

    def rate(y):
        return brentq(lambda g: viscosity_by_formula(table, g) * g - FORCE * y, 1e-14, 1e7) if y > 1e-12 else 0.0

    mean = 2.0 * quad(lambda y: y * rate(y), 0.0, 0.5, epsabs=1e-10, limit=200)[0]
    return lambda y: quad(rate, abs(y), 0.5, epsabs=1e-10, limit=200)[0], mean


@pytest.mark.parametrize("how", [VISCOUS, PRESSED], ids=["viscosity", "pressure"])
@pytest.mark.parametrize("table", [CARREAU, BINGHAM, CASSON], ids=lambda table: table["kind"])
def test_channels_flow_as_the_laws_say(table, how):
    """As a Newtonian liquid does on these cells: 0.4 % of the mean velocity with linear functions, 1.5 % with B-splines."""
    sim = finished(channel(table, how, end=0.03 if how == VISCOUS else 2.0))
    (y, u), (velocity, mean) = profile(sim), exact(table)
    share = 0.007 if how == VISCOUS else 0.018
    assert mean_velocity(sim) == pytest.approx(mean, rel=share)
    largest = velocity(0.0)
    assert np.abs(u - [velocity(at) for at in y]).max() < share * largest
    assert abs(sim.budget.conservation()["energy"]) < 1e-13


def test_the_power_law_between_the_limits_of_carreau():
    """u ∝ 1 - |2y|^(1 + 1/n), with the mean (f H/2K)^(1/n) H/2 / (2 + 1/n), K = μ0 λ^(n-1)."""
    sim = finished(channel({"kind": "carreau-yasuda", **POWER}, VISCOUS))
    K = 50.0 / np.sqrt(1000.0)
    mean = (0.5 * FORCE / K) ** 2 * 0.5 / 4.0
    assert mean_velocity(sim) == pytest.approx(mean, rel=0.005)
    y, u = profile(sim)
    # in the middle, where the exact profile is flat, the error of 16 cells is 0.0057 if the equations are solved to rounding
    assert u == pytest.approx(mean * 4.0 / 3.0 * (1.0 - np.abs(2.0 * y) ** 3), abs=0.006 * mean)


def test_the_plug_of_bingham():
    """Half width τy/f; mean velocity f H²/12μ (1 - 3φ/2 + φ³/2), φ = 2τy/fH; the regularised plug adds 3/2 (τy/f)²/m."""
    sim = finished(channel(BINGHAM, VISCOUS, n=32))
    half, m = 1.5 / FORCE, GEL["time"]
    mean = FORCE / 12.0 * (1.0 - 1.5 * 2.0 * half + 0.5 * (2.0 * half) ** 3)
    more = 1.5 * half**2 / m
    assert exact(BINGHAM)[1] == pytest.approx(mean + more, rel=1e-4)
    assert mean_velocity(sim) == pytest.approx(mean + more, rel=0.003)
    y, u = profile(sim)
    at, rate = 0.5 * (y[1:] + y[:-1]), np.abs(np.diff(u)) * 32
    sheared = (np.abs(at) > half + 0.06) & (np.abs(at) < 0.5 - 0.06)
    slope, offset = np.polyfit(np.abs(at)[sheared], rate[sheared], 1)
    assert -offset / slope == pytest.approx(half, rel=0.01)
    assert slope == pytest.approx(FORCE, rel=0.01)
    assert rate[np.abs(at) < half - 1.0 / 32].max() < 3.0 / m


def test_casson_between_plates():
    """Mean velocity f H²/12μ (1 - 12/5 φ^½ + 3/2 φ - φ³/10) with a sharp yield stress; the regularised one is larger."""
    phi = 0.4 / (0.5 * FORCE)
    mean = FORCE / 12.0 * (1.0 - 2.4 * np.sqrt(phi) + 1.5 * phi - 0.1 * phi**3)
    assert exact(CASSON | {"time": 1e7})[1] == pytest.approx(mean, rel=1e-3)
    found = mean_velocity(finished(channel(CASSON | {"time": 1e4}, VISCOUS, n=32)))
    assert found == pytest.approx(exact(CASSON | {"time": 1e4})[1], rel=0.003)


@pytest.mark.parametrize("table", [CARREAU, BINGHAM | {"time": 1.0}, CASSON | {"time": 1.0}], ids=lambda table: table["kind"])
def test_explicit_and_implicit_agree(table):
    small, large = (finished(channel(table, how, n=8, end=0.05)) for how in (EXPLICIT, VISCOUS))
    assert small.n_steps > 20 * large.n_steps
    assert mean_velocity(large) == pytest.approx(mean_velocity(small), rel=1e-3)
    assert profile(large)[1] == pytest.approx(profile(small)[1], abs=2e-3)
    assert large.bodies[0].field("viscosity") == pytest.approx(small.bodies[0].field("viscosity"), rel=0.02)
    for sim in (small, large):
        assert abs(sim.budget.conservation()["energy"]) < 1e-12


@pytest.mark.parametrize("how", [EXPLICIT, VISCOUS, PRESSED], ids=["explicit", "viscosity", "pressure"])
@pytest.mark.parametrize("more", [{}, {"second_viscosity": 0.5}], ids=["stokes", "second"])
def test_a_law_without_thinning_is_newtonian(how, more):
    """In steps so few that viscous forces are fully implicit for both, and that rounding does not grow."""
    bodies = []
    for rheology in (1.0, BINGHAM | {"yield_stress": 0.0}):
        sim = advance(channel(rheology, how | more, n=8, end=1.0), 2)
        bodies.append(sim.bodies[0])
    for name in ("velocity", "position", "stress", "internal_energy"):
        one, two = (body.field(name) for body in bodies)
        assert two == pytest.approx(one, rel=1e-11, abs=1e-11 * np.abs(one).max()), name


@pytest.mark.parametrize("second", [{}, {"second_viscosity": 0.3}])
def test_the_preconditioner_is_the_diagonal(second):
    (viscosity,) = advance(channel(CARREAU, VISCOUS | second, n=8), 3).parts.of(ImplicitViscosity)
    rows = viscosity._rows
    assert np.ptp(viscosity._bodies[0].arrays["viscosity"]) > 0.5
    rows.inverse[:] = 0.0
    viscosity._point_viscosities[0].add_diagonal()
    scatter(viscosity._diagonals[0])
    for k in (*np.flatnonzero(rows.inertia)[::5], int(np.argmax(rows.inertia))):
        rows.direction[:] = rows.viscous_force[:] = 0.0
        rows.direction[k] = 1.0
        viscosity._map(viscosity._of_direction, 0.0)
        assert rows.viscous_force[k] == pytest.approx(-rows.inverse[k], rel=1e-12)
        assert rows.inverse[k] > 0.0


@pytest.mark.parametrize("how", [EXPLICIT, VISCOUS, PRESSED], ids=["explicit", "viscosity", "pressure"])
def test_threads_and_a_checkpoint_change_no_bit(how):
    one, two = (advance(channel(CASSON, how, n=8, end=1.0, threads=threads), 6) for threads in (1, 2))
    assert np.ptp(one.bodies[0].arrays["viscosity"]) > 0.0
    numbers, arrays, resumed = (
        json.loads(json.dumps(one.state_numbers())),
        copied_state(one),
        channel(CASSON, how, n=8, end=1.0),
    )
    resumed.restore(arrays, numbers)
    advance(one, 6)
    advance(two, 6)
    advance(resumed, 6)
    for other in (two, resumed):
        assert one.budget.energies() == other.budget.energies()
        assert_same_arrays(copied_state(one), copied_state(other))


def test_a_run_goes_on_from_frames():
    one = advance(channel(CARREAU, VISCOUS, n=8), 6)
    body = one.bodies[0]
    arrays = {name: body.field(name) for name in ("id", *body.arrays) if name != "viscous_stress"}
    two = Simulation(one.case, threads=1, start={"block": arrays})
    assert np.array_equal(two.bodies[0].field("viscosity"), body.field("viscosity"))
    advance(two, 2)
    assert abs(two.budget.conservation()["energy"]) < 1e-12


def test_a_column_at_rest_has_the_viscosity_at_rest():
    material = FluidMaterial.model_validate(LIQUID | {"rheology": BINGHAM})
    _, state = material.at_rest(9.81, np.array([0.0, 0.1, 0.2]))
    assert np.array_equal(state["viscosity"], np.full(3, 151.0))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"viscosity": 2.0}, "viscosity = 2 Pa.s and rheology both define the shear viscosity; remove one of the two"),
        ({"second_viscosity": -0.2}, "below -2/3 of the viscosity in the limit of infinite shear rates = -0.133333 Pa.s"),
        ({"rheology": CARREAU | {"infinite_viscosity": 3.0}}, "infinite_viscosity = 3 Pa.s exceeds .* exchange both values"),
        ({"rheology": CARREAU | {"exponent": 1.2}}, "exponent"),
        ({"rheology": GEL | {"kind": "herschel"}}, "carreau-yasuda.*bingham.*casson"),
    ],
)
def test_errors(change, text):
    with pytest.raises(ValueError, match=text):
        FluidMaterial.model_validate(LIQUID | {"rheology": CARREAU} | change)
