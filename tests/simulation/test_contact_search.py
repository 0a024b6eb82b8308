"""Equilibria with contact by a factored stiffness: forces of the relaxation, works, checkpoints, edges, cases at random."""

import warnings

import numpy as np
import pytest
from ended_searches import go_on, resumed_from, whole_and_ended

from pellucid.case import Case
from pellucid.results.storage.probes import ProbeReader
from pellucid.simulation import minimum
from pellucid.simulation.simulation import Simulation

EDGE = 0.1
TISSUE = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.3}
STEEL = {"kind": "linear-elastic", "density": 1000.0, "young_modulus": 1e7, "poisson_ratio": 0.3}
GRID = {"lower": [-0.1, -0.1, 0.0], "upper": [0.2, 0.2, 0.26], "cell": 0.02}
FOOT = {"body": "block", "name": "foot", "where": {"box": {"lower": [-1, -1, -1e-3], "upper": [1, 1, 1e-3]}}}
BALL = {"sphere": {"centre": [0.05, 0.05, EDGE + 0.0601], "radius": 0.06}}
PUNCH = {"box": {"lower": [0.02, 0.02, EDGE + 0.0005], "upper": [0.09, 0.09, EDGE + 0.04]}}
POST = {"cylinder": {"centre": [0.05, 0.05, EDGE + 0.0501], "radius": 0.04, "height": 0.1}}


def block(cells=(4, 4, 4), material=TISSUE, **more):
    mesh = {"box": {"lower": [0, 0, 0], "upper": [EDGE] * 3, "cells": list(cells)}}
    return {"name": "block", "field": "block", "kind": "meshless-solid", "mesh": mesh, "material": material} | more


def table(bodies, steady=None, **more):
    steady = {"tolerance": 1e-5} | (steady or {})
    general = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "grid": GRID, "steady": steady, "support": [FOOT]}
    probes = [{"name": c, "quantity": "reaction", "condition": "press", "component": c} for c in "xz"]
    return general | {"body": bodies, "probe": probes} | more


def under_tool(shape, depth=0.02, side=0.0, friction=None, steady=None, **more):
    """A block into which a rigid tool of a shape is pressed by a depth [m], and moved aside [m]."""
    tool = {"name": "tool", "field": "tool", "kind": "material-points", "rigid": True, "shape": shape, "points_per_cell": 8}
    ways = {"x": {"kind": "steady", "velocity": side}, "z": {"kind": "steady", "velocity": -depth}}
    motion = {"name": "press", "body": "tool", "hold": ["y"], "hold_rotation": ["x", "y", "z"], "displacement": ways}
    contact = {"between": ["tool", "block"]} | (friction or {})
    return table([block(**more), tool | {"material": STEEL}], steady, motion=[motion], contact=[contact])


def under_wall(depth=0.02, side=0.0, friction=None, steady=None, **more):
    """A block on which a wall presses."""
    wall = {"name": "press", "point": [0, 0, EDGE], "normal": [0, 0, -1], "velocity": [side, 0, -depth]} | (friction or {})
    return table([block(**more)], steady, wall=[wall])


def finished(data, threads=1):
    case = Case.model_validate(data)
    simulation = Simulation(case, threads=threads)
    go_on(simulation)
    return simulation


def forces(simulation):
    """Reactions of tool or wall along x and z [N]."""
    return ProbeReader(simulation.case.probe).read(simulation.bodies, simulation.budget.reactions(), simulation.time)


def steady(simulation):
    return simulation.facts()["steady"]


@pytest.mark.slow
def test_both_methods_find_the_same_force():
    """The relaxation leaves changes of 0.02 of the distance at which contact acts ahead: tenths of a percent of the force."""
    data = under_wall(friction={"kind": "stick"})
    found = finished(data)
    assert steady(found)["relaxed_load_steps"] == []
    relaxed = finished(data | {"steady": data["steady"] | {"method": "relaxation"}})
    assert forces(found)[1] == pytest.approx(forces(relaxed)[1], rel=0.005)


def test_works_of_contact_are_of_second_order():
    """The errors of works of the trapezoidal rule fall to a quarter with half of the load step; momentum is exact."""
    errors = []
    for load_steps in (1, 2, 4):
        conserved = finished(under_wall(steady={"load_steps": load_steps})).budget.conservation()
        errors.append(abs(conserved["energy"]))
        assert abs(conserved["momentum"]) < 1e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.3)


def test_a_wall_does_the_work_that_the_block_stores():
    """Without friction, contact takes nothing; the work of the wall is that of the mean of its forces at both ends."""
    simulation = finished(under_wall(steady={"load_steps": 4}))
    stored = simulation.budget.stored
    works = simulation.budget.energies()
    assert works["support_work"] == pytest.approx(stored, rel=5e-3)
    assert abs(works["contact_work"]) < 5e-3 * stored


@pytest.mark.slow
def test_reactions_after_a_relaxed_load_step_are_those_of_its_end(monkeypatch):
    """The second load step has no success with a factored stiffness."""
    flat = {"box": {"lower": [-0.01, -0.01, EDGE], "upper": [EDGE + 0.01, EDGE + 0.01, EDGE + 0.04]}}
    data = under_tool(flat, depth=0.01, steady={"load_steps": 2, "tolerance": 1e-4}, cells=(2, 2, 2))
    right = forces(finished(data))[1]
    simulation = Simulation(Case.model_validate(data), threads=1)
    while simulation.time == 0.0:
        simulation.step()

    def fail(*given):
        raise minimum.NoEquilibrium("for a test")

    monkeypatch.setattr(minimum.Minimiser, "find", fail)
    with pytest.warns(UserWarning, match="for a test"):
        go_on(simulation)
    assert steady(simulation)["relaxed_load_steps"] == [2]
    assert forces(simulation)[1] == pytest.approx(right, rel=0.01)


def test_a_block_that_only_contact_holds_is_pressed_without_retries():
    """A soft block rests with friction on a stiffer one; at the start they touch without pressure."""
    base = block(name="base", field="base", mesh={"box": {"lower": [0, 0, 0], "upper": [EDGE, EDGE, 0.05], "cells": [4, 4, 2]}})
    stiff = base | {"material": TISSUE | {"young_modulus": 3e4}}
    upper = {"box": {"lower": [0.02, 0.02, 0.05], "upper": [0.08, 0.08, EDGE], "cells": [3, 3, 3]}}
    wall = {"name": "press", "point": [0, 0, EDGE], "normal": [0, 0, -1], "velocity": [0, 0, -0.01]}
    joint = {"between": ["base", "block"], "kind": "coulomb", "friction": 0.4}
    data = table([stiff, block(mesh=upper)], {"load_steps": 2}, wall=[wall], contact=[joint])
    simulation = finished(data | {"support": [FOOT | {"body": "base"}]})
    assert simulation.n_steps == 2
    assert abs(simulation.budget.energy_error()) < 0.01


def test_a_tool_that_first_crosses_a_gap_is_not_relaxed():
    """It arrives at the force of a tool that began at the surface."""
    far = {"sphere": {"centre": [0.05, 0.05, EDGE + 0.0801], "radius": 0.06}}
    near, crossed = finished(under_tool(BALL, depth=0.01)), finished(under_tool(far, depth=0.03))
    assert steady(crossed)["relaxed_load_steps"] == []
    assert forces(crossed)[1] == pytest.approx(forces(near)[1], rel=5e-3)


def test_forces_at_edges_are_the_mean_of_four_detections():
    simulation = Simulation(Case.model_validate(under_tool(POST, side=-0.004, cells=(3, 4, 4))), threads=1)
    contact, counts = simulation.clock.touching._contact, []
    freeze = contact.freeze

    def counted(*given):
        freeze(*given)
        counts.append(len(contact._frozen))

    contact.freeze = counted
    with pytest.warns(UserWarning, match="jump"):
        go_on(simulation)
    assert set(counts) == {1, 2, 3, 4}


def test_tools_do_the_work_that_the_body_stores():
    """A ball that moves down and aside with friction: what friction does not dissipate is stored, and nothing is gained."""
    simulation = finished(under_tool(BALL, side=0.01, friction={"kind": "coulomb", "friction": 0.3}, steady={"load_steps": 2}))
    conserved = simulation.budget.conservation()
    assert abs(conserved["energy"]) < 0.01
    assert abs(conserved["momentum"]) < 1e-5
    along, across = forces(simulation)
    assert abs(along) <= 0.3 * abs(across) * 1.001


def test_it_goes_on_from_a_checkpoint_bit_for_bit():
    data = under_tool(BALL, side=0.004, friction={"kind": "coulomb", "friction": 0.3}, steady={"load_steps": 3})
    case = Case.model_validate(data)
    whole, parts = Simulation(case, threads=1), Simulation(case, threads=1)
    while whole.time == 0.0:
        whole.step()
    kept = {name: array.copy() for name, array in whole.state_arrays().items()}, whole.state_numbers()
    parts.restore(*kept)
    for simulation in (whole, parts):
        go_on(simulation)
    assert (whole.bodies[0].arrays["position"] == parts.bodies[0].arrays["position"]).all()
    assert whole.n_steps == parts.n_steps
    assert whole.budget.energy_error() == parts.budget.energy_error()


def test_a_search_that_is_ended_leaves_the_last_equilibrium():
    """A signal in the second load step, after offsets of contact and tool were changed: the run goes on with the same bits."""
    case = Case.model_validate(under_tool(BALL, steady={"load_steps": 2}))
    whole, ended = whole_and_ended(case)
    assert ended.clock.touching.overlap(1.0) < np.inf, "offsets were changed"
    resumed = resumed_from(ended, case)
    for simulation in (whole, resumed):
        go_on(simulation)
    assert (whole.bodies[0].arrays["position"] == resumed.bodies[0].arrays["position"]).all()


def test_the_number_of_threads_changes_nothing():
    one, two = (finished(under_tool(BALL, depth=0.01), threads) for threads in (1, 2))
    assert (one.bodies[0].arrays["position"] == two.bodies[0].arrays["position"]).all()


def test_a_tool_moves_no_farther_in_a_step_than_contact_is_seen():
    simulation = finished(under_tool(BALL, depth=0.03))
    deepest = simulation.clock.touching.largest_step() * 0.03 / 0.8
    assert simulation.n_steps >= 0.03 / deepest
    assert simulation.clock.n_steps > 1


def test_an_edge_that_presses_into_coarse_elements_is_named():
    with pytest.warns(UserWarning, match="the forces of contact jump by .* of all forces"):
        simulation = finished(under_tool(POST, side=-0.004, cells=(3, 4, 4)))
    assert steady(simulation)["unbalanced_force"] > 0.01
    assert steady(simulation)["relaxed_load_steps"] == []


def test_two_membranes_in_contact_and_contact_of_a_body_with_itself_are_relaxed():
    rectangle = {"corner": [0, 0, 0.15], "first_edge": [EDGE, 0, 0], "second_edge": [0, EDGE, 0], "points": [5, 5]}
    law = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3}
    sheet = {"kind": "membrane-elements", "elements": "triangles", "thickness": 1e-3, "material": law}
    upper = sheet | {"name": "upper", "field": "upper", "surface": {"rectangle": rectangle}}
    lower = sheet | {"name": "lower", "field": "lower", "surface": {"rectangle": rectangle | {"corner": [0, 0, 0.1]}}}
    rim = {"box": {"lower": [-1, -1, -1], "upper": [0.01, 1, 1]}}
    hold = [{"name": name, "body": name, "part": rim, "hold": ["x", "y", "z"]} for name in ("upper", "lower")]
    data = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "grid": GRID, "body": [upper, lower], "motion": hold}
    with pytest.raises(ValueError, match="contact of two membranes"):
        Case.model_validate(data | {"steady": {"method": "factored"}})
    itself = [{"between": ["block"], "kind": "frictionless"}]
    with pytest.raises(ValueError, match="contact of block with itself"):
        Case.model_validate(table([block()], {"method": "factored"}, contact=itself, probe=[]))


LAWS = {
    "neo-hookean": TISSUE,
    "mooney-rivlin": {"kind": "mooney-rivlin", "density": 1000.0, "c1": 400.0, "c2": 100.0, "bulk_modulus": 5e3},
    "ogden": {"kind": "ogden", "density": 1000.0, "shear_moduli": [600.0], "exponents": [5.0], "bulk_modulus": 5e3},
}
KINDS = {"frictionless": {}, "stick": {"kind": "stick"}, "coulomb": {"kind": "coulomb", "friction": 0.3}}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(24))
def test_random_tools_are_pressed_in_without_a_relaxation(seed):
    """Laws, tools, friction, meshes and depths of up to 30 % of the height at random: all converge; the energy error is small,
    or a warning states it, as with one load step or edges in coarse elements."""
    random = np.random.default_rng(seed)
    law = LAWS[str(random.choice(list(LAWS)))]
    how = {"depth": random.uniform(0.01, 0.03), "side": random.uniform(-0.01, 0.01)}
    how |= {"friction": KINDS[str(random.choice(list(KINDS)))], "steady": {"load_steps": int(random.integers(1, 4))}}
    how |= {"material": law, "cells": random.integers(3, 6, 3).tolist()}
    shape = [BALL, PUNCH, POST, None][seed % 4]
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        simulation = finished(under_wall(**how) if shape is None else under_tool(shape, **how))
    assert steady(simulation)["relaxed_load_steps"] == []
    assert steady(simulation)["estimated_error"] < 1e-5
    is_told = any("the works of loads and reactions differ" in str(each.message) for each in told)
    assert abs(simulation.budget.energy_error()) < 0.02 or is_told
    assert forces(simulation)[1] < 0.0
