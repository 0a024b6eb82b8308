"""Essential conditions by forces, in cases: what they work, their reactions, steady states, restarts, results and refusals."""

import json
import re

import numpy as np
import pytest
from meshes import irregular
from solids import PULL, held, pulled_block, solid

import pellucid
from pellucid.case import Case
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

FORCES = [(kind, how) for kind in ("moving-least-squares", "modified-moving-least-squares") for how in ("sebciem", "ebciem")]
by_forces = pytest.mark.parametrize(("kind", "how"), FORCES)


def simulation(kind, how, case=pulled_block, **body):
    return Simulation(Case.model_validate(case(approximant={"kind": kind}, essential=how, **body)), threads=1)


def finished(sim):
    while not sim.clock.finished(None):
        sim.step()
    return sim


@pytest.fixture(scope="module")
def direct():
    """The energy and the reaction with maximum entropy, to compare with."""
    sim = finished(simulation("cell-based-maximum-entropy", "direct"))
    return sim.budget.energies()["strain"]


@by_forces
def test_a_pull_keeps_momentum_and_energy_and_the_field_follows(kind, how, direct):
    sim = finished(simulation(kind, how))
    body, energies = sim.bodies[0], sim.budget.energies()
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert abs(sim.budget.energy_error()) < 1e-4
    assert energies["motion_work"] == pytest.approx(energies["strain"] + energies["kinetic"], rel=1e-3)
    assert abs(energies["support_work"]) < 1e-12 * energies["motion_work"], "a support at rest does no work"
    # coarse: the clamps' edges make the difference, 7 % and less of it
    assert energies["strain"] == pytest.approx(direct, rel=0.08)
    found = body.facts()
    assert found["ebc_residual_nodes"] < (1e-15 if how == "sebciem" else 0.05 * PULL)
    assert 1e-5 * PULL < found["ebc_residual_between"] < 0.05 * PULL


@by_forces
def test_damping_is_counted_beside_them(kind, how):
    sim = finished(simulation(kind, how, damping=20.0))
    assert sim.budget.energies()["damping_heat"] > 0.01 * sim.budget.energies()["strain"]
    assert abs(sim.budget.energy_error()) < 1e-4
    assert sim.budget.conservation()["momentum"] < 1e-12


@by_forces
def test_a_steady_state_balances_its_reactions(kind, how):
    table = pulled_block(approximant={"kind": kind}, essential=how) | {"steady": {"tolerance": 1e-6}}
    sim = finished(Simulation(Case.model_validate(table), threads=1))
    assert sim.clock.facts()["steady"]["unbalanced_force"] < 1e-5
    reactions = sim.budget.reactions()
    assert reactions["top"][2] > 0.1
    assert reactions["top"] == pytest.approx(-reactions["bottom"], abs=1e-5 * reactions["top"][2])
    assert sim.budget.conservation()["momentum"] < 1e-12


def test_a_restart_goes_on_bit_for_bit():
    whole = simulation("moving-least-squares", "sebciem")
    for _ in range(10):
        whole.step()
    kept = {name: np.copy(array) for name, array in whole.state_arrays().items()}, whole.state_numbers()
    for _ in range(5):
        whole.step()
    again = simulation("moving-least-squares", "sebciem")
    again.restore(*kept)
    for _ in range(5):
        again.step()
    assert again.bodies[0].arrays["position"].tobytes() == whole.bodies[0].arrays["position"].tobytes()
    assert again.budget.energies() == whole.budget.energies()
    assert again.bodies[0].facts() == whole.bodies[0].facts()


def test_results_show_the_field_and_the_summary_how_far_it_is_from_what_is_prescribed(tmp_path):
    table = pulled_block(duration=0.05, approximant={"kind": "moving-least-squares"})
    run = pellucid.run(Case.model_validate(table), out=tmp_path / "run", report=False)
    fields = run.fields("block")
    start = Simulation(Case.model_validate(table), threads=1).bodies[0]
    top = start.mesh.nodes[:, 2] > 0.0999
    assert fields["position"][top] == pytest.approx(start.mesh.nodes[top] + (0.0, 0.0, PULL), abs=1e-14)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert 0.0 <= summary["ebc_residual_nodes"] < 1e-15
    assert 0.0 < summary["ebc_residual_between"] < 0.1 * PULL


def test_numbers_of_the_nodes_are_not_the_field():
    body = finished(simulation("moving-least-squares", "sebciem")).bodies[0]
    top = body.mesh.nodes[:, 2] > 0.0999
    rise = (body.arrays["position"] - body.mesh.nodes)[top, 2]
    assert abs(rise - PULL).max() > 0.01 * PULL
    assert body.field("position")[top, 2] - 0.1 == pytest.approx(PULL, abs=1e-15)


def test_what_cannot_be_is_refused():
    with pytest.raises((CaseError, ValueError), match="essential"):
        Case.model_validate(pulled_block(essential="penalty"))


def test_on_a_grid_they_are_refused():
    grid = {"lower": (-1, -1, -1), "upper": (1, 1, 1), "cell": 0.1}
    table = pulled_block(essential="sebciem") | {"grid": grid}
    with pytest.raises((CaseError, ValueError), match="cannot be combined with walls and contact on a grid"):
        Case.model_validate(table)


def test_too_few_neighbours_are_an_error_of_the_case():
    flat = {"box": {"lower": (0.0, 0.0, 0.0), "upper": (0.1, 0.1, 0.1), "cells": (3, 3, 1)}}  # tetrahedra three times as high
    table = pulled_block(approximant={"kind": "moving-least-squares", "dilatation": 1.01}, mesh=flat)
    case = Case.model_validate(table)
    with pytest.raises(CaseError) as caught:
        Simulation(case, threads=1)
    (problem,) = caught.value.problems
    assert (problem.key, problem.value) == ("body.block.approximant.dilatation", 1.01)
    place = re.fullmatch(
        r"no shape functions at \((.*)\) m: the moment matrix is singular: there are too few neighbours.*", problem.text
    )
    assert all(0.0 <= float(x) <= 0.1 for x in place.group(1).split(", "))
    assert problem.remedy == "increase it, so that supports have more neighbours, or use a different approximant"


def test_conditions_that_say_the_same_twice_are_an_error_of_the_case():
    """Smooth functions are so alike at neighbouring nodes that forces on every node cannot be told apart."""
    with pytest.raises(CaseError, match="nearly dependent, with a condition number of") as caught:
        solid(irregular(4, 3), held(lambda x: x[:, 0] >= 0.0), essential="sebciem")
    (problem,) = caught.value.problems
    assert problem.key == "body.tissue.essential"
    assert "prescribe only nodes of the surface" in problem.remedy
