"""Steady states by dynamic relaxation: equilibria, their loads, the balance, checkpoints, and what stops them."""

import numpy as np
import pytest
from membranes import sheet
from solids import EDGE, TISSUE, block_of, layer

from pellucid.case import Case
from pellucid.errors import CaseError, RunStopped
from pellucid.results.storage.probes import ProbeReader
from pellucid.results.storage.run import Run
from pellucid.running.launch import resume_case, run_case
from pellucid.simulation.simulation import Simulation
from pellucid.step.limit import StepLimit
from pellucid.step.part import StepPart

LOW, HIGH = {"name": "bottom", "where": layer(0.0)}, layer(EDGE)
PULL = 0.03


def motion(pull):
    return {"name": "top", "body": "block", "part": HIGH, "hold": ["x", "y"]} | {
        "displacement": {"z": {"kind": "steady", "velocity": pull}}
    }


def pulled(steady=None, pull=PULL, **more):
    """A block between a clamp and one that has moved up by `pull` at the time 1 s of the loads."""
    body = block_of(cells=(2, 2, 2)) | more.pop("body", {})
    table = {
        "schema": 1,
        "title": "a test",
        "time": {"end": 1.0},
        "steady": {"method": "relaxation"} | (steady or {}),
        "body": [body],
    }
    return Case.model_validate(table | {"support": [LOW], "motion": [motion(pull)] if pull else []} | more)


def finished(case, threads=1):
    simulation = Simulation(case, threads=threads)
    while not simulation.clock.finished(None):
        simulation.step()
    return simulation


def test_a_part_limits_the_steps_of_a_relaxation():
    class Gap(StepPart):
        def step_limit(self):
            return StepLimit(1e-6, "spring", "a gap")

    sim = Simulation(pulled(), threads=1)
    sim.step()  # a fraction of the others
    before = sim.clock.next_step(sim.bodies)
    sim.parts.add([Gap()])
    assert sim.clock.next_step(sim.bodies) == sim.clock.case.courant * 1e-6 < before


@pytest.fixture(scope="module")
def reference():
    """The equilibrium to rounding, slowly loaded."""
    return finished(pulled({"tolerance": 1e-12, "loading": 1000}))


def test_the_forces_of_free_nodes_vanish_at_the_tolerance_that_is_asked(reference):
    assert reference.clock.facts()["steady"]["unbalanced_force"] < 1e-11
    rough = finished(pulled({"tolerance": 1e-4})).clock.facts()["steady"]
    assert 1e-11 < rough["unbalanced_force"] < 1e-4
    assert rough["estimated_error"] < 1e-4


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-6, 1e-7, 1e-9])
def test_the_estimated_error_bounds_the_error_of_the_displacements(reference, tolerance):
    """Twice: where several modes are left, the slowest is more than the decay of all tells."""
    exact = reference.bodies[0].arrays["position"]
    largest = abs(exact - reference.bodies[0].mesh.nodes).max()
    found = finished(pulled({"tolerance": tolerance})).bodies[0].arrays["position"]
    assert abs(found - exact).max() / largest < 2.0 * tolerance


def test_a_grid_about_a_lone_block_changes_nothing(reference):
    grid = {"lower": (-0.1, -0.1, -0.1), "upper": (0.2, 0.2, 0.2), "cell": 0.1}
    found = finished(pulled({"tolerance": 1e-9}, grid=grid))
    assert found.budget.energies()["strain"] == pytest.approx(reference.budget.energies()["strain"], rel=1e-10)
    assert abs(found.budget.conservation()["energy"]) < 1e-2


def test_the_equilibrium_depends_neither_on_the_way_there_nor_on_the_density(reference):
    strain = reference.budget.energies()["strain"]
    fast = finished(pulled({"tolerance": 1e-9, "loading": 150, "courant": 0.7}))
    heavy = finished(pulled({"tolerance": 1e-9}, body={"material": TISSUE | {"density": 5e4}}))
    assert [run.budget.energies()["strain"] for run in (fast, heavy)] == pytest.approx([strain] * 2, rel=1e-10)


def test_scaled_masses_allow_larger_steps_to_the_same_equilibrium():
    body = {"approximant": {"kind": "cell-based-maximum-entropy"}}
    scaled = finished(pulled({"tolerance": 1e-9, "mass_scaling": True}, body=body))
    plain = finished(pulled({"tolerance": 1e-9}, body=body))
    assert scaled.budget.energies()["strain"] == pytest.approx(plain.budget.energies()["strain"], rel=1e-10)
    assert scaled.dt > 1.02 * plain.dt
    assert scaled.bodies[0].motion.inertia.sum() == pytest.approx(scaled.bodies[0].mass, rel=1e-12)
    assert scaled.budget.conservation()["mass"] == 0.0


def test_work_goes_into_strain_and_damping_and_no_momentum_is_lost(reference):
    energies = reference.budget.energies()
    assert energies["damping_heat"] > 0.0
    assert energies["kinetic"] < 1e-20
    given = energies["motion_work"] + energies["support_work"] - energies["damping_heat"]
    # time integration: second order in a step that is small beside the loading
    assert given == pytest.approx(energies["strain"], rel=2e-3)
    # top and bottom pull against each other in every step: rounding is that of their impulses
    lost = reference.budget.conservation()["momentum"] * reference.budget.momentum_scale
    assert lost < 1e-14 * energies["strain"] / PULL * reference.dt * reference.n_steps


def reactions(case):
    """Reactions of top and bottom [N], shape (equilibria, 2, 3), and the strain energies [J], by load steps."""
    simulation, probes = Simulation(case, threads=1), []
    for name in ("top", "bottom"):
        probes += [{"name": f"{name}_{c}", "quantity": "reaction", "condition": name, "component": c} for c in "xyz"]
    reader = ProbeReader(case.model_validate(case.to_data() | {"probe": probes}).probe)
    rows, energy = [], []
    while not simulation.clock.finished(None):
        before = simulation.time
        simulation.step()
        if simulation.time > before:
            rows.append(reader.read(simulation.bodies, simulation.budget.reactions(), simulation.time))
            energy.append(simulation.budget.energies()["strain"])
    return np.array(rows).reshape(-1, 2, 3), np.array(energy)


def test_reactions_are_those_of_each_equilibrium():
    """They balance, and their work along the way is the strain energy: Simpson's rule, of fourth order in the load step."""
    force, energy = reactions(pulled({"tolerance": 1e-8, "load_steps": 4}))
    assert force.sum(axis=1) == pytest.approx(0.0, abs=1e-5 * force.max())
    f = np.concatenate([[0.0], force[:, 0, 2]])
    assert PULL / 12.0 * (f[0] + 4.0 * f[1] + 2.0 * f[2] + 4.0 * f[3] + f[4]) == pytest.approx(energy[-1], rel=1e-4)


def test_load_steps_end_in_the_state_of_one_step(reference):
    steps = finished(pulled({"tolerance": 1e-9, "load_steps": 3}))
    assert len(steps.clock.steps_taken) == 3
    assert steps.budget.energies()["strain"] == pytest.approx(reference.budget.energies()["strain"], rel=1e-9)


def test_a_block_hangs_by_its_weight():
    hung = pulled({"tolerance": 1e-9}, pull=0.0, gravity=(0.0, 0.0, -2.0))
    force, _ = reactions_of_bottom(hung)
    assert force == pytest.approx([0.0, 0.0, 2.0], abs=2e-8)  # 1 kg


def reactions_of_bottom(case):
    probes = [{"name": c, "quantity": "reaction", "condition": "bottom", "component": c} for c in "xyz"]
    simulation = finished(case)
    reader = ProbeReader(case.model_validate(case.to_data() | {"probe": probes}).probe)
    return np.array(reader.read(simulation.bodies, simulation.budget.reactions(), simulation.time)), simulation


def test_a_sheet_of_elements_hangs_by_its_weight():
    """Taut: gravity acts in its plane."""
    body = sheet(points=(5, 5), kind="membrane-elements")  # from x = -0.49 to 0.51
    edge = {"name": "bottom", "where": {"box": {"lower": (-0.5, -1.0, -1.0), "upper": (-0.48, 1.0, 1.0)}}}
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "steady": {"tolerance": 1e-7}, "body": [body]}
    force, simulation = reactions_of_bottom(Case.model_validate(table | {"support": [edge], "gravity": (5.0, 0.0, 0.0)}))
    assert force == pytest.approx([-50.0, 0.0, 0.0], abs=1e-3)  # 10 kg
    assert simulation.bodies[0].arrays["position"][:, 0].max() > 0.51


@pytest.mark.parametrize("steps", [60, 250])
def test_it_goes_on_from_a_checkpoint_bit_for_bit(steps):
    case = pulled({"loading": 100})
    one = Simulation(case, threads=1)
    for _ in range(steps):
        one.step()
    arrays = {name: array.copy() for name, array in one.state_arrays().items()}
    other = Simulation(case, threads=2)
    other.restore(arrays, one.state_numbers())
    for _ in range(350):
        one.step()
        other.step()
    assert (one.bodies[0].arrays["position"] == other.bodies[0].arrays["position"]).all()
    assert one.state_numbers() == other.state_numbers()


def test_a_missed_tolerance_keeps_the_state_and_can_go_on(tmp_path):
    case = pulled({"loading": 100, "most_steps": 150})
    with pytest.raises(
        RunStopped, match=r"load step 1 of 1: no steady state after 150 steps \(steady.most_steps = 150\)(.|\n)*last state"
    ):
        run_case(case, tmp_path / "run", report=False)
    kept = Run(tmp_path / "run")
    assert kept.history["time"].tolist() == [0.0, 1.0]
    assert kept.fields("block", 1.0)["position"][:, 2].max() == pytest.approx(EDGE + PULL, rel=1e-12)
    assert kept.summary["steady"]["estimated_error"] > 1e-6
    resume_case(tmp_path / "run", report=False, settings={"steady.most_steps": 100_000})
    run_case(pulled({"loading": 100}), tmp_path / "once", report=False)
    one, other = ((tmp_path / name / "history.csv").read_bytes() for name in ("run", "once"))
    assert one == other


def test_another_tolerance_ends_what_was_missed(tmp_path):
    with pytest.raises(RunStopped, match=r"no steady state after \d+ steps \(steady.most_steps = 300\):"):
        run_case(pulled({"loading": 100, "most_steps": 300}), tmp_path / "run", report=False)
    run = resume_case(tmp_path / "run", report=False, settings={"steady.tolerance": 0.1})
    assert run.summary["steady"]["estimated_error"] < 0.1
    assert run.summary["steps"] <= 400, "a hundred steps below the tolerance"


def nearly_incompressible(ratio, **steady):
    return pulled(steady, body={"material": TISSUE | {"poisson_ratio": ratio}})


def test_an_inertia_of_volume_changes_no_equilibrium(monkeypatch):
    """A block of so few nodes takes 800 steps to load with it, 7 000 without."""
    soon = finished(nearly_incompressible(0.4999, tolerance=1e-9))
    monkeypatch.setattr("pellucid.bodies.meshless_solid.body.pays", lambda solid, shear: False)
    late = finished(nearly_incompressible(0.4999, tolerance=1e-9))
    assert soon.budget.energies()["strain"] == pytest.approx(late.budget.energies()["strain"], rel=1e-10)
    assert soon.n_steps < 0.25 * late.n_steps
    assert abs(soon.budget.conservation()["energy"]) < 0.01


@pytest.mark.parametrize("ratio", [0.3, 0.4999])
def test_supports_let_go_in_a_load_step_stay_away(ratio):
    """Also while loads stand still; those that are let go under stress set out at once, in steps as small as it needs."""
    side = {"body": "block", "where": {"normal": (-1, 0, 0)}, "fix": ["x"], "until": 0.5}
    table = {"body": {"material": TISSUE | {"poisson_ratio": ratio}}, "support": [LOW, side]}
    released, free = finished(pulled({"load_steps": 2}, **table)), finished(pulled({}, body=table["body"]))
    energies = [run.budget.energies()["strain"] for run in (released, free)]
    assert energies[0] == pytest.approx(energies[1], rel=0.05), "but for faces on which functions vanish still"
    moved = released.bodies[0].arrays["position"][:, 0] - released.bodies[0].mesh.nodes[:, 0]
    assert abs(moved[released.bodies[0].mesh.nodes[:, 0] == 0.0]).max() > 0.02 * EDGE


def test_a_relaxation_with_an_inertia_of_volume_goes_on_bit_for_bit():
    whole = Simulation(nearly_incompressible(0.4999), threads=1)
    for _ in range(600):
        whole.step()
    arrays, numbers = whole.state_arrays(), whole.state_numbers()
    arrays = {name: array.copy() for name, array in arrays.items()}
    again = Simulation(nearly_incompressible(0.4999), threads=2)
    again.restore(arrays, numbers)
    for _ in range(100):
        whole.step()
        again.step()
    assert np.array_equal(whole.bodies[0].arrays["position"], again.bodies[0].arrays["position"])


def test_loads_that_grow_too_fast_invert_the_solid():
    named = r"body `block` is inverted between nodes .* m was at rest: the volume ratio of a point is -"
    with pytest.raises(RunStopped, match=named):
        finished(pulled({"loading": 3}, pull=-0.06))


def test_what_cannot_be_steady_is_refused():
    points = {"name": "block", "shape": {"box": {"lower": (0, 0, 0), "upper": (1, 1, 1)}}, "points_per_cell": (2, 2, 2)}
    grid = {"lower": (-1, -1, -1), "upper": (2, 2, 2), "cell": 0.5}
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "steady": {}, "grid": grid}
    with pytest.raises((CaseError, ValueError), match='steady states of kind "material-points" cannot be computed'):
        Case.model_validate(table | {"body": [points | {"kind": "material-points", "material": TISSUE}]})
    with pytest.raises((CaseError, ValueError), match="the step of a relaxation to steady states is chosen automatically"):
        pulled(time={"end": 1.0, "step": 1e-3})


def test_the_courant_number_of_motions_in_time_does_not_count_and_is_refused():
    with pytest.raises(CaseError, match=r"time.courant=0.3.*by steady.courant\n.*set steady.courant instead"):
        pulled().with_settings({"time.courant": 0.3})
    resolved = pulled().to_data()
    assert resolved["time"]["courant"] == 0.4, "a resolved case has all defaults, and runs again as it is"
    assert Case.model_validate(resolved) == pulled()


def test_gravity_and_loads_without_rise_grow_over_the_load_steps():
    """Half-way in time half of a smooth rise acts, at the end all: linear in small loads."""
    load = {"kind": "traction", "body": "block", "where": {"normal": (0.0, 0.0, 1.0)}, "traction": (0.0, 0.0, 3.0)}
    case = pulled({"tolerance": 1e-7, "load_steps": 2}, pull=0.0, gravity=(0.0, 0.0, -2.0), load=[load])
    force = vertical_reactions(case)
    assert force == pytest.approx([0.5 * (2.0 - 0.03), 2.0 - 0.03], abs=1e-5)  # 1 kg, 3 Pa on 0.01 m²


def vertical_reactions(case):
    """Of the bottom at each equilibrium [N]."""
    probe = {"name": "z", "quantity": "reaction", "condition": "bottom", "component": "z"}
    simulation, rows = Simulation(case, threads=1), []
    reader = ProbeReader(case.model_validate(case.to_data() | {"probe": [probe]}).probe)
    while not simulation.clock.finished(None):
        before = simulation.time
        simulation.step()
        if simulation.time > before:
            rows += reader.read(simulation.bodies, simulation.budget.reactions(), simulation.time)
    return rows


def test_a_body_that_moves_at_the_start_is_refused():
    with pytest.raises((CaseError, ValueError), match="the computation of steady states starts at rest"):
        pulled(body={"velocity": (0.0, 0.0, 1.0)})


def probed(steady, **more):
    probes = [{"name": "pull", "quantity": "reaction", "condition": "top", "component": "z"}]
    return pulled({"tolerance": 1e-8} | steady, probe=probes, **more)


def test_further_equilibria_lie_at_the_times_that_are_asked(tmp_path):
    levels = probed({"load_steps": 2, "at": [0.8, 0.3, 0.5]}).steady.levels(1.0)
    assert levels == pytest.approx([0.0, 0.6, 1.0, 1.6, 2.0]), "0.5 s is that of a load step"
    plain = run_case(probed({"load_steps": 2}), tmp_path / "plain", report=False).history
    found = run_case(probed({"load_steps": 2, "at": [0.8, 0.3]}), tmp_path / "found", report=False).history
    assert found["time"] == pytest.approx([0.0, 0.3, 0.5, 0.8, 1.0])
    assert found["pull"][[2, 4]] == pytest.approx(plain["pull"][[1, 2]], rel=1e-6), "the way there does not count"
    alone = run_case(probed({"load_steps": 1}, pull=0.3 * PULL), tmp_path / "alone", report=False).history
    assert found["pull"][1] == pytest.approx(alone["pull"][1], rel=1e-6)


def test_equilibria_close_to_each_other_have_rows_of_their_own(tmp_path):
    found = run_case(probed({"at": [0.5, 0.5001, 0.5002]}), tmp_path / "r", report=False).history
    assert found["time"] == pytest.approx([0.0, 0.5, 0.5001, 0.5002, 1.0], abs=1e-12)


def test_a_reaction_is_that_of_the_equilibrium_of_its_row_also_where_others_have_none(tmp_path):
    every = run_case(probed({"load_steps": 4}), tmp_path / "every", report=False).history
    some = run_case(probed({"load_steps": 4}, output={"history": 0.5}), tmp_path / "some", report=False).history
    assert some["time"] == pytest.approx([0.0, 0.5, 1.0])
    assert some["pull"] == pytest.approx(every["pull"][::2], rel=1e-12)


@pytest.mark.parametrize(
    ("at", "words"), [([1.5], "1.5 s is not between 0 and time.end"), ([0.0], "0 s is not between 0 and time.end")]
)
def test_equilibria_beyond_the_loads_are_refused(at, words):
    with pytest.raises(ValueError, match=words):
        pulled({"at": at})
