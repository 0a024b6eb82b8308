"""The largest frequency of meshless solids: power iteration that goes on during a run, and what ends runs that crush."""

import re

import numpy as np
import pytest

from pellucid.bodies.meshless_solid.stable_step import GROWING, INTERVAL, PowerIteration, converge
from pellucid.case import Case
from pellucid.errors import RunStopped
from pellucid.simulation.simulation import Simulation

EDGE = 0.1


def pressed(shares, steady, cells=(4, 4, 4)):
    """A cube between a clamp and one that comes nearer by a share of its edge."""
    box = {"box": {"lower": (0.0, 0.0, 0.0), "upper": (EDGE, EDGE, EDGE), "cells": cells}}
    tissue = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.49}
    low, high = ({"lower": (-1.0, -1.0, z - 1e-4), "upper": (1.0, 1.0, z + 1e-4)} for z in (0.0, EDGE))
    down = {"z": {"kind": "steady", "velocity": -shares * EDGE}}
    table = {
        "schema": 1,
        "title": "a test",
        "time": {"end": 1.0},
        "steady": {"method": "relaxation"} | steady,
        "body": [{"name": "cube", "kind": "meshless-solid", "mesh": box, "material": tissue}],
        "support": [{"name": "bottom", "where": {"box": low}}],
        "motion": [{"name": "top", "body": "cube", "part": {"box": high}, "hold": ["x", "y"], "displacement": down}],
    }
    return Simulation(Case.model_validate(table), threads=1)


def step_on(simulation, steps=10**6):
    for _ in range(steps):
        simulation.step()


def test_the_frequency_is_followed_while_a_cube_is_crushed():
    """Against an iteration that has long converged; the step is 0.8/1.05 of what is found, so above 0.8 it stays stable."""
    simulation = pressed(0.85, {"loading": 400})
    body = simulation.bodies[0]
    found, frequencies = [], []
    while simulation.n_steps < 280:
        simulation.step()
        if simulation.n_steps % 20 == 0:
            exact = PowerIteration(body.motion.inertia, body.motion.free, EDGE)
            for _ in range(6):
                converge(exact, body._forces._try, body.arrays["position"] - body.mesh.nodes)
            body._find_forces()
            frequencies.append(exact.frequency)
            found.append(body._fastest.frequency / exact.frequency)
    assert max(frequencies) > 1.5 * min(frequencies)
    assert min(found) > 0.9
    assert max(found) < 1.02


def test_iterations_are_few_while_nothing_changes():
    simulation = pressed(0.01, {"loading": 2000}, cells=(2, 2, 2))
    iterated, learn = [], PowerIteration.learn
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PowerIteration, "learn", lambda self, resistance: iterated.append(1) or learn(self, resistance))
        step_on(simulation, 10 * INTERVAL)
    assert 10 <= len(iterated) <= 12


@pytest.mark.parametrize(("share", "loading"), [(0.9, 400), (0.95, 800), (0.8, 50)])
def test_a_crushed_cube_ends_by_a_place_that_is_named(share, loading):
    named = r"is inverted between nodes \d+, \d+, \d+, \d+, where \((.*)\) m was at rest: the volume ratio of a point is -"
    simulation = pressed(share, {"loading": loading})
    with pytest.raises(RunStopped, match=named) as stopped:
        step_on(simulation)
    place = np.array(re.search(named, str(stopped.value))[1].split(", "), float)
    assert ((place > 0.0) & (place < EDGE)).all()
    assert "; increase steady.load_steps or steady.loading, or decrease steady.courant" in str(stopped.value)


def test_a_node_that_is_nowhere_is_told_by_its_place_at_rest():
    simulation = pressed(0.1, {"loading": 400}, cells=(2, 2, 2))
    simulation.step()
    node = int(np.flatnonzero((simulation.bodies[0].arrays["prescribed"] == 0).all(axis=1))[0])
    simulation.bodies[0].arrays["velocity"][node] = np.inf
    place = ", ".join(f"{x:.6g}" for x in simulation.bodies[0].mesh.nodes[node])
    with pytest.raises(RunStopped, match="body `cube`") as stopped, np.errstate(all="ignore"):
        step_on(simulation, 2)
    assert f"from ({place}) m at rest: its state is not a finite number; increase steady.load_steps" in str(stopped.value)


def test_it_finds_the_largest_of_free_frequencies_from_below():
    rng = np.random.default_rng(3)
    inertia, stiffness = rng.uniform(1.0, 2.0, 50), rng.uniform(1.0, 9.0, (50, 3))
    free = np.ones((50, 3), bool)
    free[np.unravel_index(np.argmax(stiffness / inertia[:, None]), stiffness.shape)] = False
    exact = float(np.sqrt((stiffness / inertia[:, None])[free].max()))
    iteration, found = PowerIteration(inertia, free, 1.0), []
    for _ in range(300):
        iteration.learn(stiffness * iteration.trial())
        found.append(iteration.frequency)
    assert np.all(np.diff(found) > -1e-12 * exact)
    assert found[-1] == pytest.approx(exact, rel=1e-3)
    assert found[-1] <= exact * (1.0 + 1e-12)


def test_what_is_beyond_all_bounds_teaches_nothing():
    iteration = PowerIteration(np.ones(4), np.ones((4, 3), bool), 1.0)
    iteration.learn(2.0 * iteration.trial())
    kept = {name: array.copy() for name, array in iteration.state_arrays().items()}
    iteration.trial()
    iteration.learn(np.full((4, 3), np.nan))
    again = iteration.state_arrays()
    assert iteration.frequency == pytest.approx(np.sqrt(2.0))
    assert np.isfinite(again["fastest_mode"]).all()
    assert again["frequency"][0] == kept["frequency"][0]


def test_it_goes_on_in_the_next_step_while_the_frequency_grows():
    iteration = PowerIteration(np.ones(4), np.ones((4, 3), bool), 1.0)
    stiffness = 1.0
    iteration.learn(stiffness * iteration.trial())
    assert iteration.is_due(), "it grew from nothing"
    iteration.learn(stiffness * iteration.trial())
    assert [iteration.is_due() for _ in range(INTERVAL)] == [False] * (INTERVAL - 1) + [True]
    iteration.learn((1.0 + 3.0 * GROWING) * stiffness * iteration.trial())  # of the frequency half of this
    assert iteration.is_due()


def test_nothing_that_is_free_has_no_frequency():
    iteration = PowerIteration(np.ones(4), np.zeros((4, 3), bool), 1.0)
    iteration.learn(iteration.trial())
    assert iteration.frequency == 0.0
