"""Enclosed gas and liquid: exact curves, flows against their laws, balance, step, and what is refused."""

import numpy as np
import pytest
from bags import AIR, HELD, case, shown, simulation, skin

from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.enclosure import enclosed_volume
from pellucid.results.storage import history
from pellucid.running.launch import resume_case, run_case
from pellucid.running.step_number import of_case

BURST = {"times": [0.0, 0.05, 0.1], "mass_flows": [0.0, 4.0, 0.0], "temperatures": [350.0, 350.0, 350.0]}


QUARTER = {"centre": (0, 0, 0), "radius": 1.0, "divisions": 8, "part": {"lower": (-2, 0, 0), "upper": (2, 2, 2)}}
TURNED = {"sphere": QUARTER, "rotate": [{"angle": 30, "axis": (1, 0, 0), "centre": (0, 0, 0)}]}


def volume_of(sim, number=0):
    """By a function of its own [m³]."""
    body = sim.bodies[number]
    return enclosed_volume(body.places(), body.cells().surface())


@pytest.mark.parametrize(("isothermal", "exponent"), [(False, 1.4), (True, 1.0)])
def test_a_ball_swells_along_the_curve_of_its_gas(isothermal, exponent):
    sim = simulation({"gas": AIR | {"isothermal": isothermal}}, courant=0.4)
    start = shown(sim)
    assert start["pressure"] == pytest.approx(2000.0)
    assert start["volume"] == pytest.approx(volume_of(sim), rel=1e-12)
    constant, swollen = 2000.0 * volume_of(sim) ** exponent, []
    for _ in sim:
        volume = volume_of(sim)
        assert shown(sim)["pressure"] * volume**exponent == pytest.approx(constant, rel=1e-10)
        swollen.append(volume / start["volume"])
    assert max(swollen) > 1.15
    assert shown(sim)["mass"] == start["mass"]
    assert abs(sim.budget.conservation()["energy"]) < 2e-4
    assert sim.budget.conservation()["momentum"] < 1e-12
    energies = sim.budget.energies()
    assert abs(energies["transfer_error"]) < 1e-10 * energies["enclosed_work"]
    # the pressure of the start of each step works: to first order, by .073, .036 and .018 at Courant numbers of .8, .4 and .2
    assert energies.get("enclosed_heat", 0.0) == pytest.approx(energies["enclosed_work"] if isothermal else 0.0, rel=0.04)


def test_the_balance_closes_with_the_square_of_the_step():
    errors = []
    for courant in (0.8, 0.2):
        sim = simulation({"gas": AIR, "outside": 200.0}, courant=courant)
        for _ in sim:
            pass
        errors.append(abs(sim.budget.energies()["time_integration_error"]))
    assert errors[1] < errors[0] / 10.0


def test_the_balance_closes_so_while_gas_flows_in_and_out():
    errors = []
    for courant in (0.8, 0.4):
        flows = {"inflator": BURST, "vent": [{"area": 0.02}]}
        sim = simulation({"gas": AIR | {"isothermal": True}, "outside": 200.0} | flows, courant=courant)
        for _ in sim:
            pass
        errors.append(abs(sim.budget.energies()["time_integration_error"]))
    assert errors[1] < errors[0] / 3.0


def test_an_evacuated_tank_fills_to_gamma_times_the_temperature_of_the_gas():
    sim = simulation({"gas": {"mass": 0.0, "temperature": 250.0}, "inflator": BURST}, support=[HELD])
    assert shown(sim)["pressure"] == 0.0
    for _ in sim:
        pass
    assert shown(sim)["mass"] == pytest.approx(0.2, rel=1e-12)
    assert shown(sim)["temperature"] == pytest.approx(1.4 * 350.0, rel=1e-12)
    energies = sim.budget.energies()
    assert energies["inflator_energy"] == pytest.approx(0.2 * 1004.675 * 350.0, rel=1e-12)
    assert energies["enclosed_energy"] == pytest.approx(energies["inflator_energy"], rel=1e-12)


def test_a_choked_vent_empties_a_tank_by_its_law():
    area, coefficient, pressure = 0.02, 0.8, 1e6
    vents = [{"area": 0.5 * area, "coefficient": coefficient}] * 2
    gas = {"pressure": pressure, "temperature": 300.0}
    sim = simulation({"gas": gas, "outside": 1e4, "vent": vents}, support=[HELD], end=0.5)
    volume = shown(sim)["volume"]
    rate = 0.2 * coefficient * area * 0.684731 * np.sqrt(287.05 * 300.0) / volume
    for _ in sim:
        assert shown(sim)["pressure"] == pytest.approx(pressure * (1.0 + rate * sim.time) ** -7.0, rel=1e-4)
    state, energies = shown(sim), sim.budget.energies()
    assert state["pressure"] < 0.6 * pressure
    sound = np.sqrt(287.05 * state["temperature"])
    assert state["vent_flow"] == pytest.approx(coefficient * area * 0.684731 * state["pressure"] / sound, rel=0.01)
    assert -energies["enclosed_energy"] == pytest.approx(energies["vent_energy"], rel=1e-12)


def test_a_leak_and_a_vent_let_out_as_far_as_the_pressure_outside():
    both = {"leak": 1e-5, "vent": [{"area": 0.05}]}
    sim = simulation({"gas": AIR, "outside": 1000.0} | both, support=[HELD], end=0.6)
    start, area = shown(sim), sim.bodies[0].surface_areas().sum()
    sim.step()
    state = shown(sim)
    between = 0.5 * (start["pressure"] + state["pressure"]) - 1000.0
    assert state["leak_flow"] == pytest.approx(1e-5 * area * between, rel=1e-3)
    assert state["vent_flow"] == pytest.approx(0.05 * 0.684731 * 2000.0 / np.sqrt(287.05 * 300.0), rel=0.05)
    for _ in sim:
        state = shown(sim)
        assert state["pressure"] >= 1000.0 * (1.0 - 1e-12)
        assert state["pressure"] / 2000.0 == pytest.approx((state["mass"] / start["mass"]) ** 1.4, rel=1e-9)
    assert state["pressure"] == pytest.approx(1000.0, rel=1e-4)
    assert state["leak_flow"] < 1e-5 * area * 1e-2


def test_a_vent_opens_at_its_pressure_and_stays_open():
    filled = {"inflator": BURST, "vent": [{"area": 0.1, "opens_at": 3000.0}]}
    sim = simulation({"gas": AIR} | filled, support=[HELD], end=0.5)
    opened, flowed, before = None, [], 2000.0
    for _ in sim:
        state = shown(sim)
        if opened is None and state["vent_flow"] > 0.0:
            opened = before
        before = state["pressure"]
        flowed.append(state["vent_flow"])
    assert 2500.0 < opened < 3000.0
    assert shown(sim)["pressure"] < 2900.0
    assert flowed[-1] > 0.0


def test_a_liquid_bounds_the_step_of_its_membrane_and_is_stable():
    water = {"pressure": 1e4, "bulk_modulus": 1e8, "density": 1000.0}
    sim = simulation({"liquid": water}, end=0.01)
    limit, name = sim.step_limit()
    assert (limit.cause, name) == ("spring", "")
    assert "oscillates on the enclosed `bag`" in limit.reason
    # the ball breathes as a mass on two springs: dt < 2/ω with ω² = (K/V) S/ρh, S = 3V/R, beside the membrane's own swing
    assert limit.step == pytest.approx(2.0 / np.sqrt(1e8 * 3.0 / 10.0), rel=0.05)
    start = shown(sim)["volume"]
    for _ in sim:
        assert shown(sim)["volume"] == pytest.approx(start, rel=2e-3)
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


@pytest.mark.parametrize("bulk_modulus", [1e5, 1e8])
def test_its_bound_on_the_step_is_foretold(bulk_modulus):
    water = {"liquid": {"pressure": 1e4, "bulk_modulus": bulk_modulus, "density": 1000.0}}
    foretold, sim = of_case(case(water)), simulation(water)
    assert foretold.step == pytest.approx(0.9 * sim.step_limit()[0].step, rel=0.01)
    assert ("(spring)" in foretold.why) == (bulk_modulus == 1e8)
    assert sim.step_limit()[0].cause == ("spring" if bulk_modulus == 1e8 else "membrane")


def test_the_pressure_outside_takes_its_work():
    sim = simulation({"gas": AIR, "outside": 1500.0})
    start = shown(sim)["volume"]
    for _ in sim:
        pass
    assert sim.budget.energies()["outside_work"] == pytest.approx(1500.0 * (shown(sim)["volume"] - start), rel=1e-9)
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


TUBE = {"tube": {"start": (0.1, 0.0, 0.2), "end": (0.1, 0.0, 2.2), "radius": 0.5, "points": (16, 9)}}


LATE = {"times": [10.0, 11.0], "mass_flows": [0.0, 1.0], "temperatures": [300.0, 300.0]}


@pytest.mark.parametrize(
    "content",
    [
        {"gas": {"pressure": 1e5, "temperature": 293.0}},
        {"gas": {"pressure": 1e5, "temperature": 293.0}, "inflator": LATE},
        {"liquid": {"pressure": 1e5, "bulk_modulus": 1e6, "density": 1000.0}},
    ],
)
def test_at_rest_its_rounding_is_no_error_of_the_balance(content):
    """Of 3e5 J of gas some 1e-10 J are rounding: all that moves in the membrane, so that runs stopped after 200 steps."""
    sim = simulation(content | {"outside": 1e5}, end=10.0)
    for _ in range(1000):
        sim.step()
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


def test_flat_lids_close_a_tube_and_take_their_work():
    sim = simulation({"gas": AIR, "outside": 100.0, "lids": True}, bodies=[skin(TUBE)], courant=0.3)
    start = shown(sim)
    assert start["volume"] == pytest.approx(2.0 * 8.0 * 0.25 * np.sin(np.pi / 8.0), rel=1e-12)
    body = sim.bodies[0]
    sim.step()
    assert sim.momentum() == pytest.approx(np.zeros(3), abs=1e-12)
    pushed = body.motion.loads[0]
    areas = vector_areas(body.places(), body.cells().surface())
    assert np.abs(pushed).sum() == pytest.approx(1900.0 * np.abs(areas).sum(), rel=0.05)
    assert pushed[:, 2] == pytest.approx(0.0, abs=1e-9), "the lids are not its own"
    for _ in sim:
        pass
    heights = body.places()[:, 2]
    assert np.ptp(heights) < 1.95, "it widens and shortens, and lids move"
    assert abs(sim.budget.energies()["outside_work"] - 100.0 * (shown(sim)["volume"] - start["volume"])) > 10.0
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


def test_planes_of_symmetry_close_a_quarter_of_a_ball():
    """Its pressure and volume are those of the whole ball through a swing; the balance closes."""
    ball = {"centre": (0, 0, 0), "radius": 1.0, "divisions": 8}
    whole = simulation({"gas": AIR}, bodies=[skin({"sphere": ball}, elements="quads")], courant=0.4)
    sides = [
        {"body": "skin", "where": {"box": {"lower": (-2, -1, -1), "upper": upper}}, "fix": [axis]}
        for axis, upper in (("y", (2, 1e-9, 2)), ("z", (2, 2, 1e-9)))
    ]
    body = skin({"sphere": QUARTER}, elements="quads")
    quarter = simulation({"gas": AIR, "lids": True}, bodies=[body], courant=0.4, support=sides)
    assert 4.0 * shown(quarter)["volume"] == pytest.approx(shown(whole)["volume"], rel=1e-12)
    for _ in range(100):  # their steps differ by 2e-6, since areas of nodes in the planes count along the normals of these
        whole.step()
        quarter.step()
        assert 4.0 * shown(quarter)["volume"] == pytest.approx(shown(whole)["volume"], rel=1e-5)
        assert shown(quarter)["pressure"] == pytest.approx(shown(whole)["pressure"], rel=2e-5)
    assert abs(quarter.budget.conservation()["energy"]) < 1e-3


def test_a_ball_inside_takes_from_the_volume_and_is_pushed():
    small = {"icosphere": {"centre": (0.3, 0.2, 0.1), "radius": 0.5, "refinements": 1}}
    core = skin(small, name="core", field="core")
    space = {"grid": {"lower": (-2, -2, -2), "upper": (3, 3, 3), "cell": 1.0}}
    sim = simulation({"gas": AIR, "outside": 500.0, "inside": ["core"]}, bodies=[skin(), core], **space)
    outer, inner = sim.bodies
    assert shown(sim)["volume"] == pytest.approx(volume_of(sim, 0) - volume_of(sim, 1), rel=1e-12)
    for body in sim.bodies:
        body.begin(0.0)
    sim.stages.begin(0.0, 0.0)
    assert outer.motion.loads[0] == pytest.approx(1500.0 * outer.pressed_areas(), rel=1e-12)
    assert inner.motion.loads[0] == pytest.approx(-1500.0 * inner.pressed_areas(), rel=1e-12)


def test_runs_go_on_bit_for_bit_with_their_columns(tmp_path):
    held = {"gas": AIR, "outside": 100.0, "inflator": BURST, "vent": [{"area": 0.02, "opens_at": 2500.0}], "leak": 1e-5}
    output = {"output": {"history": 0.01, "frames": 0.1}}
    whole = run_case(case(held, **output), tmp_path / "whole", threads=1, report=False)
    run_case(case(held, **output), tmp_path / "two", threads=2, until=0.09, report=False)
    resume_case(tmp_path / "two", threads=2, report=False)
    first, second = ((tmp_path / name / "history.csv").read_bytes() for name in ("whole", "two"))
    assert first == second
    columns = history.read(tmp_path / "whole" / "history.csv")
    for name in ("pressure", "volume", "mass", "temperature", "vent_flow", "leak_flow"):
        assert np.ptp(columns[f"bag_{name}"]) > 0.0, name
    for name in ("enclosed_work", "enclosed_energy", "outside_work", "inflator_energy", "vent_energy"):
        assert np.ptp(columns[name]) > 0.0, name
    assert np.abs(columns["energy_error"]).max() < 5e-3
    assert whole.finished


@pytest.mark.parametrize(
    ("change", "more", "words"),
    [
        ({"gas": None, "leak": 1e-3}, {}, "has leak but neither gas nor liquid; give `gas`"),
        ({"liquid": {"mass": 1.0, "bulk_modulus": 1e9, "density": 1e3}}, {}, "both a gas and a liquid"),
        ({"gas": {"temperature": 300.0}}, {}, "either `mass` or `pressure`"),
        ({"gas": AIR | {"mass": 1.0}}, {}, "either `mass` or `pressure`"),
        ({"gas": AIR | {"temperature": 0.0}}, {}, "temperature"),
        ({"gas": AIR | {"gamma": 1.0}}, {}, "gamma"),
        ({"vent": [{"area": 0.0}]}, {}, "area"),
        ({"body": "skn"}, {}, "no body has this name; available names: skin"),
        ({"lids": True}, {}, "the surface of body skin is closed: it has no rim"),
        ({}, {"bodies": [skin(TUBE)]}, "the surface of body skin is open: it encloses no volume"),
        ({"inflator": {"times": [0, 1], "mass_flows": [1, 1]}}, {}, "has no temperatures"),
        ({"inflator": BURST | {"mass_flows": [0, -1, 0]}}, {}, "an inflator cannot have outflow"),
        ({"inflator": BURST | {"times": [0, 0, 1]}}, {}, "does not come after"),
        ({"inside": ["skin"]}, {}, "body skin is named twice"),
        ({"lids": True}, {"bodies": [skin(TURNED, elements="quads")]}, "a rim of body skin is bent: its points lie 31 %"),
        ({"name": "outflow"}, {}, "history already has a column outflow_mass"),
        ({}, {"grid": {"lower": (-2, -2, 0.0), "upper": (2, 2, 0.2), "cell": 0.2}}, "plane problem|beyond the grid"),
        ({}, {"pressure": [{"body": "skin", "volume": {"times": [0, 1], "ratios": [1, 2]}}]}, "is enclosed in body skin"),
        ({}, {"steady": {"method": "relaxation"}}, "cannot find the equilibrium of a membrane with a gas or liquid"),
        (
            {},
            {"probe": [{"name": "bag_mass", "body": "skin", "quantity": "mass"}]},
            "the name is reserved for a column of the history",
        ),
    ],
)
def test_contents_that_make_no_sense(change, more, words):
    table = {"gas": AIR} | change
    with pytest.raises(ValueError, match=words):
        case({key: value for key, value in table.items() if value is not None}, **more)


def test_a_membrane_holds_one_gas():
    with pytest.raises(ValueError, match="body skin already contains `bag`"):
        case({"gas": AIR}, {"gas": AIR})


def test_a_flat_membrane_holds_nothing():
    disc = {"disc": {"centre": (0, 0, 0), "normal": (0, 0, 1), "radius": 1.0, "rings": 3}}
    with pytest.raises(ValueError, match="body skin is flat at the start"):
        case({"gas": AIR, "lids": True}, bodies=[skin(disc)])


def test_plots_and_checks_know_its_columns():
    check = {"name": "mass", "column": "bag_mass", "reference": "1 kg", "tolerance": "0.1 kg", "source": "a test"}
    plot = [{"name": "curve", "x": "bag_volume", "y": ["bag_pressure", "bag_gauge_pressure"]}]
    assert case({"gas": AIR}, plot=plot, check=[check])
    with pytest.raises(ValueError, match="leak") as caught:
        case({"gas": AIR, "leak": -1.0}, plot=plot, check=[check])
    assert "not a column" not in str(caught.value), "what is wrong might have them"


def test_a_bag_settles_on_its_gas_before_the_clock_starts():
    sim = simulation(
        {"gas": AIR | {"pressure": 3000.0}, "outside": 1000.0, "leak": 1e-4, "inflator": BURST}, settle={}, courant=0.4
    )
    start = shown(sim)
    sim.settle()
    state, radius = shown(sim), (volume_of(sim) / (4.0 / 3.0 * np.pi)) ** (1.0 / 3.0)
    assert state["mass"] == start["mass"], "nothing flows while time stands still"
    assert state["pressure"] == pytest.approx(3000.0 * (start["volume"] / state["volume"]) ** 1.4, rel=1e-9)
    # p R/2 is the tension of a ball: E h (λ - 1)/(1 - ν) where the strain is small
    stretch = (state["volume"] / start["volume"]) ** (1.0 / 3.0)
    assert (state["pressure"] - 1000.0) * radius / 2.0 == pytest.approx(1e4 / 0.7 * np.log(stretch), rel=0.05)
    assert sim.budget.energies()["enclosed_energy"] == 0.0, "the balance begins with the clock"
    for _ in sim:
        pass
    assert shown(sim)["mass"] < start["mass"] + 0.2
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


@pytest.mark.parametrize("kind", ["membrane-points", "membrane-elements"])
def test_membranes_on_the_grid_hold_gas_too(kind):
    fine = {"icosphere": {"centre": (8.03, 8.01, 7.98), "radius": 5.0, "refinements": 4}}
    other = {"rectangle": {"corner": (1, 1, 1), "first_edge": (1, 0, 0), "second_edge": (0, 1, 0), "points": (5, 5)}}
    bodies = [skin(fine, kind=kind), skin(other, kind="membrane-points", name="other")]
    for body in bodies:
        if body["kind"] == "membrane-points":
            del body["elements"]
    burst = BURST | {"times": [0.0, 0.5, 1.0], "mass_flows": [0.0, 2.0, 0.0]}
    grid = {"grid": {"lower": (0, 0, 0), "upper": (16, 16, 16), "cell": 1.0}}
    empty = {"mass": 0.0, "temperature": 300.0}
    sim = simulation({"gas": empty, "inflator": burst}, bodies=bodies, end=1.2, courant=0.5, **grid)
    for _ in sim:
        pass
    state = shown(sim)
    assert state["volume"] == pytest.approx(volume_of(sim), rel=1e-12)
    assert state["mass"] == pytest.approx(1.0, rel=1e-12)
    assert state["pressure"] == pytest.approx(287.05 * state["temperature"] * state["mass"] / state["volume"], rel=1e-12)
    assert state["volume"] > 1.005 * 4.0 / 3.0 * np.pi * 125.0
    assert np.abs(sim.budget.conservation()["energy"]) < 2e-3
