"""Walls that supports define by a shape: where the fluid meets them."""

import numpy as np
import pytest
from small_cases import SOLID, advance, box, case

from pellucid.simulation.simulation import Simulation

OIL = {"kind": "fluid", "density": 1.0, "viscosity": 1.0}
OIL |= {"eos": {"kind": "tait", "sound_speed": 10.0, "carries_tension": True}}
FEW = {"warn": 0.5, "stop": 10.0}
HOW = {"functions": "quadratic-bspline", "transfer": "apic", "energy": FEW, "end": 100.0}


def between_plates(low, high, top, **more):
    """Oil between two clamped boxes, of which the upper one moves along x, on a grid that is periodic along x."""
    oil = box((0, low, 0), (4, high, 0), OIL, (3, 3, 1), name="oil")
    plates = [
        {"name": "bottom", "where": {"box": {"lower": [-1, -1, 0], "upper": [5, low, 0]}}},
        {"name": "top", "where": {"box": {"lower": [-1, high, 0], "upper": [5, 20, 0]}}, "velocity": [top, 0, 0]},
    ]
    return Simulation(case(oil, counts=(4, 12, 1), periodic=["x"], support=plates, **(HOW | more)), threads=1)


@pytest.mark.parametrize(
    ("functions", "scheme"), [("quadratic-bspline", "musl"), ("quadratic-bspline", "usl"), ("cubic-bspline", "usf")]
)
def test_momentum_and_energy_are_kept(functions, scheme):
    sim = between_plates(2.3, 8.6, 0.5, functions=functions, scheme=scheme)
    advance(sim, 60)
    assert sim.conservation()["momentum"] < 1e-12
    assert abs(sim.conservation()["energy"]) < 1e-10
    assert sim.reactions()["top"][0] > 0.0


def test_a_rigid_body_does_not_sink_into_the_region():
    """It stays on the nodes of the floor, which are held near it: without them it would fall through."""
    oil = box((0, 2.5, 0), (6, 8, 0), OIL | {"viscosity": 0.1}, (2, 2, 1), name="oil", outside=["block"])
    block = box((2, 2.8, 0), (4, 4.3, 0), SOLID | {"density": 20.0}, (2, 2, 1), rigid=True)
    floor = [
        {"where": {"box": {"lower": [-1, -1, 0], "upper": [7, 2.5, 0]}}},
        *({"where": face, "fix": "normal"} for face in ("x-lower", "x-upper")),
    ]
    sim = Simulation(case(block, oil, counts=(6, 12, 1), support=floor, gravity=(0, -1.0, 0), **HOW), threads=1)
    while sim.time < 2.0:
        sim.step()
    assert sim.bodies[0].frame()["position"][:, 1].min() - 0.25 == pytest.approx(2.8, abs=1e-3)


def test_the_same_bits_after_a_checkpoint():
    one = between_plates(2.3, 8.6, 0.5)
    again = between_plates(2.3, 8.6, 0.5)
    advance(one, 20)
    again.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())
    advance(one, 20)
    advance(again, 20)
    for name, array in one.bodies[0].arrays.items():
        assert np.array_equal(array, again.bodies[0].arrays[name])
    assert np.array_equal(one.reactions()["top"], again.reactions()["top"])
