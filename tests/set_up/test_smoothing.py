"""Transfers that smooth a flow more than its viscosity does: the rate, the passage, and the warning."""

import numpy as np
import pytest
from small_cases import box, case

from pellucid.approximants import grid_functions
from pellucid.case import Case
from pellucid.grid.velocity_transfer import TRANSFERS
from pellucid.set_up.smoothing import damping, drag_at_walls, narrowest_passage
from pellucid.simulation.simulation import Simulation

THIN, PERIODIC = (False, False, True), (True, False, False)
WATER = {"kind": "fluid", "density": 1000.0, "viscosity": 0.001, "eos": {"kind": "tait", "sound_speed": 25.0}}


def rate(transfer, functions, cells):
    """Damping per step of a wave of `cells` cells."""
    function = grid_functions(functions, (2, 2, 1), THIN, PERIODIC)[1]
    return damping(TRANSFERS[transfer](0.99), function, 2.0 * np.pi / cells)


@pytest.mark.parametrize(
    ("transfer", "functions", "share"),
    [
        ("pic", "trilinear", 1 / 6),
        ("pic", "quadratic-bspline", 1 / 4),
        ("blend", "quadratic-bspline", 1 / 400),
        ("flip", "trilinear", 0),
    ],
)
def test_transfers_smooth_like_a_viscosity(transfer, functions, share):
    """Long waves: ν Δt/h² is half of the sum of the variances of both mappings."""
    wave = 2.0 * np.pi / 64
    assert rate(transfer, functions, 64) == pytest.approx(share * wave**2, rel=2e-3, abs=1e-14)


def test_apic_smooths_by_the_fourth_power_of_the_wave_number():
    """0.0237 (kh)⁴ with quadratic B-splines, nothing with linear functions."""
    rates = [rate("apic", "quadratic-bspline", cells) for cells in (32, 64)]
    assert rates[0] / rates[1] == pytest.approx(16.0, rel=0.02)
    assert rates[1] == pytest.approx(0.0237 * (2.0 * np.pi / 64) ** 4, rel=0.01)
    assert rate("apic", "trilinear", 8) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("transfer", ["pic", "apic"])
@pytest.mark.parametrize("cells", [4, 8])
@pytest.mark.parametrize("step", [1e-3, 2e-3])
def test_a_shear_wave_decays_at_this_rate(transfer, cells, step):
    """The same in each step, however long it is; quadratic B-splines, no viscosity."""
    fluid = box((0, 0, 0), (8, 4, 1), WATER | {"viscosity": 0.0}, (3, 3, 1), name="water")
    more = {"transfer": transfer, "functions": "quadratic-bspline", "step": step, "end": 1.0}
    tables = case(fluid, counts=(8, 4, 1), **more).to_data()
    tables["grid"]["periodic"] = ["x", "y"]
    sim = Simulation(Case.model_validate(tables), threads=1)
    body, amplitudes = sim.bodies[0], []
    wave = np.exp(2j * np.pi * body.arrays["position"][:, 0] / cells)
    body.arrays["velocity"][:, 1] = 1e-3 * wave.imag
    for _ in range(12):
        sim.step()
        position, velocity = body.arrays["position"], body.arrays["velocity"]
        wave = np.exp(2j * np.pi * position[:, 0] / cells)
        amplitudes.append(abs(np.mean(velocity[:, 1] * wave)))
    measured = -np.polyfit(np.arange(10), np.log(amplitudes[2:]), 1)[0]
    assert measured == pytest.approx(rate(transfer, "quadratic-bspline", cells), rel=0.03)


def tank(cell=0.025, **time):
    """A tank with a slot of 0.1 m in its floor."""
    water = box((0, 0, 0), (1, 0.5, cell), WATER, (2, 2, 1), name="water")
    floors = [
        {"where": {"box": {"lower": (low, -0.05, 0), "upper": (high, 0, cell)}}, "fix": ["y"]}
        for low, high in ((0, 0.45), (0.55, 1))
    ]
    sides = [{"where": side, "fix": "normal"} for side in ("x-lower", "x-upper")]
    counts = (round(1.0 / cell), round(0.7 / cell), 1)
    more = {"functions": "quadratic-bspline", "end": 1.0} | time
    tables = case(
        water, counts=counts, cell=cell, lower=(0, -0.1, 0), support=[*floors, *sides], gravity=(0, -9.81, 0), **more
    ).to_data()
    return Case.model_validate(tables | {"outflow": [{"where": ["y-lower"]}]})


def test_the_narrowest_passage_is_that_to_the_open_face():
    tables = tank()
    sim = Simulation(tables, threads=1)
    position = sim.bodies[0].stored_array("position")
    assert narrowest_passage(tables, sim.velocity_fields[0].grid, position) == pytest.approx(4.0)
    closed = Case.model_validate(tables.to_data() | {"outflow": []})
    assert narrowest_passage(closed, sim.velocity_fields[0].grid, position) == np.inf


def test_a_slot_that_the_transfer_smooths_is_reported(recwarn):
    Simulation(tank(transfer="apic"), threads=1)
    (text,) = [str(warning.message) for warning in recwarn]
    assert text.startswith("the transfer `apic` smooths the flow of body water like an additional viscosity of ")
    assert "(viscosity of the fluid: 0.001 Pa s)" in text
    assert "across the narrowest passage to an open face, 4 cells wide, the Reynolds number is at most 1" in text
    assert '`time.transfer = "flip"` or "blend"' in text


@pytest.mark.parametrize("time", [{"transfer": "flip"}, {"transfer": "blend"}, {"transfer": "apic", "cell": 0.0125}])
def test_others_are_not(time, recwarn):
    Simulation(tank(**time), threads=1)
    assert not recwarn


def test_apic_with_b_splines_takes_momentum_at_walls():
    """β = 1/42 with evenly spread points; nothing with linear functions and other transfers, and little with AFLIP."""
    drag = {
        (transfer, name): drag_at_walls(TRANSFERS[transfer](0.99), grid_functions(name, (2, 2, 1), THIN)[1])
        for transfer in ("apic", "aflip", "flip")
        for name in ("trilinear", "quadratic-bspline")
    }
    assert drag["apic", "quadratic-bspline"] == pytest.approx(0.0238, rel=0.01)
    assert drag["aflip", "quadratic-bspline"] == pytest.approx(0.01 * drag["apic", "quadratic-bspline"])
    assert drag["apic", "trilinear"] == pytest.approx(0.0, abs=1e-12)
    assert drag["flip", "quadratic-bspline"] == 0.0


@pytest.mark.parametrize(("transfer", "cells", "warns"), [("apic", 8, True), ("apic", 24, False), ("aflip", 8, False)])
def test_a_channel_that_the_transfer_slows_is_warned_of(transfer, cells, warns, recwarn):
    oil = {"kind": "fluid", "density": 1.0, "viscosity": 1.0}
    oil |= {"eos": {"kind": "tait", "sound_speed": 40.0, "carries_tension": True}}
    body = box((0, 0, 0), (8 / cells, 2, 0), oil, (2, 2, 1), name="oil")
    more = {"periodic": ["x"], "functions": "quadratic-bspline", "support": [{"where": ["y-lower", "y-upper"]}]}
    Simulation(case(body, counts=(4, cells, 1), cell=2 / cells, transfer=transfer, gravity=(3, 0, 0), **more), threads=1)
    found = [str(one.message) for one in recwarn if "at walls on faces of the grid" in str(one.message)]
    assert len(found) == warns
    if warns:
        assert "in a channel, 7.5 cells wide, by about 13 % of the mean velocity. Set `time.transfer" in found[0]
