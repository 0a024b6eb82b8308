"""Rigid bodies under forces in steady states with a factored stiffness: places found by prescribed motions, by finite elements
and in time, works, friction, springs, weight, checkpoints and messages."""

from copy import deepcopy
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from ended_searches import go_on, resumed_from, whole_and_ended

from pellucid.case import Case
from pellucid.errors import RunStopped
from pellucid.results.storage.probes import ProbeReader
from pellucid.simulation.simulation import Simulation

EDGE, TURNS = 0.1, ["x", "y", "z"]
TISSUE = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.3}
STEEL = {"kind": "linear-elastic", "density": 300.0, "young_modulus": 1e7, "poisson_ratio": 0.3}
GRID = {"lower": [-0.1, -0.1, 0.0], "upper": [0.2, 0.2, 0.26], "cell": 0.02}
FOOT = {"body": "block", "name": "foot", "where": {"box": {"lower": [-1, -1, -1e-3], "upper": [1, 1, 1e-3]}}}
BALL = {"sphere": {"centre": [0.05, 0.05, EDGE + 0.0601], "radius": 0.06}}
PLATE = {"box": {"lower": [-0.01, -0.01, EDGE + 0.001], "upper": [EDGE + 0.01, EDGE + 0.01, EDGE + 0.04]}}
ALONG_Z = {"name": "press", "body": "tool", "hold": ["x", "y"], "hold_rotation": TURNS}
ANYWHERE = {"name": "press", "body": "tool", "hold_rotation": TURNS}
FRICTION = {"kind": "coulomb", "friction": 0.3}


def block(cells=(5, 5, 5), **more):
    mesh = {"box": {"lower": [0, 0, 0], "upper": [EDGE] * 3, "cells": list(cells)}}
    return {"name": "block", "field": "block", "kind": "meshless-solid", "mesh": mesh, "material": TISSUE} | more


def tool(shape, name="tool"):
    own = {"name": name, "field": name, "kind": "material-points", "rigid": True, "shape": shape}
    return own | {"points_per_cell": 8, "material": STEEL}


def push(force, body="tool", **more):
    return {"kind": "rigid-force", "body": body, "force": list(force), "rise": 1.0} | more


def table(shape, motion, loads, steady=None, friction=None, body=None):
    """A block or another body under a tool."""
    data = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "grid": GRID, "steady": {"tolerance": 1e-5} | (steady or {})}
    data |= {"support": [FOOT], "body": [body or block(), tool(shape)], "motion": [motion], "load": loads}
    probes = [{"name": c, "quantity": "reaction", "condition": motion["name"], "component": c} for c in "xz"]
    return data | {"contact": [{"between": ["tool", "block"]} | (friction or {})], "probe": probes}


def by_force(shape, force, motion=ALONG_Z, **more):
    return table(shape, motion, [push(force)], **more)


def by_motion(shape, depth, **more):
    return table(shape, ALONG_Z | {"displacement": {"z": {"kind": "steady", "velocity": -depth}}}, [], **more)


def finished(data, threads=1):
    simulation = Simulation(Case.model_validate(data), threads=threads)
    go_on(simulation)
    return simulation


def place(simulation, name="tool"):
    """Displacement of a rigid body [m]."""
    body = next(body for body in simulation.bodies if body.name == name)
    return body.constraint.displacement()


def force_of(simulation):
    """Reaction of the motion of the tool along z in the last load step [N]; the run has one load step."""
    return ProbeReader(simulation.case.probe).read(simulation.bodies, simulation.budget.reactions(), simulation.time)[1]


@pytest.fixture(scope="module")
def pair():
    """Depth [m], and force under a prescribed motion [N], of the ball."""
    return 0.01, abs(force_of(finished(by_motion(BALL, 0.01))))


# places


def test_a_force_moves_the_ball_to_the_depth_of_the_motion_with_this_force(pair):
    depth, force = pair
    simulation = finished(by_force(BALL, [0, 0, -force]))
    assert place(simulation) == pytest.approx([0, 0, -depth], rel=1e-3, abs=1e-12)
    assert simulation.facts()["steady"]["relaxed_load_steps"] == []
    assert simulation.facts()["steady"]["unbalanced_force"] < 1e-4
    (free,) = simulation.clock.touching.free_tools
    assert free.pushed[2] == pytest.approx(force, rel=1e-6)


def test_load_steps_arrive_at_the_same_place(pair):
    """Without friction, the place does not depend on the way; the force returns to a half of its largest value."""
    depth, force = pair
    amplitude = {"times": [0.0, 0.5, 1.0], "shares": [0.0, 1.0, 0.5]}
    there_and_back = finished(table(BALL, ALONG_Z, [push([0, 0, -force], rise=0.0, amplitude=amplitude)], {"load_steps": 4}))
    half = finished(by_force(BALL, [0, 0, -0.5 * force]))
    assert place(there_and_back)[2] == pytest.approx(place(half)[2], rel=2e-3)
    assert place(finished(by_force(BALL, [0, 0, -force], steady={"load_steps": 3})))[2] == pytest.approx(-depth, rel=2e-3)


def test_a_body_first_crosses_a_gap_and_arrives_at_the_same_place(pair):
    depth, force = pair
    far = {"sphere": {"centre": [0.05, 0.05, EDGE + 0.0801], "radius": 0.06}}
    simulation = finished(by_force(far, [0, 0, -force]))
    assert place(simulation)[2] == pytest.approx(-depth - 0.02, rel=1e-3)
    assert abs(simulation.budget.conservation()["energy"]) < 5e-3, "the gap costs no work"


def test_a_force_of_twelve_times_the_shear_of_the_block_is_divided():
    """The first detection of contact sees one element; a large force is applied in parts."""
    simulation = finished(by_force(BALL, [0, 0, -12.0]))
    assert simulation.n_steps > 1
    assert place(simulation)[2] < -0.04
    assert abs(simulation.budget.conservation()["energy"]) < 5e-3


@pytest.mark.parametrize(("tool_kind", "finest"), [("cylinder", 0.1), pytest.param("sphere", 0.1, marks=pytest.mark.slow)])
def test_finite_elements_find_the_same_depth(tool_kind, finest):
    """The force of finite elements at a depth of 0.1 m presses tools in that far, with planes of symmetry through the tool. The
    force under a prescribed motion is 1.008 (cylinder) and 1.02 (ball) of it, and grows with the power 1.2 to 1.5 of depth."""
    path = Path(__file__).parents[2] / "validation" / "sphere-on-layer" / "by_surfaces.py"
    script = ModuleType("by_surfaces")
    script.__file__ = str(path)
    exec(path.read_text(encoding="utf-8"), script.__dict__)
    data = script.case(tool_kind, "steady", finest)
    del data["motion"][0]["displacement"]
    part = 0.25 if tool_kind == "sphere" else finest
    force = part * script.exact(tool_kind)
    simulation = finished(data | {"load": [push([0, 0, -force])]})
    assert -place(simulation)[2] - 0.2 * finest == pytest.approx(0.1, rel=0.015)


@pytest.mark.slow
def test_the_relaxation_finds_the_same_force():
    """The relaxation does not move rigid bodies: it finds the force at the depth to which the force moved the ball. Its removal
    of overlaps ends earlier, which leaves up to 1 % of the force."""
    simulation = finished(by_force(BALL, [0, 0, -1.0]))
    relaxed = finished(by_motion(BALL, -place(simulation)[2], steady={"method": "relaxation"}))
    assert force_of(relaxed) == pytest.approx(-1.0, rel=0.015)


@pytest.mark.slow
def test_a_plate_in_time_comes_to_rest_at_the_same_place():
    """Contact in time keeps an overlap of some percent of the compression, and the bodies rest after the force has grown."""
    data = by_force(PLATE, [0, 0, -2.0], body=block((3, 3, 3)))
    steady = place(finished(data))[2]
    in_time = deepcopy(data) | {"time": {"end": 3.0}}
    del in_time["steady"]
    in_time["body"][1]["material"] = STEEL | {"density": 5000.0}  # allows larger steps
    in_time["body"][0]["damping"], in_time["load"][0]["rise"] = 8.0, 1.5
    in_time["load"].append({"kind": "rigid-spring", "body": "tool", "damping": [0, 0, 5.0]})
    assert place(finished(in_time))[2] == pytest.approx(steady, rel=0.03)


def test_a_body_that_is_free_along_all_axes_stays_on_the_middle_of_the_block(pair):
    depth, force = pair
    found = place(finished(by_force(BALL, [0, 0, -force], ANYWHERE)))
    assert found[2] == pytest.approx(-depth, rel=2e-3)
    assert np.abs(found[:2]).max() < 0.01 * depth


def test_a_ball_on_a_membrane():
    """A square membrane that is held at its rim."""
    rectangle = {"corner": [0, 0, EDGE], "first_edge": [EDGE, 0, 0], "second_edge": [0, EDGE, 0], "points": [13, 13]}
    law = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e5, "poisson_ratio": 0.3}
    sheet = {"name": "block", "field": "block", "kind": "membrane-elements", "elements": "triangles", "thickness": 1e-3}
    sheet |= {"material": law, "surface": {"rectangle": rectangle}}
    rim = {"support": [{"body": "block", "where": "boundary"}]}
    above = {"sphere": {"centre": [0.05, 0.05, EDGE + 0.061], "radius": 0.06}}
    steps = {"load_steps": 3}
    simulation = Simulation(Case.model_validate(by_motion(above, 0.015, body=sheet, steady=steps) | rim), threads=1)
    go_on(simulation)
    (membrane, _), contact = simulation.bodies, simulation.clock.touching._contact
    pushed = contact.exert_on_trial([], 0.0, [simulation.bodies[1].contact_surface])[0]
    found = place(finished(by_force(above, [0, 0, -pushed[2]], body=sheet, steady=steps) | rim))
    assert found[2] == pytest.approx(-0.015, rel=2e-3)
    assert membrane.n_points == 169


def test_two_balls_on_both_sides_of_a_block():
    """Equal forces act on opposite sides of a symmetric block: the places differ by the overlap that may remain."""
    left = {"sphere": {"centre": [-0.0401, 0.05, 0.06], "radius": 0.04}}
    right = {"sphere": {"centre": [EDGE + 0.0401, 0.05, 0.06], "radius": 0.04}}
    hold = {"hold": ["y", "z"], "hold_rotation": TURNS}
    data = table(left, {"name": "press", "body": "tool"} | hold, [push([0.3, 0, 0]), push([-0.3, 0, 0], "other")])
    data["body"].append(tool(right, "other"))
    data["motion"].append({"name": "other", "body": "other"} | hold)
    data["contact"].append({"between": ["other", "block"]})
    simulation = finished(data)
    assert place(simulation)[0] > 0.003
    assert place(simulation, "other")[0] == pytest.approx(-place(simulation)[0], rel=5e-3)


# loads


def weight(motion=ALONG_Z, **more):
    return table(PLATE, motion, [], **more) | {"gravity": [0, 0, -9.81]}


def test_a_plate_rests_on_a_block_under_its_weight():
    """As under a force of this size, but for the weight of the block, which the force does not have."""
    data = weight(body=block(material=TISSUE | {"density": 1e-6}), steady={"load_steps": 2})
    simulation = finished(data)
    heavy = 9.81 * float(simulation.bodies[1].arrays["mass"].sum())
    alike = finished(by_force(PLATE, [0, 0, -heavy], body=data["body"][0], steady={"load_steps": 2}))
    assert place(simulation)[2] == pytest.approx(place(alike)[2], rel=1e-6)
    conserved = simulation.budget.conservation()
    assert abs(conserved["momentum"]) < 1e-6
    assert abs(conserved["energy"]) < 5e-3
    assert simulation.budget.energies()["gravity_work"] == pytest.approx(simulation.budget.stored, rel=0.03)


def test_friction_holds_a_plate_up_to_its_limit():
    held = finished(table(PLATE, ANYWHERE, [push([0.25, 0, -1.0])], {"load_steps": 2}, FRICTION))
    assert 0.0 < place(held)[0] < 0.02
    (free,) = held.clock.touching.free_tools
    assert free.pushed == pytest.approx([-0.25, 0, 1.0], rel=1e-4, abs=1e-4)


@pytest.mark.slow
def test_a_plate_that_slides_has_no_equilibrium():
    with pytest.raises(RunStopped, match="relaxation does not move the rigid body tool"):
        finished(table(PLATE, ANYWHERE, [push([0.35, 0, -1.0])], None, FRICTION, block((3, 3, 3))))


def test_a_motion_leads_a_ball_aside_while_a_force_presses_it(pair):
    _, force = pair
    aside = ALONG_Z | {"hold": ["y"], "displacement": {"x": {"kind": "steady", "velocity": 0.004}}}
    simulation = finished(by_force(BALL, [0, 0, -force], aside, friction=FRICTION, steady={"load_steps": 4}))
    (free,) = simulation.clock.touching.free_tools
    assert free.pushed[2] == pytest.approx(force, rel=1e-5)
    assert -0.3 * force <= free.pushed[0] < -0.1 * force
    assert place(simulation)[0] == pytest.approx(0.004, rel=1e-12)
    assert abs(simulation.budget.conservation()["momentum"]) < 1e-5


def test_a_motion_turns_a_ball_while_a_force_presses_it(pair):
    """All points slide, so that the torque does not depend on the way: it is that under a prescribed motion to this depth."""
    depth, force = pair
    turns = {"hold_rotation": ["x", "y"], "rotation": {"z": {"kind": "steady", "angular_velocity": 2.0}}}
    pressed, led = by_force(BALL, [0, 0, -force], friction=FRICTION), by_motion(BALL, depth, friction=FRICTION)
    for data in (pressed, led):
        data["motion"] = [data["motion"][0] | turns]
    torques = [finished(data).budget.angular_reactions()["press"][2] for data in (pressed, led)]
    assert abs(torques[1]) > 0.3 * 0.3 * force * 0.025, "a large part of that of points at the rim of contact"
    assert torques[0] == pytest.approx(torques[1], rel=0.02)


def test_a_spring_takes_a_body_along_that_touches_nothing():
    anchor = {"z": {"kind": "steady", "velocity": 0.01}}
    spring = {"kind": "rigid-spring", "body": "tool", "stiffness": [0, 0, 50.0], "anchor": anchor}
    simulation = finished(table(BALL, ALONG_Z, [spring], {"load_steps": 2}))
    assert place(simulation) == pytest.approx([0, 0, 0.01], rel=1e-9, abs=1e-15)
    assert simulation.facts()["steady"]["unbalanced_force"] < 1e-9


def test_a_spring_presses_with_what_is_left_of_its_travel():
    anchor = {"z": {"kind": "steady", "velocity": -0.015}}
    spring = {"kind": "rigid-spring", "body": "tool", "stiffness": [0, 0, 200.0], "anchor": anchor}
    simulation = finished(table(BALL, ALONG_Z, [spring], {"load_steps": 2}))
    (free,) = simulation.clock.touching.free_tools
    assert free.pushed[2] == pytest.approx(200.0 * (0.015 + place(simulation)[2]), rel=1e-5)
    pressed = finished(by_motion(BALL, -place(simulation)[2]))
    assert force_of(pressed) == pytest.approx(-free.pushed[2], rel=0.01)


def test_a_force_on_a_prescribed_tool_is_part_of_its_reaction():
    """Along the axis of the force the motion holds the tool: its reaction is smaller by the force."""
    alone = force_of(finished(by_motion(PLATE, 0.005)))
    data = by_motion(PLATE, 0.005) | {"load": [push([0, 0, -0.2])]}
    assert force_of(finished(data)) == pytest.approx(alone + 0.2, rel=1e-6)


def test_a_force_does_the_work_of_the_motion_with_this_force(pair):
    """Both are sums by the trapezoidal rule over different parts of the same way; where corners of the block come into contact,
    contact changes the energy by some percent of that which is stored."""
    depth, force = pair
    pushed = finished(by_force(BALL, [0, 0, -force], steady={"load_steps": 8}))
    moved = finished(by_motion(BALL, depth, steady={"load_steps": 8})).budget.energies()
    works, conserved = pushed.budget.energies(), pushed.budget.conservation()
    assert works["load_work"] == pytest.approx(moved["motion_work"], rel=0.01)
    assert works["load_work"] == pytest.approx(pushed.budget.stored, rel=0.04)
    assert abs(conserved["energy"]) < 0.02
    assert abs(conserved["momentum"]) < 1e-6


# the joint system


def test_the_factors_are_those_of_contact_and_body_in_series(pair):
    """Displacements under small forces change the residual forces by these forces."""
    simulation = finished(by_force(BALL, [0, 0, -pair[1]]))
    (system,) = simulation.clock._searched
    for body in (simulation.bodies[0],):
        body.motion.velocity[:] = 0.0
    at = system.tried.copy()
    before = system.attempt(at).residual
    system.factor()
    force = np.zeros_like(at)
    force[-1, 2] = -1e-4 * pair[1]
    moved = system.solve(force)
    change = before - system.attempt(at + moved).residual
    assert change[-1, 2] == pytest.approx(force[-1, 2], rel=0.02)
    assert np.abs(change[:-1]).max() < 0.02 * abs(force[-1, 2])
    assert (moved[-1, :2] == 0.0).all(), "held axes do not move"


# checkpoints and threads


def sliding():
    aside = ALONG_Z | {"hold": ["y"], "displacement": {"x": {"kind": "steady", "velocity": 0.004}}}
    return by_force(BALL, [0, 0, -1.1], aside, friction=FRICTION, steady={"load_steps": 3})


def same(one, other):
    arrays = zip(one.bodies, other.bodies, strict=True)
    assert all((a.arrays["position"] == b.arrays["position"]).all() for a, b in arrays)
    assert one.budget.energy_error() == other.budget.energy_error()


def test_a_run_goes_on_with_the_same_bits_also_after_a_search_that_was_ended():
    case = Case.model_validate(sliding())
    whole, ended = whole_and_ended(case, threads=2)
    resumed = resumed_from(ended, case, threads=2)
    for simulation in (whole, resumed):
        go_on(simulation)
    same(whole, resumed)


# messages


def test_a_body_that_its_force_moves_away_is_named():
    with pytest.raises(RunStopped, match="the rigid body tool moves it beyond the grid without contact"):
        finished(by_force(BALL, [0, 0, 1.0]))


def test_a_body_that_meets_a_wall_is_named():
    wall = {"name": "lid", "point": [0, 0, 0.24], "normal": [0, 0, -1]}
    with pytest.raises(RunStopped, match="body tool and wall lid overlap"):
        finished(by_force(BALL, [0, 0, 1.0]) | {"wall": [wall]})


def refused(data, match):
    with pytest.raises(ValueError, match=match):
        Case.model_validate(data)


def test_what_is_not_included_is_refused():
    data = by_force(BALL, [0, 0, -1.0])
    relaxation = data["steady"] | {"method": "relaxation"}
    refused(data | {"steady": relaxation}, "free along z, but the relaxation does not move rigid bodies")
    refused(data | {"load": []}, "free along z, but no load acts on it")
    pulled = {"kind": "body-force", "body": "tool", "acceleration": [0, 0, -1.0]}
    refused(data | {"load": [pulled]}, "does not include loads of this kind on the rigid body tool")
    refused(data | {"motion": [ALONG_Z | {"hold_rotation": ["x"]}]}, "free to rotate about y, z")
    damper = {"kind": "rigid-spring", "body": "tool", "stiffness": [0, 0, 9.0], "damping": [0, 0, 1.0]}
    refused(data | {"load": [damper]}, "dampers, whose force depends on time")
