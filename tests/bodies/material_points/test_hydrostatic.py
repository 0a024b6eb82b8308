"""Bodies of fluid that are at rest under gravity from the start."""

import numpy as np
import pytest
from small_cases import GAS, SLIP, SOLID, box, case, simulation

from pellucid.approximants import GRID_FUNCTIONS
from pellucid.case.checking import checked
from pellucid.case.spec import Case
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

WATER = {"kind": "fluid", "density": 1000.0, "eos": {"kind": "tait", "sound_speed": 20.0}}
DOWN = {"x": (-9.81, 0.0, 0.0), "y": (0.0, -9.81, 0.0), "z": (0.0, 0.0, -9.81)}
CELL = 0.1


def tank(axis="z", upwards=False, top=0.4, per_cell=(3, 3, 3), material=WATER, hydrostatic=None, **more):
    """Water in a box of 4 x 4 x 6 cells, filled up to `top` against gravity."""
    up = "xyz".index(axis)
    counts, lower, upper = [4, 4, 4], [0.0] * 3, [0.4] * 3
    counts[up] = 6
    lower[up], upper[up] = (0.6 - top, 0.6) if upwards else (0.0, top)
    gravity = np.array(DOWN[axis]) * (-1.0 if upwards else 1.0)
    water = box(lower, upper, material, per_cell, hydrostatic={} if hydrostatic is None else hydrostatic)
    settings = {"cell": CELL, "gravity": tuple(gravity), "support": SLIP, "functions": "quadratic-bspline"}
    return case(water, counts=counts, **(settings | more))


@pytest.mark.parametrize("upwards", [False, True])
@pytest.mark.parametrize("axis", DOWN)
def test_pressure_grows_along_gravity(axis, upwards):
    body = Simulation(tank(axis, upwards), threads=1).bodies[0]
    along = body.arrays["position"][:, "xyz".index(axis)]
    depth = along - 0.2 if upwards else 0.4 - along
    density, state = body.material.at_rest(9.81, depth)
    assert body.stored_field("pressure") == pytest.approx(-state["stress"][:, 0], rel=1e-12)
    assert body.stored_field("pressure") == pytest.approx(9810.0 * depth, rel=0.01)  # it is compressed by g s/c² = 1 %
    assert body.arrays["mass"] == pytest.approx(density * body.arrays["volume"], rel=1e-15)


def fastest(sim, until=0.1):
    """Greatest speed of a point [m/s] when sound has gone through the tank two and a half times."""
    while sim.time < until:
        sim.step()
    return np.linalg.norm(sim.bodies[0].arrays["velocity"], axis=1).max()


@pytest.mark.parametrize(("functions", "transfer"), [*((functions, "flip") for functions in GRID_FUNCTIONS), ("gimp", "apic")])
def test_it_stays_at_rest(functions, transfer):
    """At a surface on a face of cells, three points along each axis with quadratic B-splines, two with GIMP and linear
    functions are in balance but for the water's compression; cubic ones are not."""
    per_cell = (3, 3, 3) if "bspline" in functions else (2, 2, 2)
    sim = Simulation(tank(functions=functions, transfer=transfer, per_cell=per_cell), threads=1)
    assert fastest(sim) < (2e-3 if functions == "cubic-bspline" else 2e-5)
    assert abs(sim.budget.conservation()["energy"]) < 1e-8


def test_without_it_the_water_falls():
    water = box((0, 0, 0), (0.4, 0.4, 0.4), WATER, (2, 2, 2))
    sim = simulation(water, counts=(4, 4, 6), cell=CELL, gravity=DOWN["z"], support=SLIP, energy={"stop": 1.0})
    assert fastest(sim) > 0.02


def test_the_level_counts_from_the_origin_and_a_gas_rests_above_water():
    """Both have 1e5 Pa at the level between them."""
    gas = GAS | {"density": 1.2, "pressure": 1e5}
    water = WATER | {"pressure": 1e5}
    lower = box((0, 0, 0), (0.4, 0.4, 0.3), water, (3, 3, 3), name="water", hydrostatic={"level": 0.3})
    upper = box((0, 0, 0.3), (0.4, 0.4, 0.6), gas, (3, 3, 3), name="gas", hydrostatic={"level": "30 cm"})
    sim = simulation(lower, upper, counts=(4, 4, 6), cell=CELL, gravity=DOWN["z"], support=SLIP, functions="quadratic-bspline")
    for body, density in zip(sim.bodies, (1000.0, 1.2), strict=True):
        height = body.arrays["position"][:, 2]
        assert body.stored_field("pressure") - 1e5 == pytest.approx(density * 9.81 * (0.3 - height), rel=0.01)


def test_oblique_gravity():
    gravity = (3.0, 0.0, -9.0)
    water = box((0, 0, 0), (0.4, 0.4, 0.4), WATER, hydrostatic={"level": 1.0})
    body = simulation(water, counts=(4, 4, 4), cell=CELL, gravity=gravity, support=SLIP).bodies[0]
    strength = np.linalg.norm(gravity)
    depth = 1.0 + body.arrays["position"] @ gravity / strength
    assert body.stored_field("pressure") == pytest.approx(1000.0 * strength * depth, rel=0.02)  # compressed by 2 %


@pytest.mark.parametrize(
    ("changes", "place", "words"),
    [
        ({"gravity": (0, 0, 0)}, (), "no gravity"),
        ({"material": SOLID}, (), "is not a fluid, so it cannot be in hydrostatic equilibrium"),
        ({"gravity": (0.0, -1.0, -9.0)}, ("level",), "gravity is not along an axis"),
        ({"hydrostatic": {"level": 0.2}}, (), "this fluid has no state at rest under this gravity above a height of 0.2 m"),
        ({"material": GAS, "hydrostatic": {"level": -1.0}}, (), "above a height of"),
    ],
)
def test_what_cannot_rest(changes, place, words):
    data = tank().to_data()
    for name, value in changes.items():
        (data if name == "gravity" else data["body"][0])[name] = value
    found = checked(Case, data)[1]
    assert [item.path for item in found] == [("body", 0, "hydrostatic", *place)]
    assert words in found[0].text


@pytest.mark.parametrize("sound_speed", [20.0, 1500.0])
@pytest.mark.parametrize("level", [1e9, 1e30])
@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (1.0, 0.0, -9.0)])
def test_a_level_so_far_away_that_the_fluid_there_is_another(level, gravity, sound_speed):
    data = tank().to_data() | {"gravity": gravity}
    data["body"][0]["hydrostatic"] = {"level": level}
    data["body"][0]["material"]["eos"]["sound_speed"] = sound_speed
    (found,) = checked(Case, data)[1]
    assert found.path == ("body", 0, "hydrostatic", "level")
    assert "far outside the grid, which covers the heights" in found.text
    assert "remove the level" in found.remedy


def test_a_level_some_way_above_the_grid_is_no_fault():
    """Water 50 m under its surface is still the water described."""
    data = tank().to_data()
    data["body"][0] |= {"hydrostatic": {"level": 50.0}}
    data["body"][0]["material"]["eos"]["sound_speed"] = 1500.0
    assert checked(Case, data)[1] == []


def test_an_oblique_column_that_ends_is_told_when_it_is_filled():
    water = box((0, 0, 0), (0.4, 0.4, 0.4), WATER, hydrostatic={"level": 0.1})
    with pytest.raises(CaseError, match=r"this fluid has no state at rest under this gravity above a height of 0\.1 m"):
        simulation(water, counts=(4, 4, 4), cell=CELL, gravity=(3.0, 0.0, -9.0), support=SLIP)
