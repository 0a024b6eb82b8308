"""Soft bodies of material points that lie on others by their surfaces."""

from itertools import product

import numpy as np
import pytest
from small_cases import advance, box, simulation

from pellucid.contact.surface_pairs import SurfacePairs

SOIL = {"kind": "linear-elastic", "density": 2000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
HELD = {"name": "held", "body": "plate", "hold": ["x", "y", "z"]}


@pytest.mark.parametrize(
    ("functions", "on", "scheme"),
    [
        *product(["trilinear", "gimp", "quadratic-bspline"], ["plate", "wall"], ["musl"]),
        *[("quadratic-bspline", "plate", "usf"), ("quadratic-bspline", "plate", "usl")],
    ],
)
def test_a_block_that_is_let_go_on_a_plate_gains_no_energy(functions, on, scheme):
    """Gravity comes at once and the block swings. Its rim moves over the points of the plate. When these points measured depths
    too, their areas in contact changed without work, and contact gave the block up to 2.8 J. Surfaces that moved with the
    material points, and not along the velocities that strain these, gave it more at each step. With USF, surfaces that moved
    after the forces made it swing ten times as fast."""
    plate = box((0, 0, 0), (1.0, 0.2, 0), SOIL, (2, 2, 1), name="plate", field="plate")
    block = box((0.25, 0.2, 0), (0.75, 0.45, 0), SOIL, (2, 2, 1), field="block")
    touch = {"name": "touch", "kind": "coulomb", "friction": 0.7}
    if on == "plate":
        how = {"motion": [HELD], "contact": [touch | {"between": ["block", "plate"]}]}
    else:
        how = {"wall": [touch | {"point": (0, 0.2, 0), "normal": (0, 1, 0)}]}
    how |= {"counts": (20, 12, 0), "cell": 0.05, "functions": functions, "courant": 0.4, "gravity": (0.0, -9.81, 0.0)}
    how["scheme"] = scheme
    sim = simulation(*([plate] if on == "plate" else []), block, end=100.0, energy={"warn": 1.0, "stop": 10.0}, **how)
    swings, moved = [], 0.0
    for _ in range(4):
        seen = []
        for _ in range(60):
            advance(sim, 10)
            seen.append(sim.kinetic_energy())
            moved = max(moved, sim.budget.energies()["gravity_work"])
        swings.append(max(seen))
    assert swings[3] < swings[0]
    assert sim.budget.energies()["contact_work"] < 0.0
    assert -0.01 * moved < sim.budget.energies()["transfer_heat"] < (1.0 if scheme == "usl" else 0.01) * moved  # USL smooths
    assert abs(sim.parts.only(SurfacePairs).energy.unexplained) < 0.01 * moved
    weight = sim.bodies[-1].mass * 9.81
    assert sim.budget.reactions()["touch"][1] == pytest.approx(weight * sim.time, rel=0.01)


def test_soft_blocks_that_lie_on_each_other_win_no_energy():
    """Two let go under gravity: impulses on nodes gave them 1 % of what is at stake in this time, and 5 % in four times it."""
    tissue = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e5, "poisson_ratio": 0.3}
    low = box((0, 0, 0), (0.4, 0.3, 0), tissue, (2, 2, 1), name="low", field="low")
    top = box((0, 0.3, 0), (0.4, 0.7, 0), tissue, (2, 2, 1), name="top", field="top")
    held = [{"where": where, "fix": "normal"} for where in ("y-lower", "x-lower", "x-upper")]
    how = {"counts": (8, 20, 0), "cell": 0.05, "functions": "quadratic-bspline", "courant": 0.4, "gravity": (0.0, -9.81, 0.0)}
    sim = advance(simulation(low, top, support=held, end=100.0, **how), 1000)
    assert sim.budget.energies()["contact_work"] < 0.0
    assert abs(sim.budget.energy_error()) < 0.005
    assert np.all(np.isfinite(sim.bodies[1].arrays["position"]))
