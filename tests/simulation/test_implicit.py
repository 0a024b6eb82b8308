"""Implicit time steps: order, conserved quantities, agreement with explicit steps and exact solutions, loads and constraints,
checkpoints, and steps that fail."""

import os
import signal

import numpy as np
import pytest
from ended_searches import assert_goes_on_after_a_signal
from pydantic import ValidationError
from scipy.interpolate import CubicSpline
from solids import EDGE, TISSUE, block_of, displacement, layer

from pellucid.case import Case
from pellucid.errors import RunStopped
from pellucid.running.forecast import foretell_case
from pellucid.running.launch import resume_case, run_case
from pellucid.simulation import implicit, minimum
from pellucid.simulation.simulation import Simulation

ELASTIC = {"kind": "decoupled-neo-hookean", "young_modulus": 3e3, "poisson_ratio": 0.45}
VISCOUS = {
    "kelvin-voigt": {"kind": "kelvin-voigt", "density": 1e3, "elastic": ELASTIC, "viscosity": 5.0},
    "prony": {
        "kind": "prony",
        "density": 1e3,
        "elastic": ELASTIC,
        "branches": [{"share": 0.5, "relaxation_time": 0.05}, {"share": 0.3, "relaxation_time": 0.5}],
    },
}
LOW, HIGH = {"name": "bottom", "where": layer(0.0)}, layer(EDGE)


def block(step=0.01, method="implicit", end=0.2, courant=None, **more):
    """A block of tissue that is clamped at its lower face and begins to swing sideways under its weight."""
    body = block_of(cells=(2, 2, 2)) | more.pop("body", {})
    table = {"schema": 1, "title": "a test", "gravity": [2.0, 0.0, -1.0], "support": [LOW], "body": [body]}
    time = {"end": end, "method": method} | ({"step": step} if step else {}) | ({"courant": courant} if courant else {})
    return Case.model_validate(table | {"time": time} | more)


def bar(step, method="implicit", end=0.1, courant=None, **more):
    """A bar of 1 × 0.1 × 0.1 m that can only move along itself, in a standing wave: its speed is that of pressure waves."""
    body = {
        "name": "bar",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": [0, 0, 0], "upper": [1, 0.1, 0.1], "cells": [20, 2, 2]}},
        "material": {"kind": "neo-hookean", "density": 1000, "young_modulus": 1e5, "poisson_ratio": 0.0},
        "initial": [{"kind": "sine-wave", "amplitude": [0.01, 0, 0], "wave_vector": [np.pi, 0, 0], "phase": np.pi / 2}],
    }
    sides = [{"where": "all-nodes", "fix": ["y", "z"]}]
    time = {"end": end, "method": method} | ({"step": step} if step else {}) | ({"courant": courant} if courant else {})
    return Case.model_validate({"schema": 1, "title": "a bar", "time": time, "body": [body], "support": sides} | more)


def spinning(step, end=1.0, modulus=1e6, threads=1):
    """A free bar of 1 × 0.1 × 0.1 m that rotates once in a second about an oblique axis and vibrates."""
    body = {
        "name": "bar",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": [-0.5, -0.05, -0.05], "upper": [0.5, 0.05, 0.05], "cells": [10, 2, 2]}},
        "material": {"kind": "neo-hookean", "density": 1000, "young_modulus": modulus, "poisson_ratio": 0.3},
        "initial": [{"kind": "velocity-gradient", "x": [0, -6.3, 0], "y": [6.3, 0, -2.1], "z": [0, 2.1, 0]}],
    }
    time = {"end": end, "method": "implicit", "step": step}
    return Simulation(Case.model_validate({"schema": 1, "title": "a bar", "time": time, "body": [body]}), threads=threads)


def finished(case, threads=1):
    simulation = case if isinstance(case, Simulation) else Simulation(case, threads=threads)
    while not simulation.clock.finished(None):
        simulation.step()
    return simulation


# accuracy


def test_the_order_is_two():
    """Over a quarter of the slowest period, in which steps resolve the fastest motion that the weight excites."""
    found = [displacement(finished(block(0.2 / number, end=0.2))) for number in (8, 16, 32)]
    rate = np.log2(np.linalg.norm(found[1] - found[0]) / np.linalg.norm(found[2] - found[1]))
    assert rate == pytest.approx(2.0, abs=0.2)


def test_a_standing_wave_has_the_period_of_its_frequency():
    """A step turns the phase of a wave of frequency ω by 2 arctan(ω Δt/2); the lumped masses slow it by (k h)²/24."""
    dt, omega = 5e-3, np.pi * np.sqrt(1e5 / 1000.0)
    simulation = Simulation(bar(dt, end=1.0), threads=1)
    end = np.flatnonzero(simulation.bodies[0].mesh.nodes[:, 0] == 0.0)
    speeds = [step.bodies[0].arrays["velocity"][end, 0].mean() / 0.01 for step in simulation]
    phases = 2.0 * np.arctan(0.5 * omega * dt) * np.arange(1, len(speeds) + 1)
    assert np.abs(speeds - np.cos(phases)).max() < 1.5 * phases[-1] * (np.pi * 0.05) ** 2 / 24.0 + 0.01


def test_explicit_steps_agree():
    """The bar's wave after a third of its period, and the swinging block."""
    for build, step, end in ((bar, 5e-4, 0.07), (block, 2.5e-3, 0.2)):
        one, other = finished(build(step, end=end)), finished(build(None, "explicit", end=end, courant=0.1))
        assert np.abs(displacement(one) - displacement(other)).max() < 5e-3 * np.abs(displacement(other)).max()
        assert one.n_steps < other.n_steps


# conserved quantities


@pytest.mark.parametrize(("step", "modulus"), [(0.02, 1e6), (0.02, 1e8)])
def test_a_free_rotation_keeps_momentum_angular_momentum_and_energy(step, modulus):
    """Also if the bar turns by 8 degrees in a step in which stiff waves cross it several times. The midpoint rule gains energy
    there until the bar bursts."""
    simulation = spinning(step, modulus=modulus)
    body = simulation.bodies[0]
    mass = body.arrays["mass"][:, None]

    def state():
        moving = mass * body.arrays["velocity"]
        turning = np.cross(body.arrays["position"], moving).sum(axis=0)
        return moving.sum(axis=0), turning, body.totals.kinetic + body.totals.stored

    before = state()
    energies = [state()[2] for _ in simulation]
    after = state()
    assert np.abs(after[0] - before[0]).max() < 1e-9 * np.abs(mass * body.arrays["velocity"]).sum()
    assert np.abs(after[1] - before[1]).max() < 1e-7 * np.abs(before[1]).max(), "a hundred times the tolerance of a step"
    assert np.abs(np.array(energies) / before[2] - 1.0).max() < 1e-7
    assert simulation.facts()["implicit"]["halved_steps"] == 0
    assert body.totals.stored > 0.0


@pytest.mark.parametrize("damping", [0.0, 5.0])
def test_the_energy_balance_closes(damping):
    """Constant forces do exactly their work, and the drag takes it at the mean velocity."""
    done = finished(block(body={"damping": damping}))
    assert abs(done.budget.conservation()["energy"]) < 1e-7
    assert abs(done.budget.conservation()["momentum"]) < 1e-8


def test_works_of_motions_are_those_of_their_reactions():
    """Strains change by up to 3 % in a step; the stored energy is the work of the forces up to the fourth order in the step."""
    led = {
        "name": "lift",
        "body": "block",
        "part": HIGH,
        "displacement": {"z": {"kind": "sine", "amplitude": 0.01, "period": 0.1}},
    }
    errors = []
    for step in (0.005, 0.0025):
        done = finished(block(step, end=0.12, motion=[led], body={"material": TISSUE | {"poisson_ratio": 0.3}}))
        errors.append(abs(done.budget.conservation()["energy"]))
        assert abs(done.budget.conservation()["momentum"]) < 1e-8
        assert abs(done.budget.energies()["motion_work"]) > 0.1 * done.budget.stored
    assert errors[0] < 1e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


def test_drag_slows_a_free_body():
    """Without other forces a step multiplies the velocity by (1 - c Δt/2)/(1 + c Δt/2)."""
    done = finished(block(gravity=[0, 0, 0], support=[], body={"damping": 5.0, "velocity": [1.0, 0.0, 0.0]}))
    assert done.bodies[0].arrays["velocity"][:, 0] == pytest.approx((0.975 / 1.025) ** 20, rel=1e-9)
    assert done.budget.energies()["damping_heat"] == pytest.approx(0.5 * (1.0 - (0.975 / 1.025) ** 40), rel=1e-9)


def test_a_slow_motion_passes_through_equilibria():
    """Pulled over twenty periods, with a drag that damps what the start excites. The drag on the moving body remains: a strain
    of ρ c v L/E."""
    steady = block_of(cells=(2, 2, 2))
    led = {"name": "top", "body": "block", "part": HIGH, "hold": ["x", "y"]}
    led["displacement"] = {"z": {"kind": "steady", "velocity": 0.002}}
    table = {"schema": 1, "title": "a test", "support": [LOW], "motion": [led]}
    slow = Case.model_validate(
        table | {"time": {"end": 10.0, "method": "implicit", "step": 0.1}, "body": [steady | {"damping": 5.0}]}
    )
    at_rest = Case.model_validate(table | {"time": {"end": 10.0}, "steady": {"tolerance": 1e-8}, "body": [steady]})
    one, other = Simulation(slow, threads=1), finished(at_rest)
    for _ in one:
        if one.n_steps == 99:
            before = one.budget.reactions()["top"]
    assert np.abs(displacement(one) - displacement(other)).max() < 2.0 * EDGE * (1000.0 * 5.0 * 0.002 * EDGE / 3e3)
    force = (one.budget.reactions()["top"] - before)[2] / 0.1, other.budget.reactions()["top"][2] / 10.0
    assert force[0] == pytest.approx(force[1], rel=0.01), "half a step earlier"


# loads and constraints


def test_nodes_follow_motions_and_supports_release_them():
    led = {"name": "top", "body": "block", "part": HIGH, "displacement": {"x": {"kind": "steady", "velocity": 0.1}}}
    until = {"name": "top", "where": HIGH, "until": 0.095}
    moved = displacement(finished(block(motion=[led], end=0.1)))
    assert np.ptp(moved[np.isclose(moved[:, 0], 0.01)][:, 0]) < 1e-15
    held, released = (displacement(finished(block(support=[LOW, until], end=end))) for end in (0.09, 0.2))
    top = finished(block(end=0.01)).bodies[0].mesh.nodes[:, 2] > EDGE - 1e-9
    assert (held[top] == 0.0).all()
    assert np.abs(released[top]).max() > 1e-4


def test_a_pressure_follows_the_faces():
    pressure = {"body": "block", "value": 100.0, "where": {"normal": [0, 0, 1]}}
    one = displacement(finished(block(2e-3, pressure=[pressure])))
    other = displacement(finished(block(None, "explicit", pressure=[pressure])))
    assert np.abs(one - other).max() < 0.01 * np.abs(other).max()


def test_nearly_incompressible_solids_take_the_steps_of_their_shear_waves():
    """ν = 0.4999: explicit steps have to follow the pressure waves, here through a hundred times as many steps."""
    material = {"material": TISSUE | {"poisson_ratio": 0.4999}}
    one, other = finished(block(0.01, body=material)), finished(block(None, "explicit", body=material))
    assert np.abs(displacement(one) - displacement(other)).max() < 0.01 * np.abs(displacement(other)).max()
    assert other.n_steps > 50 * one.n_steps


def test_results_do_not_depend_on_threads():
    one, two = (displacement(finished(spinning(0.02, end=0.2, threads=threads))) for threads in (1, 2))
    assert (one == two).all()


# materials with history variables


@pytest.mark.parametrize("material", VISCOUS.values(), ids=VISCOUS)
def test_viscous_solids_swing_as_with_explicit_steps(material):
    """The states are advanced once, at the end of each step. Energies of Prony branches are of second order, the heat of a
    viscosity is of first order in the strain of a step."""
    reference = finished(block(None, "explicit", body={"material": material}, courant=0.1))
    errors = []
    for step in (0.01, 0.005):
        done = finished(block(step, body={"material": material}))
        assert np.abs(displacement(done) - displacement(reference)).max() < 0.01 * np.abs(displacement(reference)).max()
        lost = [simulation.budget.energies()["dissipated"] for simulation in (done, reference)]
        assert lost[0] == pytest.approx(lost[1], rel=0.02)
        errors.append(abs(done.budget.conservation()["energy"]))
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 1.5


def test_a_viscous_run_goes_on_bit_for_bit(tmp_path):
    case = block(body={"material": VISCOUS["prony"]})
    run_case(case, tmp_path / "whole", report=False)
    run_case(case, tmp_path / "part", report=False, until=0.1)
    resume_case(tmp_path / "part", report=False)
    one, other = ((tmp_path / name / "history.csv").read_bytes() for name in ("part", "whole"))
    assert one == other


def test_gentle_loads_move_a_slender_body_by_less_than_rounding_of_its_positions_at_first():
    body = {
        "name": "flap",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": [0, 0, 0], "upper": [0.35, 0.02, 0.01], "cells": [35, 2, 1]}},
        "material": {"kind": "neo-hookean", "density": 1000, "young_modulus": 1.4e6, "poisson_ratio": 0.4},
    }
    held = [{"where": {"normal": [-1, 0, 0]}}, {"where": "all-nodes", "fix": ["z"]}]
    table = {"schema": 1, "title": "a flap", "gravity": [0, -2, 0], "gravity_amplitude": {"times": [0, 1], "shares": [0, 1]}}
    tips = []
    for step in (0.02, 0.01):
        time = {"end": 0.1, "method": "implicit", "step": step}
        found = finished(Case.model_validate(table | {"time": time, "body": [body], "support": held}))
        assert found.facts()["implicit"]["halved_steps"] == 0
        tips.append(displacement(found)[found.bodies[0].mesh.nodes[:, 0] > 0.3499, 1].mean())
    assert tips[0] == pytest.approx(tips[1], rel=0.03)
    assert tips[1] == pytest.approx(-2.0 * 0.1**3 / 6.0, rel=0.25), "as in free fall, with the waves from the support"


# checkpoints


def test_a_run_goes_on_bit_for_bit(tmp_path):
    """Although its factors were computed several steps before the checkpoint."""
    case = block()
    run_case(case, tmp_path / "whole", report=False)
    run_case(case, tmp_path / "part", report=False, until=0.1)
    resume_case(tmp_path / "part", report=False)
    one, other = ((tmp_path / name / "history.csv").read_bytes() for name in ("part", "whole"))
    assert one == other


def test_a_run_goes_on_with_other_steps(tmp_path):
    run_case(block(), tmp_path, report=False, until=0.1)
    done = resume_case(tmp_path, report=False, settings={"time.step": 0.004})
    assert done.history["time"][-1] == 0.2
    assert done.summary["steps"] == 10 + 25


def test_a_run_goes_on_beyond_a_last_step_that_was_shorter(tmp_path):
    run_case(block(0.03), tmp_path, report=False)
    done = resume_case(tmp_path, report=False, settings={"time.end": 0.29})
    assert done.history["time"][-1] == pytest.approx(0.29, rel=1e-12)
    assert done.summary["steps"] == 6 + 1 + 3


def test_a_signal_ends_a_search_with_a_checkpoint_of_the_last_step(tmp_path, monkeypatch):
    case = block()
    tell = implicit.ImplicitClock._tell

    def signalled(clock, iteration, error):
        if clock.n_steps == 7 and iteration == 2:
            os.kill(os.getpid(), signal.SIGTERM)
        tell(clock, iteration, error)

    assert_goes_on_after_a_signal(case, tmp_path, monkeypatch, implicit.ImplicitClock, "_tell", signalled)


# steps that fail, and cases that are refused


def test_a_step_that_fails_is_divided(monkeypatch):
    """Pressed by 85 % in one step: the predicted middle of the step is far from the solution."""
    whole = finished(block(0.05))
    search = minimum.Search.near

    def fails(self, starts, told, few):
        if self._system._half > 0.01:
            raise minimum.NoEquilibrium("as the test says")
        return search(self, starts, told, few)

    monkeypatch.setattr(minimum.Search, "near", fails)
    divided = finished(block(0.05))
    assert divided.clock.time == 0.2
    assert divided.n_steps == 16, "each step in four"
    assert divided.facts()["implicit"]["halved_steps"] > 2
    assert np.abs(displacement(divided) - displacement(whole)).max() < 0.1 * np.abs(displacement(whole)).max()


def test_a_load_that_crushes_the_body_stops_the_run():
    with pytest.raises(RunStopped, match=r"the equations of an implicit step of .* s have no solution"):
        finished(block(0.05, gravity=[0.0, 0.0, -4e4], end=1.0))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"grid": {"lower": [-1, -1, -1], "upper": [1, 1, 1], "cell": 0.1}}, "a case with a grid"),
        ({"body": {"essential": "sebciem"}}, r"essential = \"sebciem\" of body block"),
        ({"step": None}, "the length of implicit steps is not limited"),
        ({"steady": {}}, r"\[steady\] does not move bodies"),
        ({"settle": {}}, r"\[settle\] does not move bodies"),
    ],
)
def test_what_implicit_steps_lack_is_refused(change, words):
    with pytest.raises(ValidationError, match=words):
        block(**change)


def test_steps_and_factors_are_forecast():
    steps, _ = foretell_case(block())
    assert steps.startswith("steps: 20 of 0.01 s, time.step; implicit, with a factored stiffness of 105 unknowns")


# benchmark


@pytest.mark.slow
def test_a_flap_swings_under_its_weight():
    """CSM3 of Turek & Hron 2006 (Proposal for numerical benchmarking of fluid-structure interaction, LNCSE 53, 371): the tip
    moves by -14.305 ± 14.305 mm along and -63.607 ± 65.160 mm across, 1.0995 times a second. Three swings in 140 steps instead
    of 100 000. The law is neo-Hookean, not St. Venant-Kirchhoff, and the clamp is plane: 0.2 % in the state at rest."""
    body = {
        "name": "flap",
        "kind": "meshless-solid",
        "mesh": {"box": {"lower": [0.25, 0.19, 0], "upper": [0.6, 0.21, 0.005], "cells": [70, 4, 1]}},
        "material": {"kind": "neo-hookean", "density": 1000, "young_modulus": 1.4e6, "poisson_ratio": 0.4},
    }
    supports = [{"where": {"normal": [-1, 0, 0]}}, {"where": "all-nodes", "fix": ["z"]}]
    time = {"end": 2.8, "method": "implicit", "step": 0.02}
    table = {"schema": 1, "title": "CSM3", "gravity": [0, -2, 0], "time": time, "body": [body], "support": supports}
    simulation = Simulation(Case.model_validate(table), threads=1)
    tip = np.linalg.norm(simulation.bodies[0].mesh.nodes - [0.6, 0.2, 0.0], axis=1).argmin()
    moved = CubicSpline(0.02 * np.arange(141), [np.zeros(3), *(displacement(step)[tip] for step in simulation)])
    times = np.linspace(0.0, 2.8, 28001)
    along, across = 1e3 * moved(times)[:, :2].T
    swings = [(times > k / 1.0995) & (times < (k + 1) / 1.0995) for k in range(3)]
    lowest, highest = (np.mean([end(across[swing]) for swing in swings]) for end in (np.min, np.max))
    assert 0.5 * (highest + lowest) == pytest.approx(-63.607, rel=0.02)
    assert 0.5 * (highest - lowest) == pytest.approx(65.160, rel=0.02)
    assert np.mean([along[swing].min() for swing in swings]) == pytest.approx(-2.0 * 14.305, rel=0.02)
    turns = [times[swing][across[swing].argmin()] for swing in swings]
    assert 2.0 / (turns[2] - turns[0]) == pytest.approx(1.0995, rel=0.02)
    assert abs(simulation.budget.conservation()["energy"]) < 1e-6
