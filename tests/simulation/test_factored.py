"""Steady states with a factored stiffness: the equilibria of the relaxation, works, buckling, checkpoints, and load steps in
which no equilibrium is found."""

import os
import signal

import numpy as np
import pytest
from ended_searches import assert_goes_on_after_a_signal
from materials.samples import HYPERELASTIC, USERS
from pydantic import ValidationError
from scipy.integrate import simpson, solve_bvp
from small_cases import to_the_end
from solids import EDGE, TISSUE, block_of, displacement, layer

from pellucid.approximants.nodal import NODAL_APPROXIMANTS
from pellucid.case import Case
from pellucid.running.launch import resume_case, run_case
from pellucid.simulation import factored, minimum
from pellucid.simulation.simulation import Simulation

LOW, HIGH = {"name": "bottom", "where": layer(0.0)}, layer(EDGE)
TIP = {"kind": "traction", "where": {"normal": [1, 0, 0]}}


def motion(**displacement):
    ramp = {axis: {"kind": "steady", "velocity": speed} for axis, speed in displacement.items()}
    return {"name": "top", "body": "block", "part": HIGH, "displacement": ramp}


def block(method="factored", led=None, steady=None, **more):
    """A block that is clamped at its lower face and led at its upper face, by default upwards and aside."""
    body = block_of(cells=(2, 2, 2)) | more.pop("body", {})
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "steady": {"method": method} | (steady or {})}
    led = motion(z=0.03, y=0.01, x=0.0) if led is None else led
    return Case.model_validate(table | {"body": [body], "support": [LOW], "motion": [led] if led else []} | more)


def strut(sideways, load_steps=4, tolerance=1e-6):
    """A strut of 20 to 1 under 1.6 times Euler's load, π² E I / 4 L² = 0.617 kPa per area, and a small traction [Pa]."""
    body = {
        "name": "strut",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": [0, 0, 0], "upper": [2, 0.1, 0.1], "cells": [20, 2, 2]}},
        "material": {"kind": "neo-hookean", "density": 1000, "young_modulus": 1.2e6, "poisson_ratio": 0.0},
    }
    return Case.model_validate(
        {
            "schema": 1,
            "title": "a strut",
            "time": {"end": 1.0},
            "steady": {"load_steps": load_steps, "tolerance": tolerance},
            "body": [body],
            "support": [{"name": "foot", "where": {"normal": [-1, 0, 0]}}],
            "load": [TIP | {"body": "strut", "traction": [-987.0, 0.0, sideways], "rise": 1.0}],
        }
    )


def steady(simulation):
    return simulation.facts()["steady"]


# the same equilibria


@pytest.mark.parametrize("averaged", [False, True])
@pytest.mark.parametrize("approximant", NODAL_APPROXIMANTS.entries)
def test_the_equilibrium_is_that_of_the_relaxation(approximant, averaged):
    body = {"approximant": {"kind": approximant}, "volume_averaging": averaged}
    found, relaxed = (to_the_end(block(method, body=body, steady={"tolerance": 1e-8})) for method in ("factored", "relaxation"))
    error = abs(displacement(found) - displacement(relaxed)).max() / abs(displacement(relaxed)).max()
    assert error < 2e-7, "tolerance 1e-8, and what the relaxation underestimates"
    assert found.budget.stored == pytest.approx(relaxed.budget.stored, rel=1e-9)
    assert steady(found)["unbalanced_force"] < 1e-9
    assert steady(found)["relaxed_load_steps"] == []
    force = found.budget.reactions()["top"] / relaxed.budget.reactions()["top"]
    assert force == pytest.approx(1.0, abs=2e-4), "the relaxation sums the impulses of the end of its load step"


def test_loads_gravity_and_initial_stress_are_those_of_the_relaxation():
    body = {"initial_stress": [200.0, 0.0, -100.0, 0.0, 30.0, 0.0]}
    load = TIP | {"body": "block", "traction": [50.0, 20.0, 0.0]}
    both = [
        to_the_end(block(method, led={}, body=body, load=[load], gravity=[0.0, -3.0, 9.81]))
        for method in ("factored", "relaxation")
    ]
    error = abs(displacement(both[0]) - displacement(both[1])).max() / abs(displacement(both[1])).max()
    assert error < 2e-6


def test_a_pressure_follows_the_faces():
    pressure = {"body": "block", "value": 400.0, "where": {"normal": [0, 0, 1]}}
    found, relaxed = (
        to_the_end(block(method, led={}, pressure=[pressure], steady={"load_steps": 2}))
        for method in ("factored", "relaxation")
    )
    assert steady(found)["relaxed_load_steps"] == []
    assert abs(displacement(found) - displacement(relaxed)).max() < 2e-6 * abs(displacement(relaxed)).max()


def test_nearly_incompressible_solids():
    """Stretched by 30 % in one load step: the linear estimate has many times the energy of the equilibrium."""
    body, led = {"material": TISSUE | {"poisson_ratio": 0.4999}}, motion(z=0.03, x=0.0, y=0.0)
    found, relaxed = (to_the_end(block(method, body=body, led=led)) for method in ("factored", "relaxation"))
    assert steady(found)["relaxed_load_steps"] == []
    assert found.budget.stored == pytest.approx(relaxed.budget.stored, rel=1e-9)


def test_a_load_that_is_taken_off_leaves_nothing():
    """The last equilibrium has no displacement to compare with: errors are relative to the largest so far."""
    amplitude = {"times": [0.0, 0.5, 1.0], "shares": [0.0, 1.0, 0.0]}
    load = {"kind": "traction", "body": "block", "where": {"normal": [0, 0, 1]}, "traction": [300.0, 0.0, 500.0]}
    back = to_the_end(block(led={}, load=[load | {"amplitude": amplitude}], steady={"load_steps": 4}))
    assert abs(displacement(back)).max() < 1e-6 * EDGE
    assert steady(back)["unbalanced_force"] < 1e-6


def test_a_body_without_support_is_in_equilibrium_under_balanced_loads():
    loads = [
        {"kind": "traction", "body": "block", "where": {"normal": [side, 0, 0]}, "traction": [100.0 * side, 0.0, 0.0]}
        for side in (-1, 1)
    ]
    for method in ("factored", "relaxation"):
        free = to_the_end(block(method, led={}, support=[], load=loads))
        assert steady(free)["unbalanced_force"] < 1e-5, "relative to internal and external forces: their sum is 0"
        assert free.budget.stored == pytest.approx(0.0017415, rel=1e-4)


def test_the_energy_that_a_released_body_loses_is_a_heat():
    held = [LOW, {"name": "until", "where": HIGH, "until": 0.5}]
    released = to_the_end(block(led={}, support=held, gravity=[0.0, 0.0, -9.81], steady={"load_steps": 4}))
    relaxed = to_the_end(block("relaxation", led={}, support=held, gravity=[0.0, 0.0, -9.81], steady={"load_steps": 4}))
    assert abs(displacement(released) - displacement(relaxed)).max() < 2e-6 * abs(displacement(relaxed)).max()
    assert released.budget.energies()["damping_heat"] > 1e-3 * released.budget.stored
    assert abs(released.budget.energy_error()) < 1e-6


@pytest.mark.parametrize("tolerance", [1e-10, 1e-12])
def test_tolerances_near_rounding_are_reached(tolerance):
    found = to_the_end(strut(1.0, load_steps=2, tolerance=tolerance))
    assert steady(found)["relaxed_load_steps"] == []
    assert steady(found)["estimated_error"] < minimum.ROUNDED


def test_works_are_of_fourth_order_in_the_load_step():
    """The energy error compares the works along a path that is interpolated between equilibria with the stored energy."""
    errors = []
    for number in (1, 2, 4):
        load = TIP | {"body": "block", "traction": [0.0, 300.0, 0.0], "rise": 1.0}
        case = block(
            led=motion(z=0.05), steady={"load_steps": number, "tolerance": 1e-9}, load=[load], gravity=[20.0, 0.0, 0.0]
        )
        errors.append(abs(to_the_end(case).budget.conservation()["energy"]))
    assert errors[0] < 2e-2
    assert errors[2] < 1e-4
    assert np.log2(errors[1] / errors[2]) > 3.0


def test_results_do_not_depend_on_threads():
    one, two = (displacement(to_the_end(block(), threads)) for threads in (1, 2))
    assert (one == two).all()


def elastica(load):
    """Return the way of the tip along and across a cantilever of length 1 under a load across it that keeps its direction, for
    P L²/E I = load: E I θ'' = -P cos θ along the line, θ = 0 at the clamp and θ' = 0 at the tip."""
    s = np.linspace(0.0, 1.0, 201)
    found = solve_bvp(
        lambda s, y: [y[1], -load * np.cos(y[0])],
        lambda a, b: [a[0], b[1]],
        s,
        [0.5 * load * s, 0.5 * load * (1.0 - s)],
        tol=1e-8,
    )
    angle = found.sol(s)[0]
    return 1.0 - simpson(np.cos(angle), x=s), simpson(np.sin(angle), x=s)


def test_a_cantilever_bends_as_the_elastica():
    """With 20 and 40 cells along it, and two across, the error falls towards the effect of shear and of the cells across, of
    the size of (thickness/length)² = 0.25 %."""
    along, across = elastica(2000.0 * 0.01 * 4.0 / 10.0)
    errors = []
    for cells in (20, 40):
        changes = {"load.0.traction": [0.0, 0.0, -2000.0], "body.0.mesh.box.cells": [cells, 2, 2]}
        bent = to_the_end(strut(0.0, load_steps=2).with_settings(changes))
        tip = np.linalg.norm(bent.bodies[0].mesh.nodes - [2.0, 0.05, 0.05], axis=1).argmin()
        errors.append(abs(displacement(bent)[tip] / 2.0 - [-along, 0.0, -across]).max() / across)
    assert errors[0] < 0.01
    assert errors[1] < min(0.005, errors[0])


# buckling


def test_a_strut_leaves_its_straight_equilibrium_beyond_eulers_load():
    """Without any lateral load, so that the straight strut stays an equilibrium: the run names it and goes on to the bent one,
    which a strut with a small lateral load reaches as well."""
    straight, pushed = to_the_end(strut(0.0)), to_the_end(strut(1.0))
    bent = [np.linalg.norm(abs(displacement(sim)[:, 1:]).max(axis=0)) for sim in (straight, pushed)]
    assert bent[0] == pytest.approx(bent[1], rel=0.02)
    assert bent[0] > 1.0
    assert steady(straight)["unstable_load_steps"] == [3]
    assert steady(pushed)["unstable_load_steps"] == []


# checkpoints


def test_a_run_goes_on_bit_for_bit(tmp_path):
    case = block(steady={"load_steps": 3})
    run_case(case, tmp_path / "whole", report=False)
    run_case(case, tmp_path / "part", report=False, until=0.5)
    resume_case(tmp_path / "part", report=False)
    one, other = ((tmp_path / name / "history.csv").read_bytes() for name in ("part", "whole"))
    assert one == other


def test_slender_bodies_keep_double_precision_in_a_run_that_goes_on():
    """Single precision is given up at the first equilibrium, and does not serve again after a checkpoint."""
    one, other = (Simulation(strut(1.0, load_steps=2), threads=1) for _ in range(2))
    one.step()
    numbers = one.state_numbers()
    other.restore({name: array.copy() for name, array in one.state_arrays().items()}, numbers)
    assert other.state_numbers()["clock"]["in_single"] == numbers["clock"]["in_single"]
    for simulation in (one, other):
        simulation.step()
    assert (displacement(one) == displacement(other)).all()


def test_a_signal_ends_a_search_with_a_checkpoint_of_the_last_equilibrium(tmp_path, monkeypatch):
    case = block(steady={"load_steps": 2})
    show = Simulation.show

    def signalled(simulation, progress):
        show(simulation, progress)
        if simulation.clock.time > 0.0 and simulation.clock.search().count("iteration 3"):
            os.kill(os.getpid(), signal.SIGTERM)

    assert_goes_on_after_a_signal(case, tmp_path, monkeypatch, Simulation, "show", signalled)


def test_a_relaxation_within_a_load_step_goes_on_bit_for_bit(monkeypatch):
    monkeypatch.setattr(minimum, "MOST", 1)
    monkeypatch.setattr(factored, "SMALLEST", 0.6)
    one, other = (Simulation(block(), threads=1) for _ in range(2))
    with pytest.warns(UserWarning, match="the relaxation goes on"):
        one.step()
    for _ in range(30):
        one.step()
    other.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())
    for simulation in (one, other):
        for _ in range(30):
            simulation.step()
    assert (displacement(one) == displacement(other)).all()


# what is not found


def test_a_load_step_without_success_is_relaxed(monkeypatch):
    reference = displacement(to_the_end(block()))
    monkeypatch.setattr(minimum, "MOST", 1)
    monkeypatch.setattr(factored, "SMALLEST", 0.6)
    case = block(steady={"load_steps": 2})
    with pytest.warns(UserWarning, match=r"load step 1: no equilibrium was found with a factored stiffness"):
        relaxed = to_the_end(case)
    assert steady(relaxed)["relaxed_load_steps"] == [1, 2]
    assert abs(displacement(relaxed) - reference).max() < 3e-6 * abs(reference).max()


def test_a_load_step_that_inverts_points_is_divided():
    """In one step by 85 % the linear estimate inverts points of the block."""
    pressed = to_the_end(block(led=motion(z=-0.085), steady={"load_steps": 1}))
    assert steady(pressed)["relaxed_load_steps"] == []
    assert pressed.n_steps > 1


def test_what_the_stiffness_lacks_is_refused_or_relaxed():
    by_forces = {"body": {"essential": "sebciem"}}
    with pytest.raises(ValidationError, match='essential = "sebciem" of body block'):
        block(**by_forces)
    assert "method" not in steady(Simulation(block(None, **by_forces), threads=1))


# many cases


CASES = [(name, seed) for name in sorted(HYPERELASTIC.keys() - USERS.keys()) for seed in range(4)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), CASES)
def test_random_loads_on_every_law(name, seed):
    """Strains of up to a half under random motions or tractions: each run ends in an equilibrium of a stable body."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.3, 0.5) * EDGE
    direction = rng.standard_normal(3)
    x, y, z = (size * direction / np.linalg.norm(direction)).tolist()
    material = HYPERELASTIC[name].model_dump(mode="json")
    case = block(None, led=motion(x=x, y=y, z=z), body={"material": material}, steady={"load_steps": int(rng.integers(1, 4))})
    found = to_the_end(case)
    assert steady(found)["unbalanced_force"] < 1e-6
    assert abs(found.budget.conservation()["energy"]) < 0.05
