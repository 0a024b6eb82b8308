"""Paths of equilibria through limit points of the load: exact solutions, displacement control of the same model, limit points,
stability, works, checkpoints, and what is refused."""

import os
import signal

import numpy as np
import pytest
from ended_searches import assert_goes_on_after_a_signal
from scipy.linalg import eigh
from small_cases import assert_resumes, to_the_end
from solids import displacement

from pellucid.case import Case
from pellucid.errors import CaseError, RunStopped
from pellucid.running.launch import run_case
from pellucid.running.step_number import of_case
from pellucid.simulation.simulation import Simulation

pytestmark = [
    pytest.mark.filterwarnings("ignore:between .* the load factor has a"),
    pytest.mark.filterwarnings("ignore:the path of equilibria ends"),
]
ARC = {"control": "arc-length"}
SLOPE = np.radians(3.0)
ALONG, ACROSS = np.array([np.cos(SLOPE), 0.0, np.sin(SLOPE)]), np.array([-np.sin(SLOPE), 0.0, np.cos(SLOPE)])
TIP = {"box": {"lower": [0.99, -0.01, 0.05], "upper": [1.01, 0.01, 0.06]}}
PUSHED = 0.12
PRESSED = {"body": "bar", "value": 5.0, "where": {"normal": ACROSS.tolist()}}
PUSH = {"name": "push", "body": "bar", "part": TIP, "displacement": {"z": {"kind": "steady", "velocity": -PUSHED}}}


def balloon(refinements=3, load_steps=18, pressure=1.5, **steady):
    """A sphere of neo-Hookean rubber of radius, modulus and thickness 1, 1 and 0.01 under a pressure."""
    return Case.model_validate(
        {
            "schema": 1,
            "title": "a balloon",
            "time": {"end": 1.0},
            "steady": ARC | {"load_steps": load_steps} | steady,
            "body": [
                {
                    "name": "balloon",
                    "kind": "membrane-elements",
                    "elements": "triangles",
                    "surface": {"icosphere": {"centre": [0, 0, 0], "radius": 1.0, "refinements": refinements}},
                    "thickness": 0.01,
                    "material": {"kind": "surface-neo-hookean-membrane", "density": 1000.0, "shear_modulus": 1.0},
                }
            ],
            "pressure": [{"body": "balloon", "value": pressure}],
        }
    )


def toggle(load_steps=120, averaged=False, cells=(12, 1, 1), **more):
    """Half of a shallow frame of two clamped bars: a bar that rises by 3 degrees to a guided end, with a force on one node."""
    body = {
        "name": "bar",
        "kind": "meshless-solid",
        "mesh": {
            "box": {"lower": [0, 0, 0], "upper": [1.0, 0.04, 0.02], "cells": cells},
            "rotate": {"centre": [0, 0, 0], "axis": [0, -1, 0], "angle": 3.0},
        },
        "volume_averaging": averaged,
        "material": {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e7, "poisson_ratio": 0.3},
    }
    supports = [
        {"name": "foot", "where": {"normal": (-ALONG).tolist()}},
        {"name": "head", "where": {"normal": ALONG.tolist()}, "fix": ["x", "y"]},
    ]
    steady = ARC | {"load_steps": load_steps, "tolerance": 1e-8}
    table = {
        "schema": 1,
        "title": "a toggle frame",
        "time": {"end": 1.0},
        "steady": steady,
        "body": [body],
        "support": supports,
    }
    load = {"kind": "point-load", "body": "bar", "where": TIP, "force": [0.0, 0.0, -1.0]}
    return Case.model_validate(table | {"load": [load]} | more)


def path(simulation):
    return simulation.facts()["steady"]


def position(simulation):
    return simulation.bodies[0].arrays["position"]


def equilibria(simulation):
    """Advance to the end, and yield at each equilibrium the load factor, None without one, and the forces of supports and
    motions by name."""
    before, time = {}, 0.0
    while not simulation.clock.finished(None):
        simulation.step()
        if simulation.time > time:
            impulses = simulation.budget.reactions()
            forces = {name: (impulse - before.get(name, 0.0)) / (simulation.time - time) for name, impulse in impulses.items()}
            yield simulation.parts.columns().get("load_factor"), forces
            before, time = {name: impulse.copy() for name, impulse in impulses.items()}, simulation.time


# exact solutions


def test_a_balloon_passes_its_largest_pressure():
    """p = 2 (G/R) (1/λ - 1/λ⁷), largest at λ = 7^(1/6). With three refinements the flat triangles have an error of 0.4 %."""
    sim = Simulation(balloon(), threads=1)
    factors, stretches, modes = [], [], []
    while not sim.clock.finished(None):
        sim.step()
        stretches.append(np.linalg.norm(sim.bodies[0].arrays["position"], axis=1).mean())
        factors.append(sim.parts.columns()["load_factor"])
        modes.append(sim.parts.columns()["unstable_modes"])
    stretch = np.array(stretches)
    exact = 2.0 * (stretch**-1 - stretch**-7) / 1.5
    falls = stretch > 7.0 ** (1.0 / 6.0)
    assert (abs(np.array(factors) / exact - 1.0)[falls] < 0.01).all()
    assert (abs(np.array(factors) / exact - 1.0) < 0.02).all(), "near the start the stretch less 1 has the larger error"
    assert stretch.max() > 2.5
    assert (np.array(modes) == falls).all()
    (limit,) = path(sim)["limit_points"]
    assert limit["kind"] == "maximum"
    assert limit["load_factor"] == pytest.approx(2.0 * (7.0 ** (-1.0 / 6.0) - 7.0 ** (-7.0 / 6.0)) / 1.5, rel=0.01)
    assert path(sim)["reached_full_load"] is False
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


@pytest.mark.parametrize("case", [balloon(2, pressure=1.0), toggle(18, load=[], pressure=[PRESSED])])
def test_the_run_ends_where_all_loads_act(case):
    """Below the largest pressure the path reaches all of it, with the equilibrium of load control."""
    case = case.with_settings({"steady.tolerance": 1e-9})
    arc, load = (to_the_end(case.with_settings({"steady.control": control})) for control in ("arc-length", "load"))
    assert path(arc)["reached_full_load"] is True
    assert path(arc)["load_factors"][-1] == 1.0
    assert arc.clock.n_steps < 18
    assert arc.time == 1.0
    assert abs(position(arc) - position(load)).max() < 1e-8


def test_a_load_that_saturates_has_no_limit_points(tmp_path):
    """A tube in plane strain: p = (G/R) (1 - 1/λ⁴) increases to the end, also where the cubic between equilibria does not."""
    n, rings = 24, 5  # each ring is turned by half of a side
    angles = [2.0 * np.pi * (i + 0.5 * (ring % 2)) / n for ring in range(rings) for i in range(n)]
    lines = [f"v {np.cos(angle):.17g} {np.sin(angle):.17g} {0.2 * (k // n)}" for k, angle in enumerate(angles)]
    for k in range(n * (rings - 1)):
        ring, i = divmod(k, n)
        a, b = k + 1, ring * n + (i + 1) % n + 1
        lines += (
            [f"f {a} {b} {b + n}", f"f {a} {b + n} {a + n}"] if ring % 2 else [f"f {a} {b} {a + n}", f"f {b} {b + n} {a + n}"]
        )
    (tmp_path / "tube.obj").write_text("\n".join(lines))
    everywhere = {"box": {"lower": [-1e4, -1e4, -1.0], "upper": [1e4, 1e4, 1.0]}}
    tube = {"body.0.surface": {"file": {"path": str(tmp_path / "tube.obj")}}, "support": [{"where": everywhere, "fix": ["z"]}]}
    sim = to_the_end(balloon(1, 20, pressure=1.1).with_settings(tube))
    assert np.linalg.norm(position(sim)[:, :2], axis=1).min() > 100.0
    assert (np.diff(path(sim)["load_factors"]) > 0.0).all()
    assert path(sim)["limit_points"] == []
    assert path(sim)["branches_after_equilibria"] == []


# displacement control of the same model


@pytest.fixture(scope="module")
def snapped():
    """The toggle frame beyond its snap-through, with the displacements of the loaded node and the frames of the run."""
    sim = Simulation(toggle(), threads=1)
    return sim, [(factor, displacement(sim).copy()) for factor, _ in equilibria(sim)]


def loaded_node(sim):
    """Return the number of the node on which the force acts."""
    nodes, box = sim.bodies[0].mesh.nodes, TIP["box"]
    (node,) = np.flatnonzero(((nodes > box["lower"]) & (nodes < box["upper"])).all(axis=1))
    return node


def test_the_path_is_that_of_displacement_control(snapped):
    """The reaction of the node, if its displacement is prescribed, is the load on the path, on both branches."""
    sim, rows = snapped
    node = loaded_node(sim)
    down = np.array([-moved[node, 2] for _, moved in rows])
    chosen = np.flatnonzero(down < PUSHED)[::4]
    assert (np.diff(down) > 0.0).all()
    steady = {"tolerance": 1e-8, "at": (down[chosen] / PUSHED).tolist()}
    led = Simulation(toggle(load=[], motion=[PUSH], steady=steady), threads=1)
    forces = {round(led.time, 9): found["push"][2] for _, found in equilibria(led)}
    for number in chosen:
        factor = rows[number][0]
        assert -forces[round(down[number] / PUSHED, 9)] == pytest.approx(factor, rel=1e-5, abs=1e-7)


def test_limit_points_and_stability_agree(snapped):
    sim, rows = snapped
    found, factors = path(sim), np.array([factor for factor, _ in rows])
    upper, lower = found["limit_points"]
    assert (upper["kind"], lower["kind"]) == ("maximum", "minimum")
    between = slice(upper["after_equilibrium"], lower["after_equilibrium"])
    modes = np.array(found["unstable_modes"])
    assert (modes[between] == 1).all()
    assert modes.sum() == between.stop - between.start
    signs = np.sign(found["lowest_frequencies"])
    assert (signs == np.where(modes == 1, -1.0, 1.0)).all()
    assert upper["load_factor"] >= factors[: lower["after_equilibrium"]].max()
    assert lower["load_factor"] <= factors[upper["after_equilibrium"] :].min()
    assert found["branches_after_equilibria"] == []
    assert found["reached_full_load"] is True


def test_imaginary_frequencies_are_those_of_the_stiffness():
    """At an unstable equilibrium of a small model, all eigenvalues of the dense matrix are known."""
    sim = Simulation(toggle(60), threads=1)
    while sim.parts.columns()["unstable_modes"] == 0:
        sim.step()
    system, free = sim.clock._system, sim.clock._system._motion.free.ravel()
    ways = np.eye(free.size).reshape(free.size, -1, 3)
    dense = np.array([system._matrix().resisted_without_springs(way).ravel() for way in ways])[np.ix_(free, free)]
    mass = np.diag(np.repeat(sim.bodies[0].arrays["mass"], 3)[free])
    squares = eigh(dense, mass, eigvals_only=True)
    assert (squares < 0.0).sum() == 1
    assert path(sim)["lowest_frequencies"][-1] == pytest.approx(-np.sqrt(-squares[0]) / (2.0 * np.pi), rel=1e-6)


def test_the_works_of_the_loads_are_the_strain_energy(snapped):
    sim, _ = snapped
    assert abs(sim.budget.conservation()["energy"]) < 1e-4


def test_limit_points_hardly_depend_on_the_length_of_steps(snapped):
    coarse, fine = path(to_the_end(toggle(60)))["limit_points"], path(snapped[0])["limit_points"]
    for one, other in zip(coarse, fine, strict=True):
        assert one["load_factor"] == pytest.approx(other["load_factor"], rel=2e-3)


def roof(folder, n=8, thickness=6.35):
    """A quarter of a hinged cylindrical roof under a force on its crown: Sze, Liu & Lo 2004, Finite Elem. Anal. Des. 40, 1551,
    section 3.5, here with constant-strain triangles."""
    angle, across = np.meshgrid(np.linspace(0.0, 0.1, n + 1), np.linspace(0.0, 254.0, n + 1), indexing="ij")
    places = np.stack([2540.0 * np.sin(angle), across, 2540.0 * np.cos(angle)], axis=-1).reshape(-1, 3)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n) + 1).ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + n + 1, corner + n + 2], 1), np.stack([corner, corner + n + 2, corner + 1], 1)]
    )
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in places] + [f"f {a} {b} {c}" for a, b, c in faces]
    (folder / "roof.obj").write_text("\n".join(lines))
    young, poisson = 3102.75, 0.3
    body = {
        "name": "roof",
        "kind": "membrane-elements",
        "elements": "triangles",
        "thickness": thickness,
        "surface": {"file": {"path": str(folder / "roof.obj")}},
        "material": {"kind": "linear-membrane", "density": 1.0, "young_modulus": young, "poisson_ratio": poisson},
        "bending": {"rigidity": young * thickness**3 / 12.0 / (1.0 - poisson**2), "spontaneous_curvature": "start"},
    }

    crown = {"box": {"lower": [-1.0, 253.0, 0.0], "upper": [1.0, 255.0, 1e4]}}
    return Case.model_validate(
        {
            "schema": 1,
            "title": "a hinged roof",
            "grid": {"lower": [0.0, -46.0, 2400.0], "upper": [300.0, 254.0, 2600.0], "cell": 25.0},
            "time": {"end": 1.0},
            "steady": ARC | {"load_steps": 60},
            "body": [body],
            "support": [
                {"where": ["x-lower", "y-upper"], "fix": "normal"},
                {"body": "roof", "where": {"box": {"lower": [253.0, -1.0, 2500.0], "upper": [255.0, 255.0, 2550.0]}}},
            ],
            "load": [{"kind": "point-load", "body": "roof", "where": crown, "force": [0.0, 0.0, -750.0]}],
        }
    )


@pytest.mark.filterwarnings("ignore:support number")
def test_a_thin_roof_snaps_back(tmp_path):
    """Load and displacement of the crown both reverse, and the roof passes equilibria under a force upwards."""
    sim = Simulation(roof(tmp_path), threads=1)
    crown = np.linalg.norm(position(sim) - [0.0, 254.0, 2540.0], axis=1).argmin()
    start, down, factors = position(sim)[crown, 2], [], []
    for factor, _ in equilibria(sim):
        down.append(start - position(sim)[crown, 2])
        factors.append(factor)
    assert min(np.diff(down)) < 0.0
    assert min(factors) < -0.05
    assert [limit["kind"] for limit in path(sim)["limit_points"]] == ["maximum", "minimum"]
    assert factors[-1] == 1.0
    assert abs(sim.budget.conservation()["energy"]) < 1e-4


def test_a_branch_is_named():
    """A straight strut stays straight beyond Euler's load, and is then unstable."""
    end = {"normal": [1, 0, 0]}
    supports = [{"where": {"normal": [-1, 0, 0]}}, {"where": end, "fix": ["y", "z"]}]
    euler = 20.19 * 1e7 * 0.02**2 / 12.0  # clamped at one end, and hinged at the other
    load = {"kind": "traction", "body": "bar", "where": end, "traction": [-1.5 * euler, 0.0, 0.0]}
    straight = {"body.0.mesh.rotate.angle": 0.0, "body.0.material.poisson_ratio": 0.0}
    with pytest.warns(UserWarning, match="another path branches off"):
        sim = to_the_end(toggle(10, cells=(20, 1, 1)).with_settings(straight | {"support": supports, "load": [load]}))
    found = path(sim)
    assert found["limit_points"] == []
    (after,) = found["branches_after_equilibria"]
    assert 0.95 * found["load_factors"][after - 1] < 1.0 / 1.5 < 1.05 * found["load_factors"][after]
    assert found["unstable_modes"][-1] == 1
    assert abs(displacement(sim)[:, 2]).max() < 1e-3


# loads


def test_a_pressure_on_a_solid_is_in_the_tangent():
    """The pressure follows the faces: under one that matters for the stiffness, the matrix has the curvature of differences of
    all forces along any way. At the rims of the loaded faces only the symmetric part of its stiffness is included."""
    pressure = {"body": "bar", "value": 1e6, "where": {"normal": ACROSS.tolist()}}
    sim = Simulation(toggle(load=[], pressure=[pressure], load_steps=10_000), threads=1)
    sim.step()
    system, loads = sim.clock._system, sim.clock._loads
    x, free, size = position(sim).copy(), system._motion.free, 1e-6
    loads.attempt(x, 1.0)
    system.factor_indefinite()
    of_loads, random = system._load_stiffness(), np.random.default_rng(1)
    ways = [np.where(free, random.standard_normal(x.shape), 0.0) for _ in range(5)]
    stiffness = [np.sum(way * system._matrix().resisted_without_springs(way)) for way in ways]
    for way, found in zip(ways, stiffness, strict=True):
        ahead, behind = (loads.attempt(x + sign * size * way, 1.0).residual for sign in (1.0, -1.0))
        assert abs(found - np.sum(way * (behind - ahead)) / (2.0 * size)) < 1e-2 * abs(of_loads).max()


def test_gravity_and_other_loads_share_the_factor():
    """The reaction at the foot is the load factor times weight and force."""
    case = toggle(gravity=[0.0, 0.0, -1.0])
    sim = Simulation(case, threads=1)
    weight, factors = 1000.0 * 0.04 * 0.02, []
    for factor, held in equilibria(sim):
        assert held["foot"][2] == pytest.approx(factor * (weight + 1.0), rel=1e-6, abs=1e-7)
        factors.append(factor)
    assert factors[-1] == 1.0
    assert min(np.diff(factors)) < 0.0


def test_averaged_volumes_pass_limit_points():
    kinds = [limit["kind"] for limit in path(to_the_end(toggle(60, averaged=True)))["limit_points"]]
    assert kinds == ["maximum", "minimum"]


# checkpoints


@pytest.mark.parametrize("case", [balloon(1, 8), toggle(30, cells=(6, 1, 1))])
def test_results_do_not_depend_on_threads(case):
    one, two = (position(to_the_end(case, threads)) for threads in (1, 2))
    assert (one == two).all()


@pytest.mark.parametrize("before", [1, 5])
def test_a_path_goes_on_bit_for_bit(before):
    one, again = (Simulation(toggle(60), threads=1) for _ in range(2))
    assert_resumes(one, again, before, 4)
    assert path(one) == path(again)


def test_a_signal_ends_a_search_with_a_checkpoint_of_the_last_equilibrium(tmp_path, monkeypatch):
    case = balloon(1, 4)
    show = Simulation.show

    def signalled(simulation, progress):
        show(simulation, progress)
        if simulation.clock.n_steps == 2:
            os.kill(os.getpid(), signal.SIGTERM)

    one = assert_goes_on_after_a_signal(case, tmp_path, monkeypatch, Simulation, "show", signalled)
    assert b"load_factor,unstable_modes" in one


# what is refused, and what has no path


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"steady.at": [0.3]}, "the loads have no times"),
        ({"steady.method": "relaxation"}, "stable equilibria only"),
        ({"load.0.rise": 0.5}, "the same load factor"),
        ({"load.0.amplitude": {"times": [0, 1], "shares": [0, 1]}}, "the same load factor"),
        ({"support.1.until": 0.5}, "supports are fixed"),
        ({"body.0.essential": "ebciem"}, "needs a factored stiffness"),
        ({"motion": [PUSH]}, "prescribes no displacements"),
    ],
)
def test_what_the_path_does_not_include_is_refused(changes, match):
    with pytest.raises(CaseError, match=match):
        toggle().with_settings(changes)


def test_a_given_volume_is_refused():
    given = {"body": "balloon", "volume": {"times": [0, 1], "ratios": [1, 2]}}
    with pytest.raises(CaseError, match="depend on the volume"):
        balloon(1).with_settings({"pressure": [given]})


def test_errors_of_the_body_are_told_alone():
    with pytest.raises(CaseError) as error:
        toggle().with_settings({"body.0.material.poisson_ratio": 0.7})
    assert "poisson_ratio" in str(error.value)
    assert "steady" not in str(error.value)


def test_the_first_equilibrium_needs_supports():
    with pytest.raises(RunStopped, match=r"Hold the body by \[\[support\]\]s"):
        to_the_end(toggle(support=[], cells=(6, 1, 1)))


def test_a_start_that_is_no_equilibrium_is_refused():
    with pytest.raises(RunStopped, match="not in equilibrium without loads"):
        to_the_end(balloon(1, 4).with_settings({"body.0.inflation": 0.05}))


def test_a_flat_membrane_under_tension_starts_if_its_rim_is_held():
    rectangle = {"corner": [0, 0, 0], "first_edge": [1, 0, 0], "second_edge": [0, 1, 0], "points": [5, 5]}
    sides = [
        ([-1, -1, -1], [0.01, 2, 1]),
        ([0.99, -1, -1], [2, 2, 1]),
        ([-1, -1, -1], [2, 0.01, 1]),
        ([-1, 0.99, -1], [2, 2, 1]),
    ]
    supports = [{"where": {"box": {"lower": lower, "upper": upper}}} for lower, upper in sides]
    tense = {"body.0.surface": {"rectangle": rectangle}, "body.0.tension": 0.01, "pressure.0.value": 0.01}
    sim = to_the_end(balloon(1, 4).with_settings(tense | {"support": supports}))
    assert path(sim)["reached_full_load"] is True
    assert position(sim)[:, 2].max() > 0.01


def test_a_path_that_ends_below_the_loads_is_told_once():
    with pytest.warns(UserWarning, match="the path of equilibria ends at the load factor") as told:
        sim = to_the_end(balloon(1, 8))
    assert path(sim)["reached_full_load"] is False
    assert sum("steady.load_steps" in str(each.message) for each in told) == 1


def test_the_report_states_the_last_load_factor(tmp_path):
    run_case(balloon(1, 3), tmp_path / "run")
    assert "at most 3 equilibria, last load factor 0." in (tmp_path / "run" / "report.html").read_text()


def test_a_body_that_nothing_loads_has_no_path():
    with pytest.raises(RunStopped, match="the loads do not move the body"):
        to_the_end(balloon(1, pressure=0.0))


def test_validate_states_the_factors():
    assert "equilibria along a path" in str(of_case(toggle()))
