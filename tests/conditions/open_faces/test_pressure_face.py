"""Open faces under a pressure: developed and pulsating channel flow, flow that reverses, balances."""

import json

import numpy as np
import pytest
from small_cases import GAS, SLIP, advance, assert_same_arrays, box, case, copied_state, finished, to_the_end

import pellucid
from pellucid.case import Case
from pellucid.errors import CaseError
from pellucid.set_up.flows import flow_warnings
from pellucid.simulation.simulation import Simulation

IMPLICIT = {"implicit_pressure": True}
SCHEMES = {
    "trilinear": {"transfer": "apic"},
    "trilinear, FLIP": {"transfer": "flip"},
    "B-splines": {"transfer": "apic", "functions": "quadratic-bspline"},
    "B-splines, FLIP": {"transfer": "flip", "functions": "quadratic-bspline"},
    "implicit": {"transfer": "apic", "functions": "quadratic-bspline", "scheme": "usl", "material": IMPLICIT},
    "implicit, FLIP": {"transfer": "flip", "functions": "quadratic-bspline", "scheme": "usl", "material": IMPLICIT},
}


def channel(inlet, cells=10, length=2.0, height=1.0, sound_speed=40.0, material=None, **more):
    """A liquid of unit density and viscosity in a channel of `cells` cells across, between an inflow with the keys `inlet` and
    an outflow of no pressure."""
    cell = height / cells
    eos = {"kind": "tait", "sound_speed": sound_speed, "carries_tension": True}
    liquid = {"kind": "fluid", "density": 1.0, "pressure": 0.0, "viscosity": 1.0, "eos": eos} | (material or {})
    fluid = box((0, 0, 0), (length, height, cell), liquid, (2, 2, 1), name="fluid")
    walls = [{"where": "y-lower"}, {"where": "y-upper"}]
    counts = (round(length / cell), cells, 1)
    tables = case(fluid, counts=counts, cell=cell, support=walls, thickness=1.0, **more).to_data()
    tables["inflow"] = [{"where": "x-lower", "body": "fluid"} | inlet]
    return Case.model_validate(tables | {"outflow": [{"where": ["x-upper"], "pressure": 0.0}]})


def mean_pressures(tables, since):
    """Mean pressure [Pa] in each layer of cells along a channel after the time `since` [s], and the positions of the layers."""
    sim, sums = Simulation(tables, threads=1), 0.0
    while not sim.clock.finished(None):
        sim.step()
        if sim.time > since and sim.n_steps % 5 == 0:
            x, p, m, density = (sim.bodies[0].field(name) for name in ("position", "pressure", "mass", "density"))
            volume, layer = m / density, (x[:, 0] / tables.grid.cell).astype(int)
            sums += np.array([np.bincount(layer, volume, 20), np.bincount(layer, volume * p, 20)])
    return (np.arange(20) + 0.5) * tables.grid.cell, sums[1] / sums[0]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_pressure_acts_at_the_face(scheme):
    """The pressure falls by 8 Pa/m from 16 Pa at one face to zero at the other, also in the first and last cells."""
    x, pressure = mean_pressures(channel({"pressure": 16.0}, end=0.9, **SCHEMES[scheme]), 0.45)
    slope, at_inlet = np.polyfit(x[4:16], pressure[4:16], 1)
    assert slope == pytest.approx(-8.0, rel=0.01)
    assert at_inlet == pytest.approx(16.0, rel=0.01)
    assert at_inlet + 2.0 * slope == pytest.approx(0.0, abs=0.16)
    assert np.abs(pressure - 8.0 * (2.0 - x)).max() < 0.16


def womersley(time, slope, height, frequency):
    """Mean velocity [m/s] in a channel of unit density and viscosity that starts from rest under the pressure gradient
    G cos(ωt): modes a_n sin(nπy/H) 4/(nπ) with a_n' + (nπ/H)² a_n = G cos(ωt), whose means over y are 8 a_n/(nπ)²."""
    n = np.arange(1, 400, 2)[:, None]
    decay = (n * np.pi / height) ** 2
    swing = decay * np.cos(frequency * time) + frequency * np.sin(frequency * time)
    modes = slope * (swing - decay * np.exp(-decay * time)) / (decay**2 + frequency**2)
    return np.sum(8.0 / (n * np.pi) ** 2 * modes, axis=0)


def pulse(frequency, end):
    """A cosine as a table of shares in time."""
    times = np.linspace(0.0, end, 1001)
    return {"times": times.tolist(), "shares": np.cos(frequency * times).tolist()}


@pytest.mark.parametrize("scheme", ["trilinear", "B-splines, FLIP", "implicit"])
def test_a_pulsating_flow_reverses_at_both_faces(scheme):
    """Mean velocity as in a long channel, with the Womersley number 4. Compression by 64 Pa adds 0.4 % (ρc² = 25.6 kPa)."""
    inlet = {"pressure": 64.0, "amplitude": pulse(16.0, 0.8)}
    tables = channel(inlet, cells=16, length=4.0, height=2.0, sound_speed=160.0, end=0.8, **SCHEMES[scheme])
    sim, times, means = Simulation(tables, threads=1), [], []
    while not sim.clock.finished(None):
        sim.step()
        v, m = sim.bodies[0].field("velocity"), sim.bodies[0].field("mass")
        times.append(sim.time)
        means.append(np.average(v[:, 0], weights=m))
    exact = womersley(np.array(times), 16.0, 2.0, 16.0)
    assert np.abs(exact).max() > 0.9
    assert np.abs(means - exact).max() < 0.02 * np.abs(exact).max()
    assert sim.budget.inflow["points"] > 100
    assert sim.budget.outflow["points"] > 100
    conservation = sim.budget.conservation()
    assert conservation["mass"] < 1e-14
    assert conservation["momentum"] < 1e-12
    assert abs(conservation["energy"]) < 1e-12


def tube(inlet, outlet, end=6.0, **more):
    """A gas in a tube of ten cells with frictionless walls, at rest at first, between two pressures [Pa]."""
    walls = [support for support in SLIP if not support["where"].startswith("x")]
    gas = box((0, 0, 0), (10, 3, 1), GAS, (2, 2, 1), name="gas")
    tables = case(gas, counts=(10, 3, 1), support=walls, end=end, energy={"warn": 9.0, "stop": 10.0}, **more).to_data()
    tables["inflow"] = [{"where": "x-lower", "body": "gas", "pressure": inlet}]
    return Case.model_validate(tables | {"outflow": [{"where": ["x-upper"], "pressure": outlet}]})


def test_both_faces_follow_one_rule():
    """A flow from the outlet to the inlet is the mirror image of one from the inlet to the outlet."""
    there, back = (to_the_end(tube(*pressures)) for pressures in ((1.3, 0.7), (0.7, 1.3)))
    assert there.budget.entered_points == back.budget.entered_points > 0
    assert there.budget.left_points == back.budget.left_points > 0
    momenta = [sim.bodies[0].field("velocity")[:, 0] @ sim.bodies[0].field("mass") for sim in (there, back)]
    assert momenta[0] == pytest.approx(-momenta[1], rel=1e-10)
    assert momenta[0] > 1.0
    for work in ("inflow_energy", "outflow_energy"):
        assert there.budget.energies()[work] == pytest.approx(back.budget.energies()[work], rel=1e-10)
    assert there.budget.energies()["inflow_work"] == pytest.approx(back.budget.energies()["outflow_work"], rel=1e-10)


@pytest.mark.parametrize("more", [{}, {"transfer": "apic", "functions": "quadratic-bspline"}])
def test_a_checkpoint_continues_a_reversed_flow_bit_for_bit(more):
    tables = tube(0.7, 1.3, **more)
    straight = advance(Simulation(tables, threads=1), 30)
    arrays = copied_state(straight)
    other = Simulation(tables, threads=1)
    other.restore(arrays, json.loads(json.dumps(straight.state_numbers())))
    for sim in (straight, other):
        advance(sim, 10)
    assert straight.budget.entered_points > 0
    assert_same_arrays(copied_state(straight), copied_state(other))


def test_another_run_starts_from_one_with_a_pressure_outlet(tmp_path):
    """Points that entered are there, and more can enter."""
    tables = tube(0.7, 1.3, end=3.0).to_data() | {"inflow": [], "output": {"frames": 1.0}}
    tables["outflow"].append({"where": ["x-lower"], "pressure": 0.7})
    first = pellucid.run(Case.model_validate(tables), out=tmp_path / "first", report=False)
    assert first.summary["inflow"]["points"] > 0
    second = pellucid.run(Case.model_validate(tables | {"start": {"path": str(tmp_path / "first")}}))
    assert second.fields("gas", 0.0)["mass"].sum() == pytest.approx(first.fields("gas")["mass"].sum(), rel=1e-12)
    assert second.summary["conservation"]["mass"] < 1e-14


def test_threads_do_not_change_a_reversed_flow():
    one, two = (advance(Simulation(tube(0.7, 1.3), threads=n), 40) for n in (1, 2))
    assert one.budget.entered_points > 0
    assert_same_arrays(copied_state(one), copied_state(two))


def test_the_face_stays_constrained_along_itself_when_a_support_ends():
    """Also its node at the wall that is let go."""
    tables = channel({"pressure": 1.0}, end=0.03).to_data()
    tables["support"][1]["until"] = 0.01
    sim = Simulation(Case.model_validate(tables), threads=1)
    grid = sim.velocity_fields[0].grid
    index, place = grid.where()
    nodes = index[(place[:, 0] == 0.0) & (place[:, 1] > 0.5)]
    assert np.count_nonzero(grid.nodes.constrained[nodes, 0]) == 1
    finished(sim)
    assert not grid.nodes.constrained[nodes, 0].any()
    assert grid.nodes.constrained[nodes, 1].all()


def test_other_bodies_do_not_enter():
    """A solid block at the outlet leaves; nothing follows where no fluid reaches the face at the start."""
    block = box((8, 0, 0), (10, 3, 1), name="block", velocity=(2, 0, 0))
    tables = case(block, counts=(10, 3, 1), end=0.2).to_data() | {"outflow": [{"where": ["x-upper"], "pressure": 1.0}]}
    sim = to_the_end(Case.model_validate(tables))
    assert sim.budget.entered_points == 0
    assert sim.budget.left_points > 0


@pytest.mark.parametrize("inlet", [{"pressure": 1.0}, {"velocity": 1.0}])
def test_an_opening_that_another_body_fills_is_refused(inlet):
    tables = tube(1.0, 1.0).to_data()
    plug = box((0, 0, 0), (1, 3, 1), GAS, (2, 2, 1), name="plug")
    tables["body"] = [tables["body"][0] | {"outside": ["plug"]}, plug]
    tables["inflow"] = [{"where": "x-lower", "body": "gas"} | inlet]
    words = "no point of body gas could enter through the face x-lower: other bodies fill it"
    with pytest.raises(CaseError, match=words):
        Simulation(Case.model_validate(tables))


def test_a_profile_without_effect_is_reported():
    (text,) = flow_warnings(channel({"pressure": 1.0, "profile": "parabolic"}))
    assert text.startswith("inflow number 1: `profile` has no effect with `pressure`")
    assert not list(flow_warnings(channel({"pressure": 1.0})))
    assert not list(flow_warnings(channel({"velocity": 1.0, "profile": "parabolic"})))


def test_a_tension_beyond_the_equation_of_state_is_reported_and_does_not_stop_the_run():
    """Tait: at least -ρc²/7 = -57 Pa, so that the liquid at the inlet expands; new points have half of the density."""
    swing = {"amplitude": {"times": [0.0, 0.1, 0.2, 0.3], "shares": [-1.0, -1.0, 1.0, -1.0]}}
    tables = channel({"pressure": 64.0} | swing, sound_speed=20.0, end=0.35)
    (text,) = flow_warnings(tables)
    assert "inflow number 1: its pressure falls to -64 Pa, but a pressure of body fluid cannot be below -57.14 Pa" in text
    with pytest.warns(UserWarning, match="cannot be below"):
        sim = to_the_end(tables)
    assert sim.budget.entered_points > 0
    state = {"mass": np.ones(1), "volume": np.ones(1), "stress": np.zeros((1, 6)), "internal_energy": np.zeros(1)}
    assert tables.body[0].material.pressed(state, -64.0)["mass"] == pytest.approx(0.5)
