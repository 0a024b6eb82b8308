"""How far bodies are from walls that open."""

import numpy as np
import pytest
from small_cases import RATE_SOLID, SLIP, advance, box, simulation


def gaps(sim, axis, side):
    """Of the nodes on a face that a body reaches, less what counts as none [m]."""
    index, position = sim.grid.where()
    on_face = position[:, axis] == (position[:, axis].min() if side == "lower" else position[:, axis].max())
    nodes = index[on_face]
    return sim.actions[0].supports.walls.gap[nodes[sim.grid.nodes.mass[nodes] > 0.0], axis]


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline", "gimp"])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", ["lower", "upper"])
def test_the_gap_is_that_of_the_foremost_points(functions, axis, side):
    """A block a fifth of a cell off the wall; the nodes of other faces, which hold, have none."""
    lower, upper = np.full(3, 1.0), np.full(3, 3.0)
    shift = 0.2 - lower[axis] if side == "lower" else 4.8 - upper[axis]
    lower[axis], upper[axis] = lower[axis] + shift, upper[axis] + shift
    support = [wall | {"opens": wall["where"] == f"{'xyz'[axis]}-{side}"} for wall in SLIP]
    block = box(lower.tolist(), upper.tolist(), RATE_SOLID)
    sim = advance(simulation(block, counts=(5, 5, 5), support=support, functions=functions, step=1e-3), 1)
    found = gaps(sim, axis, side)
    assert len(found) >= 9
    assert found == pytest.approx(0.2 - 1e-4, abs=1e-9)


def test_the_nearest_of_all_bodies_counts():
    """One stands on the wall, one flies above it in the same velocity field."""
    low = box((0, 0, 0), (2, 2, 1), RATE_SOLID, name="low")
    high = box((2, 0, 0.5), (4, 2, 1.5), RATE_SOLID, name="high")
    floor = {"where": "z-lower", "fix": "normal", "opens": True}
    sim = advance(simulation(low, high, counts=(4, 2, 4), support=[floor], step=1e-3), 1)
    index, position = sim.grid.where()
    on_floor = position[:, 2] == 0.0
    gap = sim.actions[0].supports.walls.gap[index[on_floor], 2] + 1e-4
    assert gap[position[on_floor, 0] < 2.5] == pytest.approx(0.0, abs=1e-9)
    assert gap[position[on_floor, 0] > 2.5] == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize("opens", [False, True])
def test_a_body_lands_where_it_touches_the_wall_that_opens(opens):
    """It falls half a cell in force-free flight; a smooth wall that holds feels it from the cell above."""
    floor = {"name": "floor", "where": "z-lower", "fix": "normal", "opens": opens}
    block = box((1, 1, 0.5), (3, 3, 2.5), RATE_SOLID, velocity=(0.0, 0.0, -0.1))
    sim = simulation(block, support=[floor], counts=(4, 4, 4), step=0.01, end=10.0)
    while sim.time < 4.9:
        sim.step()
    assert sim.budget.reactions()["floor"].any() != opens
    while sim.time < 5.2:
        sim.step()
    assert sim.budget.reactions()["floor"][2] > 0.0


def test_a_floor_below_what_is_held_at_first_is_found():
    """A support of all nodes hides it until this lets go."""
    floor = {"name": "floor", "where": "z-lower", "fix": "normal", "friction": 0.5}
    hold = {"where": "all-nodes", "until": 0.1}
    sim = simulation(box((1, 1, 0), (3, 3, 2), RATE_SOLID), support=[floor, hold], gravity=(0, 0, -0.1), step=0.01, end=10.0)
    advance(sim, 60)
    assert sim.budget.reactions()["floor"][2] > 0.0
    assert sim.bodies[0].frame()["position"][:, 2].min() > 0.2
