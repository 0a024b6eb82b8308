"""Membranes whose points fail: what is enclosed flows out through the holes, and no pressure acts on them."""

import warnings
from math import inf

import numpy as np
import pytest
from bags import shown

from pellucid.case import Case
from pellucid.conditions.enclosed.contents import Gas, Liquid
from pellucid.errors import RunStopped
from pellucid.results.storage import history
from pellucid.running.launch import resume_case, run_case
from pellucid.simulation.simulation import Simulation

RUBBER = {"kind": "neo-hookean-membrane", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.45}
WEAK = {"elastic_limit": 0.1, "stiffness_loss": 1.0, "rate": 1.0, "failure_strain": 0.15}
STRONG = WEAK | {"elastic_limit": 5.0, "failure_strain": 6.0}
OUTSIDE = 1e5
AIR = {"gas": {"pressure": OUTSIDE, "temperature": 300.0}, "outside": OUTSIDE}
BLOWN = AIR | {"inflator": {"times": [0, 0.12], "mass_flows": [0.6, 0.6], "temperatures": [300, 300]}}


def balloon(damage=WEAK, name="skin", radius=0.15, **more):
    surface = {"icosphere": {"centre": (0, 0, 0), "radius": radius, "refinements": 2}}
    body = {"name": name, "kind": "membrane-points", "surface": surface, "thickness": 5e-4, "damping": 20}
    return body | {"material": RUBBER | ({"damage": damage} if damage else {})} | more


def case(*enclosed, bodies=None, end=0.1, **more):
    held = [{"name": f"bag{number or ''}", "body": "skin"} | each for number, each in enumerate(enclosed)]
    grid = {"lower": (-0.4, -0.4, -0.4), "upper": (0.4, 0.4, 0.4), "cell": 0.1}
    table = {"schema": 1, "title": "a test", "grid": grid, "time": {"end": end}, "body": bodies or [balloon()]}
    return Case.model_validate(table | {"enclosed": held} | more)


def tear(sim, points, number=0):
    """Let the points of these numbers fail."""
    body = sim.bodies[number]
    body.arrays["failed"][np.isin(body.arrays["id"], points)] = 1.0


def told(sim):
    return list(sim.parts.warnings(inf).values())


def test_a_balloon_that_bursts_lets_its_gas_out():
    sim = Simulation(case(BLOWN), threads=1)
    with pytest.warns(UserWarning, match=r"membrane skin has failed at .* through which `bag` flows out"):
        for _ in sim:
            pass
    state = shown(sim)
    failed = sim.bodies[0].field("failed") > 0.0
    assert failed.mean() > 0.5
    assert state["hole_area"] == pytest.approx(sim.bodies[0].surface_areas()[failed].sum())
    assert state["gauge_pressure"] == pytest.approx(0.0, abs=1e-6 * OUTSIDE)
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


def test_gas_flows_through_a_hole_as_through_a_nozzle_of_its_area():
    """A choked one, of a balloon that cannot move."""
    pressed = {"gas": {"pressure": 1e6, "temperature": 300.0}, "outside": OUTSIDE}
    held = [{"where": "all-nodes"}]
    sim = Simulation(case(pressed, bodies=[balloon(STRONG)], support=held, end=0.02), threads=1)
    tear(sim, [7])
    sim.step()  # finds the hole at its end
    area, start, since = sim.bodies[0].surface_areas()[7], shown(sim), sim.time
    rate = 0.2 * area * 0.684731 * np.sqrt(287.05 * start["temperature"]) / start["volume"]
    assert start["hole_area"] == pytest.approx(area, rel=1e-12)
    for _ in sim:
        exact = start["pressure"] * (1.0 + rate * (sim.time - since)) ** -7.0
        assert shown(sim)["pressure"] == pytest.approx(exact, rel=1e-4)
    assert shown(sim)["pressure"] < 0.9e6


def test_what_leaves_through_a_hole_pushes_the_balloon():
    """No pressure acts on the hole, so that the forces of the others no longer add up to zero."""
    pressed = {"gas": {"pressure": 2e5, "temperature": 300.0}, "outside": OUTSIDE}
    sim = Simulation(case(pressed, bodies=[balloon(STRONG, damping=0)]), threads=1)
    number = int(np.argmax(sim.bodies[0].places()[:, 0]))
    sim.step()
    assert np.abs(sim.bodies[0].totals.momentum).max() < 1e-12
    tear(sim, [number])
    sim.step()  # finds the hole at its end
    whole = sim.bodies[0].pressed_areas()[number]
    before, pressure, start = sim.bodies[0].totals.momentum.copy(), shown(sim)["gauge_pressure"], sim.time
    sim.step()
    thrust = (sim.bodies[0].totals.momentum - before) / (sim.time - start)
    assert thrust == pytest.approx(-pressure * whole, rel=0.05, abs=0.02 * pressure * np.linalg.norm(whole))


@pytest.mark.slow
def test_a_torn_balloon_goes_on_bit_for_bit(tmp_path):
    table = {"output": {"history": 0.005}}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run_case(case(BLOWN, end=0.04, **table), tmp_path / "whole", threads=2)
        run_case(case(BLOWN, end=0.04, **table), tmp_path / "part", until=0.02, threads=1)
        resume_case(tmp_path / "part", threads=1)
    whole, part = (history.read(tmp_path / name / "history.csv") for name in ("whole", "part"))
    assert whole["bag_hole_area"][-1] > 0.0
    assert "bag_hole_flow" in whole
    for name, values in whole.items():
        assert np.array_equal(values, part[name]), name


def test_a_membrane_without_damage_has_no_columns_of_holes():
    sim = Simulation(case(AIR, bodies=[balloon(None)]), threads=1)
    assert "hole_area" not in shown(sim)


def test_plots_know_the_columns_of_holes():
    plot = [{"name": "curve", "x": "bag_hole_area", "y": ["bag_hole_flow"]}]
    assert case(BLOWN, plot=plot)
    with pytest.raises(ValueError, match=r"plot\.0\.x: not a column of the history; .*bag_mass"):
        case(BLOWN, plot=plot, bodies=[balloon(None)])


def test_a_torn_membrane_inside_stops_the_run():
    inner = balloon(STRONG, name="inner", radius=0.08)
    sim = Simulation(case(AIR | {"inside": ["inner"]}, bodies=[balloon(STRONG), inner]), threads=1)
    tear(sim, [3], number=1)
    with pytest.raises(RunStopped, match="membrane inner inside `bag` has failed at 1 points"):
        sim.step()


def test_a_given_volume_tells_of_holes():
    given = {"body": "skin", "volume": {"times": [0, 1], "ratios": [1, 1.1]}}
    sim = Simulation(case(bodies=[balloon(STRONG)], pressure=[given]), threads=1)
    assert told(sim) == []
    tear(sim, [3])
    sim.step()
    (text,) = told(sim)
    assert "maintained as if it had no holes" in text
    assert "use an [[enclosed]] gas or liquid" in text


@pytest.mark.parametrize("where", [{}, {"where": {"box": {"lower": (0, -1, -1), "upper": (1, 1, 1)}}}], ids=["all", "region"])
def test_a_given_pressure_does_not_act_on_holes(where):
    """Two membranes that differ by a failed point get forces that differ on this point alone."""
    given = {"body": "skin", "value": 1e3} | where
    momenta = []
    for torn in (False, True):
        sim = Simulation(case(bodies=[balloon(STRONG, damping=0)], pressure=[given]), threads=1)
        number = int(np.argmax(sim.bodies[0].places()[:, 0]))
        area = sim.bodies[0].pressed_areas()[number]
        if torn:
            tear(sim, [number])
        sim.step()
        momenta.append(sim.bodies[0].totals.momentum / sim.time)
        assert len(told(sim)) == torn
    assert momenta[0] - momenta[1] == pytest.approx(1e3 * area, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    "contents", [Gas(0.02, 300.0, 1.4, 287.05, False), Gas(0.02, 300.0, 1.4, 287.05, True), Liquid(9.0, 1e7, 1000.0, 0.01)]
)
def test_what_is_drawn_in_lets_the_pressure_rise_to_that_outside(contents):
    volume = 0.02
    outside = contents.pressure(volume) + 1e4
    before, flux = contents.energy, contents.influx(volume, outside)
    assert flux > 0.0
    energy, heat = contents.draw_in(contents.lack(volume, outside), volume)
    assert contents.pressure(volume) == pytest.approx(outside, rel=1e-12)
    assert contents.energy - before == pytest.approx(energy + heat, rel=1e-9)
