"""Pressure of walls that cut cells on liquids: liquids at rest, and flow between open faces under pressure."""

import numpy as np
import pytest
from small_cases import advance, assert_resumes, box, case

from pellucid.case import Case
from pellucid.simulation.simulation import Simulation

EXPLICIT = {"transfer": "apic"}
SPLINES = EXPLICIT | {"functions": "quadratic-bspline"}
IMPLICIT = SPLINES | {"scheme": "usl", "material": {"implicit_pressure": True}}
SCHEMES = {"trilinear": EXPLICIT, "splines": SPLINES, "implicit": IMPLICIT}
CELL, LENGTH, START = 0.25, 4.0, 12.0


def half_channel(top, pressure=0.0, length=LENGTH, material=None, **more):
    """The lower half of a channel whose wall is a shape at the height `top`, and a plane of symmetry at y = 0."""
    eos = {"kind": "tait", "sound_speed": 40.0, "carries_tension": True}
    liquid = {"kind": "fluid", "density": 1.0, "pressure": pressure, "viscosity": 1.0, "eos": eos} | (material or {})
    fluid = box((0, 0, 0), (length, top, CELL), liquid, (2, 2, 1), name="fluid")
    wall = {"where": {"box": {"lower": [-5, top, -5], "upper": [length + 5, 5, 5]}}}
    supports = [{"where": "y-lower", "fix": "normal"}, wall]
    return case(fluid, counts=(round(length / CELL), 5, 1), cell=CELL, support=supports, thickness=1.0, **more).to_data()


def quarter_tube(pressure=0.0, length=LENGTH, material=None, **more):
    """A quarter of a round tube of radius 1, four cells, between two planes of symmetry."""
    eos = {"kind": "tait", "sound_speed": 40.0, "carries_tension": True}
    liquid = {"kind": "fluid", "density": 1.0, "pressure": pressure, "viscosity": 1.0, "eos": eos} | (material or {})
    centre = [0.5 * length, 0.0, 0.0]
    shape = {"cylinder": {"centre": centre, "radius": 1, "axis": "x", "height": length}}
    fluid = {
        "name": "fluid",
        "shape": shape,
        "cut_at": ["y-lower", "z-lower"],
        "points_per_cell": [2, 2, 2],
        "material": liquid,
    }
    pipe = {"pipe": {"centre": centre, "inner_radius": 1, "outer_radius": 3, "axis": "x", "height": 3 * length}}
    supports = [{"where": ["y-lower", "z-lower"], "fix": "normal"}, {"where": pipe}]
    return case(fluid, counts=(round(length / CELL), 5, 5), cell=CELL, support=supports, **more).to_data()


def between_pressures(tables):
    """The same, between an inlet of the pressure START, which rises in 0.2 s, and an outlet of no pressure."""
    inlet = {"where": "x-lower", "body": "fluid", "pressure": START, "rise": 0.2}
    return Case.model_validate(tables | {"inflow": [inlet], "outflow": [{"where": ["x-upper"], "pressure": 0.0}]})


@pytest.mark.parametrize("top", [1.0, 0.95, 0.9, 0.8])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_liquid_under_pressure_stays_at_rest(scheme, top):
    """Wherever the wall cuts the cells. Without its pressure, that of the points at the wall changes by up to 80 %."""
    tables = half_channel(top, 24.0, length=1.0, periodic=["x"], end=1.0, **SCHEMES[scheme])
    sim = advance(Simulation(Case.model_validate(tables), threads=1), 60)
    liquid = sim.bodies[0]
    assert np.abs(liquid.field("pressure") - 24.0).max() < 1e-9
    assert np.abs(liquid.field("velocity")).max() < 1e-12


def test_a_liquid_under_pressure_is_almost_at_rest_in_a_round_tube():
    """At nodes deep in the wall, which points fill by less than three quarters, the wall exerts only the part of the pressure
    along its normal. Without the pressure of the wall the deviation is 25 % (RMS)."""
    tables = quarter_tube(24.0, length=1.0, periodic=["x"], end=1.0, **IMPLICIT)
    sim = advance(Simulation(Case.model_validate(tables), threads=1), 50)
    pressure = sim.bodies[0].field("pressure")
    assert np.sqrt(np.mean((pressure - 24.0) ** 2)) < 0.05 * 24.0


def pressures_and_flow(tables, since):
    """Mean pressure [Pa] in each layer of cells along x after the time `since` [s], the positions of the layers, and the mean
    velocity by mass."""
    sim, sums, n = Simulation(tables, threads=1), 0.0, round(LENGTH / CELL)
    while not sim.clock.finished(None):
        sim.step()
        if sim.time > since and sim.n_steps % 5 == 0:
            x, p, v, m, density = (sim.bodies[0].field(k) for k in ("position", "pressure", "velocity", "mass", "density"))
            volume, layer = m / density, (x[:, 0] / CELL).astype(int)
            sums += np.array([np.bincount(layer, w, n) for w in (volume, volume * p, m, m * v[:, 0])])
    return (np.arange(n) + 0.5) * CELL, sums[1] / sums[0], sums[3].sum() / sums[2].sum()


@pytest.mark.parametrize(("scheme", "top"), [("splines", 0.9), ("implicit", 0.9), ("implicit", 0.95), ("trilinear", 0.95)])
def test_the_pressure_falls_evenly_between_open_faces(scheme, top):
    """From the inlet on, by START/LENGTH, with the mean velocity of Poiseuille; the wall cuts cells. The pressure of points
    that are no mean over cells oscillates. Compression adds START²/8ρc² = 0.1 % to the pressure in the middle."""
    tables = between_pressures(half_channel(top, end=3.0, **SCHEMES[scheme]))
    x, pressure, mean = pressures_and_flow(tables, 1.5)
    slope, at_inlet = np.polyfit(x[4:12], pressure[4:12], 1)
    assert slope == pytest.approx(-START / LENGTH, rel=0.01)
    assert at_inlet == pytest.approx(START, rel=0.01)
    assert np.abs(pressure - START * (1.0 - x / LENGTH)).max() < 0.01 * START
    assert mean == pytest.approx(START / LENGTH * top**2 / 3.0, rel=0.03)


def test_the_pressure_falls_evenly_in_a_round_tube():
    """From the inlet on, with the mean velocity of Poiseuille, START R²/(8 μ LENGTH)."""
    tables = between_pressures(quarter_tube(end=2.0, **IMPLICIT))
    x, pressure, mean = pressures_and_flow(tables, 1.0)
    slope, _ = np.polyfit(x[4:12], pressure[4:12], 1)
    assert slope == pytest.approx(-START / LENGTH, rel=0.01)
    assert np.abs(pressure - START * (1.0 - x / LENGTH)).max() < 0.01 * START
    assert mean == pytest.approx(START / LENGTH / 8.0, rel=0.03)


@pytest.mark.parametrize("scheme", ["trilinear", "implicit"])
def test_the_same_bits_after_a_checkpoint(scheme):
    """The wall keeps the sums over the points of the first step."""
    tables = between_pressures(half_channel(0.9, end=1.0, **SCHEMES[scheme]))
    one, again = (Simulation(tables, threads=1) for _ in range(2))
    assert_resumes(one, again, 10, 10)
