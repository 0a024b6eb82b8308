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


@pytest.mark.parametrize("low", [2.0, 2.3, 2.5, 2.9])
def test_the_traction_between_plates_does_not_depend_on_where_they_lie_in_a_cell(low):
    """Couette's flow between planes: μ U / H within .3 %. Held nodes alone make the gap wider by up to a fifth."""
    sim = between_plates(low, low + 6.0, 0.1)
    points = sim.bodies[0].arrays
    points["velocity"][:, 0] = 0.1 * (points["position"][:, 1] - low) / 6.0
    points["affine"][:, 1] = 0.1 / 6.0
    advance(sim, 300)
    before, since = {name: push.copy() for name, push in sim.reactions().items()}, sim.time
    advance(sim, 200)
    force = {name: (push - before[name])[0] / (sim.time - since) for name, push in sim.reactions().items()}
    assert force["top"] == pytest.approx(4.0 * 0.1 / 6.0, rel=0.003)
    assert force["bottom"] == pytest.approx(-force["top"], rel=0.002)


@pytest.mark.parametrize(
    ("functions", "scheme"), [("quadratic-bspline", "musl"), ("quadratic-bspline", "usl"), ("cubic-bspline", "usf")]
)
def test_momentum_and_energy_are_kept(functions, scheme):
    sim = between_plates(2.3, 8.6, 0.5, functions=functions, scheme=scheme)
    advance(sim, 60)
    assert sim.conservation()["momentum"] < 1e-12
    assert abs(sim.conservation()["energy"]) < 1e-10
    assert sim.reactions()["top"][0] > 0.0


def test_a_turned_shape_is_a_wall_where_it_is():
    """A slope of 30°: distances and normals are those of its plane, as far as samples a quarter of a cell apart show."""
    slope = {"box": {"lower": [-20, -10, 0], "upper": [30, 0, 0]}, "rotate": {"axis": [0, 0, 1], "angle": 30.0}}
    sim = Simulation(
        case(box((1, 1, 0), (9, 9, 0), OIL, (2, 2, 1), name="oil"), counts=(10, 10, 1), support=[{"where": slope}], **HOW)
    )
    wall = next(condition for condition in sim.conditions._active if type(condition).__name__ == "NoSlipWall")._wall
    middle, turned = np.array([5.0, -5.0, 0.0]), np.deg2rad(30.0)
    place = sim.grid.find_positions(wall.node) - middle
    height = place[:, 1] * np.cos(turned) - place[:, 0] * np.sin(turned) - 5.0
    assert wall.surface.distance == pytest.approx(height, abs=2e-3)
    assert wall.surface.normal == pytest.approx(np.tile([-0.5, np.cos(turned), 0], (len(height), 1)), abs=0.03)
    assert abs(wall.surface.curvature) < 0.01


def test_a_solid_in_the_field_keeps_the_nodes_of_the_region_held():
    """Only fluids, and rigid bodies beside them, have walls of this kind."""
    oil, block = box((0, 2, 0), (4, 8, 0), OIL, (2, 2, 1), name="oil"), box((1, 9, 0), (2, 10, 0), SOLID, (2, 2, 1))
    floor = [{"where": {"box": {"lower": [-1, -1, 0], "upper": [5, 2.2, 0]}}}]
    for bodies, walls in (((oil,), 1), ((oil, block), 0), ((oil, block | {"rigid": True}), 1)):
        sim = Simulation(case(*bodies, counts=(4, 12, 1), support=floor, **HOW), threads=1)
        assert sum(type(condition).__name__ == "NoSlipWall" for condition in sim.conditions._active) == walls
    inviscid = oil | {"material": OIL | {"viscosity": 0.0}}
    for body, more in ((inviscid, {}), (oil, {"transfer": "flip"})):
        sim = Simulation(case(body, counts=(4, 12, 1), support=floor, **(HOW | more)), threads=1)
        assert not any(type(condition).__name__ == "NoSlipWall" for condition in sim.conditions._active)


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
