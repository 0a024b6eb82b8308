"""Bodies of material points in motion: what must be exact, and what must stop."""

from math import sqrt

import numpy as np
import pytest
from small_cases import GAS, RATE_SOLID, SOLID, advance, box, case, place, simulation
from user_laws import KelvinVoigtMaterial

from pellucid.approximants import GRID_FUNCTIONS
from pellucid.errors import CaseError, RunStopped
from pellucid.grid.velocity_transfer import TRANSFERS
from pellucid.simulation.simulation import Simulation
from pellucid.simulation.stages import SCHEMES
from pellucid.state import FIELDS

every_function = pytest.mark.parametrize("functions", GRID_FUNCTIONS)
every_transfer = pytest.mark.parametrize("transfer", TRANSFERS)
every_scheme = pytest.mark.parametrize("scheme", SCHEMES)


def flying(velocity=(0.6, -0.3, 0.2), material=SOLID, velocity_wave=None, **more):
    """A block that crosses several cells within its steps."""
    settings = {"counts": (8, 6, 6), "lower": (0, -1, 0), "end": 100.0, "step": 0.125} | more
    body = box((1.1, 1.2, 1.3), (3.3, 3.1, 2.9), material, velocity=velocity, velocity_wave=velocity_wave)
    return simulation(body, **settings)


@every_function
def test_rigid_translation_is_exact(functions):
    sim = flying(functions=functions)
    start = sim.bodies[0].frame()["position"]
    frame = advance(sim, 40).bodies[0].frame()
    # 40 steps, each with the rounding of sums of up to 64 terms
    assert np.abs(frame["velocity"] - (0.6, -0.3, 0.2)).max() < 1e-13
    assert np.abs(frame["position"] - start - 5.0 * np.array((0.6, -0.3, 0.2))).max() < 1e-13
    assert np.abs(frame["stress"]).max() < 1e-12 * SOLID["young_modulus"]
    assert sim.budget.conservation()["momentum"] < 1e-14


@every_transfer
@every_scheme
def test_rigid_translation_is_exact_for_every_transfer_and_scheme(transfer, scheme):
    sim = flying(functions="quadratic-bspline", transfer=transfer, scheme=scheme)
    start = sim.bodies[0].frame()["position"]
    frame = advance(sim, 40).bodies[0].frame()
    tolerance = 1e-9 if transfer == "apic" else 1e-13  # gradients close to walls lose four digits, and are carried on
    assert np.abs(frame["velocity"] - (0.6, -0.3, 0.2)).max() < tolerance
    assert np.abs(frame["position"] - start - 5.0 * np.array((0.6, -0.3, 0.2))).max() < tolerance
    assert np.abs(frame["stress"]).max() < 10.0 * tolerance * SOLID["young_modulus"]


@every_transfer
@every_scheme
def test_free_fall_is_exact(transfer, scheme):
    """Velocities v + g t; places as the symplectic Euler steps sum up; the work of gravity is the kinetic energy."""
    gravity = np.array((0.01, -0.02, 0.03))
    sim = flying(functions="quadratic-bspline", transfer=transfer, scheme=scheme, gravity=tuple(gravity))
    start = sim.bodies[0].frame()["position"]
    n, dt = 32, 0.125
    frame = advance(sim, n).bodies[0].frame()
    velocity = np.array((0.6, -0.3, 0.2))
    tolerance = 1e-9 if transfer == "apic" else 1e-12
    assert np.abs(frame["velocity"] - velocity - n * dt * gravity).max() < tolerance
    moved = n * dt * velocity + 0.5 * n * (n + 1) * dt * dt * gravity
    assert np.abs(frame["position"] - start - moved).max() < tolerance
    energies = sim.budget.energies()
    assert energies["gravity_work"] == pytest.approx(energies["kinetic"] - sim.budget.initial["kinetic"], rel=1e-9)
    assert abs(sim.budget.conservation()["energy"]) < 1e-9
    assert sim.budget.conservation()["momentum"] < 1e-13


def test_mass_is_constant_and_momentum_of_two_bodies_in_contact():
    """Two blocks that collide on the grid: a closed system."""
    left = box((0.6, 1.1, 1.3), (2.0, 2.7, 2.6), RATE_SOLID, velocity=(0.5, 0.1, 0.0), name="left")
    right = box((2.3, 1.4, 1.2), (4.1, 2.9, 2.9), RATE_SOLID, velocity=(-0.5, 0.0, 0.1), name="right")
    sim = advance(simulation(left, right, counts=(6, 5, 5), end=100.0), 60)
    conservation = sim.budget.conservation()
    assert conservation["mass"] == 0.0
    assert conservation["momentum"] < 1e-13  # 60 steps of sums over a few hundred points
    speeds = [body.frame()["velocity"][:, 0].mean() for body in sim.bodies]
    assert speeds[0] < 0.45, "they did touch"
    assert speeds[1] > -0.45


@every_transfer
def test_momentum_of_a_closed_system_for_every_transfer(transfer):
    """A pulsating block with ragged edges, some of them just across a node, where a node's mass is next to nothing."""
    wave = {"amplitude": (0.3, 0.2, 0.1), "wave_vector": (2.0, 1.0, 0.5), "phase": 0.4}
    body = box((1.1, 1.2, 1.3), (3.3, 3.1, 2.9), SOLID, velocity_wave=wave)
    sim = simulation(body, counts=(6, 6, 5), functions="quadratic-bspline", transfer=transfer, end=100.0)
    body = sim.bodies[0]
    moved = body.arrays["position"].copy()
    moved[moved[:, 0] == moved[:, 0].max(), 0] = 3.5 + 1e-3
    place(body, moved)
    advance(sim, 40)
    assert sim.budget.conservation()["momentum"] < 1e-12


# what must stop


def stopped(sim, steps=50):
    """The error that ends the run within 50 steps (the promise), and the state that it names."""
    with pytest.raises(RunStopped) as caught:
        advance(sim, steps)
    error = caught.value
    assert error.exit_status == 3
    assert f"point {error.place['point']} of body `{error.place['body']}`" in str(error)
    assert f"step {error.place['step']}" in str(error)
    assert error.place["state"]["id"] == error.place["point"]
    return error


@every_scheme
def test_a_point_that_leaves_the_grid_is_named(scheme):
    sim = flying(velocity=(2.0, 0.0, 0.0), scheme=scheme)
    error = stopped(sim)
    assert "left the grid" in str(error)
    assert "support" in str(error)
    assert error.place["state"]["position"][0] > 8.0
    last = sim.bodies[0].frame()["position"][:, 0]
    assert last[error.place["point"]] == error.place["state"]["position"][0]


@every_scheme
def test_an_inverted_point_is_named(scheme):
    """Two halves that rush into each other through a whole cell in one step."""
    soft = SOLID | {"young_modulus": 1e-6}
    body = box((2, 2, 2), (4, 4, 4), soft, per_cell=(1, 1, 1))
    sim = simulation(body, counts=(6, 6, 6), step=1.0, end=100.0, scheme=scheme)
    body = sim.bodies[0]
    body.arrays["velocity"][:, 0] = np.where(body.arrays["position"][:, 0] < 3.0, 1.04, -1.04)
    body.arrays["position"][:, 0] = np.where(body.arrays["position"][:, 0] < 3.0, 2.1, 3.9)
    body.storage.sort()
    assert "volume would become zero or negative" in str(stopped(sim, 2))


@every_scheme
@pytest.mark.parametrize("name", ["velocity", "deformation_gradient", "volume"])
def test_a_state_that_is_no_number_is_named(scheme, name):
    sim = flying(scheme=scheme)
    body = sim.bodies[0]
    body.arrays[name][17] = np.nan
    origin = body.points.position[17].copy()
    error = stopped(sim, 2)
    assert "not a finite number" in str(error)
    # the first of the points that share a node with it
    assert np.abs(np.nan_to_num(np.array(error.place["state"]["position"]) - origin)).max() < 2.5


def test_overflow_is_caught():
    sim = flying()
    sim.bodies[0].arrays["stress"][5] = 1e300
    assert stopped(sim).place["body"] == "block"


# frames


@pytest.mark.parametrize("material", [SOLID, RATE_SOLID, GAS], ids=["neo-hookean", "linear-elastic", "gas"])
def test_frames_are_in_the_original_order(material):
    sim = flying(material=material | {"pressure": 0.01} if material is GAS else material)
    body = sim.bodies[0]
    before = body.frame()
    advance(sim, 16)
    frame = body.frame()
    assert np.array_equal(frame["id"], np.arange(body.n_points))
    assert np.array_equal(frame["mass"], before["mass"])
    assert not np.array_equal(body.arrays["id"], frame["id"]), "the points were sorted anew"
    for name, field in FIELDS.items():
        if name in frame:
            assert np.size(frame[name]) == body.n_points * field.components, name
    assert {"position", "velocity", "density", "pressure", "stress", "mass", "id"} <= set(frame)
    assert ("internal_energy" in frame) == (material is GAS)
    if material is GAS:
        assert frame["pressure"] == pytest.approx(0.4 * frame["density"] * frame["internal_energy"], rel=1e-14)
    else:
        assert frame["pressure"] == pytest.approx(-frame["stress"][:, :3].mean(axis=1), abs=1e-12)


@pytest.mark.parametrize("material", [SOLID, RATE_SOLID], ids=["neo-hookean", "linear-elastic"])
def test_strain_energy_of_unit_mass(material):
    """A field of every solid and open to probes; that of a neo-Hookean solid is its potential, W/ρ₀."""
    wave = {"amplitude": (0.5, 0, 0), "wave_vector": (1.0, 0.5, 0)}
    sim = flying(material=material, velocity_wave=wave)
    assert "strain_energy" in sim.case.body[0].probed
    body = advance(sim, 16).bodies[0]
    frame = body.frame()
    assert "strain_energy" in body.field_names
    assert frame["mass"] @ frame["strain_energy"] == pytest.approx(body.totals.stored, rel=1e-12)
    assert body.field("stored_energy").sum() == pytest.approx(body.totals.stored, rel=1e-12)
    assert body.totals.stored > 0.0
    if material is SOLID:
        mu, lam = 1e4 / 2.6, 1e4 * 0.3 / (1.3 * 0.4)
        F = frame["deformation_gradient"].reshape(-1, 3, 3)
        ln_J = np.log(np.linalg.det(F))
        W = 0.5 * mu * ((F**2).sum(axis=(1, 2)) - 3.0) - mu * ln_J + 0.5 * lam * ln_J**2
        assert frame["strain_energy"] == pytest.approx(W / 1000.0, rel=1e-9, abs=1e-12)


def test_a_law_of_a_user_moves_a_body():
    """A Kelvin-Voigt solid swings out: what it loses is in a field of its own, and the energy budget closes."""
    wave = {"amplitude": (0.5, 0, 0), "wave_vector": (1.0, 0.5, 0)}
    plain = case(box((1, 1, 1), (3, 3, 3), SOLID, velocity_wave=wave), counts=(4, 4, 4), end=100.0, step=0.01)
    elastic = SOLID | {"kind": "user-kelvin-voigt", "viscosity": 300.0}
    viscous = plain.body[0].model_copy(update={"material": KelvinVoigtMaterial(**elastic)})
    sim = Simulation(plain.model_copy(update={"body": (viscous,)}), threads=1)
    kinetic = sim.bodies[0].totals.kinetic
    body = advance(sim, 200).bodies[0]
    heat = body.frame()["mass"] @ body.frame()["viscous_work"]
    assert body.energy_kind == "internal"
    assert 0.4 * kinetic < heat < kinetic
    assert body.totals.stored > heat
    assert "viscous_work" in viscous.probed
    assert abs(sim.budget.energy_error()) < 0.02


def test_a_shape_between_the_points_is_an_error():
    ball = {
        "name": "b",
        "shape": {"sphere": {"centre": (1.0, 1.0, 1.0), "radius": 0.2}},
        "material": SOLID,
        "points_per_cell": (2, 2, 2),
    }
    with pytest.raises(CaseError, match="no material point is inside the shape"):
        simulation(ball)


def test_a_body_that_fills_the_grid_wall_to_wall_moves_along():
    """Points on the upper walls belong to the last cell."""
    sim = simulation(box((0, 0, 0), (2, 2, 2), GAS, (3, 3, 3)), counts=(2, 2, 2), support=[{"where": "all-nodes"}])
    body = sim.bodies[0]
    edge = body.arrays["position"].copy()
    for axis in range(3):
        edge[edge[:, axis] == edge[:, axis].max(), axis] = 2.0
        edge[edge[:, axis] == edge[:, axis].min(), axis] = 0.0
    place(body, edge)
    advance(sim, 3)
    assert np.array_equal(np.sort(body.points.position, axis=0), np.sort(edge, axis=0))


@pytest.mark.parametrize("material", [SOLID, GAS | {"pressure": 0.0625}], ids=["solid", "gas"])
def test_units_do_not_matter(material):
    """Micrometres and nanoseconds: with powers of two as factors the same run gives the same bits."""
    length, time, mass = 2.0**-20, 2.0**-30, 2.0**-50
    stress = mass / length / time**2
    scales = {"density": mass / length**3, "young_modulus": stress, "pressure": stress}

    def run(length, time, scales):
        scaled = {key: value * scales.get(key, 1.0) for key, value in material.items() if isinstance(value, float)}
        wave = {"amplitude": (0.05 * length / time, 0, 0), "wave_vector": (2.0 / length, 1.0 / length, 0)}
        lower, upper = (np.array((1.0, 1.125, 0.0)) * length).tolist(), (np.array((2.5, 2.75, 1.0)) * length).tolist()
        body = box(lower, upper, material | scaled, velocity_wave=wave)
        gravity = (0.0, 0.0625 * length / time**2, 0.0)
        grid = {"counts": (4, 4, 1), "cell": length, "thickness": length}
        sim = simulation(body, **grid, courant=0.1, end=100.0 * time, gravity=gravity)
        advance(sim, 10)
        return sim.time / time, sim.bodies[0].arrays

    (one_time, one), (other_time, other) = run(1.0, 1.0, {}), run(length, time, scales)
    assert one_time == other_time
    factors = {"position": length, "velocity": length / time, "mass": mass, "volume": length**3, "stress": stress}
    factors["internal_energy"] = (length / time) ** 2
    for name, values in one.items():
        assert np.array_equal(values * factors.get(name, 1), other[name]), name


def test_a_single_point_flies_and_swings():
    """One point of one body between fixed walls, with the stress of its own strain."""
    sim = simulation(box((1.2, 1.2, 1.2), (1.8, 1.8, 1.8), SOLID, (1, 1, 1), velocity=(0.1, 0, 0)), end=10.0)
    frame = advance(sim, 10).bodies[0].frame()
    assert frame["velocity"][0] == pytest.approx((0.1, 0, 0), abs=1e-14)
    assert case(box((1, 1, 1), (2, 2, 2))).body[0].name == "block"
    assert sqrt(np.sum(frame["stress"] ** 2)) < 1e-9


def test_volume_and_deformation_gradient_of_a_turning_solid_agree():
    """V = V₀ det F, also when the points, moved forward in steps, spiral outward."""
    disc = {"cylinder": {"centre": (2.0, 2.0, 0.0), "radius": 1.2}}
    body = {"name": "disc", "shape": disc, "material": SOLID, "angular_velocity": (0.0, 0.0, 1.0)}
    sim = simulation(body, counts=(16, 16, 1), cell=0.25, step=0.02, end=10.0)
    start = sim.bodies[0].frame()
    frame = advance(sim, 60).bodies[0].frame()
    J = np.linalg.det(frame["deformation_gradient"].reshape(-1, 3, 3))
    assert np.abs(J - 1.0).max() > 1e-4
    assert frame["density"] * J == pytest.approx(start["density"], rel=1e-12)
