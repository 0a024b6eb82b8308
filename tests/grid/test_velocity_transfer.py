"""Transfers of velocity in a slow flow between walls: error of the flow and of the energy."""

import numpy as np
import pytest
from small_cases import advance, box, simulation

OIL = {"kind": "fluid", "density": 1.0, "viscosity": 1.0, "eos": {"kind": "tait", "sound_speed": 40.0, "carries_tension": True}}
WALLS = [{"where": ["y-lower", "y-upper"]}]


def error_of_a_channel(transfer: str, n: int, functions: str = "quadratic-bspline") -> tuple[float, float]:
    """Relative error of the mean velocity of a channel with n cells across, 0.3 after a constant force begins to act, from the
    exact series; and the error of the energy."""
    cell = 2.0 / n
    oil = box((0, 0, 0), (4 * cell, 2, 0), OIL, (2, 2, 1))
    grid = {"counts": (4, n, 1), "cell": cell, "periodic": ["x"], "functions": functions, "thickness": 1.0}
    sim = simulation(oil, support=WALLS, gravity=(3, 0, 0), transfer=transfer, end=0.3, **grid)
    while not sim.clock.finished(None):
        advance(sim, 1)
    odd = np.arange(1, 20, 2)
    exact = 1.0 - float(np.sum(96.0 / (np.pi * odd) ** 4 * np.exp(-((odd * np.pi) ** 2) * 0.3 / 4.0)))
    return float(sim.momentum()[0] / sim.bodies[0].arrays["mass"].sum()) / exact - 1.0, sim.budget.energy_error()


def test_aflip_keeps_the_profile_beside_walls():
    """An error of second order: a quarter with cells of half the size. APIC takes momentum beside walls in each step."""
    coarse, energy = error_of_a_channel("aflip", 8)
    fine, _ = error_of_a_channel("aflip", 16)
    assert abs(coarse) < 0.02
    assert abs(fine) < 0.4 * abs(coarse)
    assert abs(energy) < 1e-12
    apic, _ = error_of_a_channel("apic", 8)
    assert apic < -0.04
    assert abs(coarse) < 0.5 * abs(apic)


@pytest.mark.parametrize("functions", ["trilinear", "gimp", "cubic-bspline"])
def test_aflip_with_other_functions(functions):
    error, energy = error_of_a_channel("aflip", 8, functions)
    assert abs(error) < 0.04  # as large as that of second-order differences with 8 cells, 1/8² times 2
    assert abs(energy) < 1e-12
