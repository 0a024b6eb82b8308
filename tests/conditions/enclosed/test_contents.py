"""Gas and liquid by mass: their laws, and that what comes and goes balances."""

from copy import copy
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from pellucid.conditions.enclosed.contents import Gas, Liquid, flow_function
from pellucid.conditions.enclosed.foretold import Inflator

R, GAMMA, T = 287.05, 1.4, 300.0


def gas(isothermal=False, mass=0.5):
    return Gas(mass, T, GAMMA, R, isothermal)


def test_a_gas_has_the_pressure_of_its_mass_and_temperature():
    assert gas().pressure(2.0) == pytest.approx(0.5 * R * T / 2.0)
    assert gas().temperature == pytest.approx(T)


@pytest.mark.parametrize(("isothermal", "exponent"), [(False, GAMMA), (True, 1.0)])
def test_a_gas_expands_along_its_curve(isothermal, exponent):
    air, volume, work = gas(isothermal), 1.0, 0.0
    start, energy = air.pressure(1.0), air.energy
    for _ in range(100):
        work += air.pressure(volume + 0.005) * 0.01
        heat = air.expand(volume, volume + 0.01)
        volume += 0.01
        assert isothermal or heat == 0.0
    assert air.pressure(volume) * volume**exponent == pytest.approx(start, rel=1e-12)
    exact = quad(lambda v: start * v**-exponent, 1.0, 2.0)[0]
    released = start * np.log(2.0) if isothermal else energy - air.energy
    assert released == pytest.approx(exact, rel=1e-9)


def test_heat_keeps_an_isothermal_gas_at_its_temperature():
    air = gas(isothermal=True)
    before = air.energy
    brought, heat = air.take_in(0.1, 0.1 * 400.0, 1.0)
    assert air.temperature == pytest.approx(T)
    assert air.energy - before == pytest.approx(brought + heat)
    before = air.energy
    taken, heat = air.let_out(0.2, 1.0)
    assert taken == pytest.approx(0.2 * R * GAMMA / (GAMMA - 1.0) * T)
    assert air.energy - before == pytest.approx(heat - taken)


def test_a_nozzle_is_choked_below_the_critical_ratio():
    assert flow_function(0.0, GAMMA) == flow_function(0.5282, GAMMA) == pytest.approx(0.6847, abs=5e-5)
    assert flow_function(0.53, GAMMA) < flow_function(0.5, GAMMA)
    # close to equal pressures as a liquid of its density: ψ = sqrt(2 (1 - r))
    assert flow_function(0.999, GAMMA) == pytest.approx(np.sqrt(2.0 * 0.001), rel=1e-3)
    assert flow_function(1.0, GAMMA) == 0.0


def test_a_liquid_stores_the_work_of_its_compression():
    water = Liquid(1010.0, 2e9, 1000.0, 1.0)
    assert water.pressure(1.0) == pytest.approx(2e7)
    start, after = water.energy, copy(water)
    after.expand(1.0, 1.02)
    work = quad(lambda v: 2e9 * (1.01 / v - 1.0), 1.0, 1.02)[0]
    assert after.energy - start == pytest.approx(-work, rel=1e-6)
    assert water.stiffness(1.0) == pytest.approx((water.pressure(0.9999) - water.pressure(1.0001)) / 2e-4, rel=1e-6)


def test_what_leaves_a_liquid_takes_its_energy_along():
    water = Liquid(1010.0, 2e9, 1000.0, 1.0)
    before = water.energy
    taken, heat = water.let_out(water.excess(1.0, 1e6), 1.0)
    assert (water.energy, heat) == (pytest.approx(before - taken), 0.0)
    assert water.pressure(1.0) == pytest.approx(1e6)
    assert taken > 0.0
    assert water.efflux(1.0, 0.0) == pytest.approx(np.sqrt(2.0 * water.mass * 1e6))


@pytest.mark.parametrize("isothermal", [False, True])
def test_the_excess_of_a_gas_lets_its_pressure_fall_to_that_outside(isothermal):
    air = gas(isothermal)
    air.let_out(air.excess(1.0, 1e4), 1.0)
    assert air.pressure(1.0) == pytest.approx(1e4)


def test_an_inflator_gives_what_its_table_holds_whatever_the_steps():
    table = Inflator(times=(0.1, 0.3, 0.4), mass_flows=(0.0, 2.0, 1.0), temperatures=(300.0, 500.0, 400.0))
    steps = np.linspace(0.0, 0.5, 38)
    mass, warmth = np.sum([table.given(a, b) for a, b in pairwise(steps)], axis=0)
    assert mass == pytest.approx(0.5 * 0.2 * 2.0 + 0.1 * 1.5, rel=1e-12)

    def flow(t):
        return np.interp(t, table.times, table.mass_flows) * np.interp(t, table.times, table.temperatures)

    assert warmth == pytest.approx(quad(flow, 0.1, 0.3)[0] + quad(flow, 0.3, 0.4)[0], rel=1e-12)


def test_an_inflator_in_a_file_is_the_same(tmp_path):
    file = tmp_path / "inflator.csv"
    file.write_text("time,flow,temperature\n0.1,0,300\n0.3,2,500\n0.4,1,400\n")
    table = Inflator(times=(0.1, 0.3, 0.4), mass_flows=(0.0, 2.0, 1.0), temperatures=(300.0, 500.0, 400.0))
    assert Inflator(path=str(file)).given(0.0, 0.35) == table.given(0.0, 0.35)
    file.write_text("0.1,0,300\n0.3,2\n")
    with pytest.raises(ValueError, match=r"line 2 of .*does not have three numbers like the first row"):
        Inflator(path=str(file))
