"""Settling before the clock starts: an elastic column under its own weight against the exact compression."""

import json
import os
import signal
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from numba.core import event as numba_event
from small_cases import SLIP, advance, box, case, simulation

import pellucid
from pellucid.errors import CaseError, Interrupted, RunStopped, UsageError
from pellucid.results.storage import checkpoint, recorder
from pellucid.results.storage.recorder import Recorder
from pellucid.results.storage.run import Run
from pellucid.running.launch import resume_case
from pellucid.simulation.simulation import Simulation

SOFT = {"kind": "linear-elastic", "density": 1000.0, "young_modulus": 1e5, "poisson_ratio": 0.0}
PULL = 0.1  # m/s²: strains of 1e-3, for which the rate form is linear elasticity
HEIGHT, CELLS = 1.0, 8


def heavy_column(settle=None, **more):
    """A bar of 8 cells along x that stands on the ground between smooth walls."""
    settings = {"counts": (CELLS + 1, 1, 1), "cell": HEIGHT / CELLS, "functions": "quadratic-bspline", "thickness": 0.1}
    upper = (HEIGHT, HEIGHT / CELLS, 0.0)
    column = box((0, 0, 0), upper, SOFT, (3, 1, 1), name="column")
    supports = [*SLIP[2:4], SLIP[0]]
    found = case(column, support=supports, **({"gravity": (-PULL, 0.0, 0.0)} | settings | more))
    data = found.to_data() | {"grid": {**found.to_data()["grid"], "upper": [HEIGHT * 9 / 8, HEIGHT / CELLS, 0.0]}}
    return type(found).model_validate(data | ({"settle": settle} if settle is not None else {}))


def settled(**settle):
    """The same, settled."""
    sim = Simulation(heavy_column(settle), threads=1)
    sim.settle()
    return sim


def displacements(sim):
    """Heights at rest and displacements, by the layers of points."""
    body = sim.bodies[0]
    order = np.argsort(body.arrays["id"])
    rest = (np.arange(3 * CELLS) + 0.5) * HEIGHT / (3 * CELLS)
    return rest, np.sort(body.arrays["position"][order, 0]) - rest


def exact(rest):
    """u = -ρ g (H y - y²/2)/E."""
    return -1000.0 * PULL * (HEIGHT * rest - 0.5 * rest**2) / 1e5


def test_a_column_settles_to_its_exact_compression():
    sim = settled()
    rest, moved = displacements(sim)
    # of second order in the cell: (1/8)² of the displacement, and the square root of the share
    assert np.abs(moved - exact(rest)).max() < 0.5 / CELLS**2 * np.abs(exact(rest)).max()
    assert (sim.time, sim.n_steps, sim.kinetic_energy()) == (0.0, 0, 0.0)
    advance(sim, 300)
    assert np.abs(displacements(sim)[1] - moved).max() < 1e-3 * np.abs(moved).max(), "it stays there"
    assert abs(sim.budget.energy_error()) < 1e-6


def test_a_smaller_share_settles_nearer_to_rest():
    left = []
    for share in (1e-2, 1e-8):
        sim = settled(share=share)
        speeds = [np.abs(sim.step() or sim.bodies[0].arrays["velocity"]).max() for _ in range(200)]
        left.append(max(speeds))
    assert left[1] < 0.1 * left[0]


def test_without_rest_the_run_stops_and_says_what_to_do(tmp_path):
    loose = heavy_column({"most_steps": 60}).to_data()
    loose["support"] = loose["support"][:2]  # nothing holds it: it falls
    with pytest.raises(
        RunStopped,
        match=r"not at rest after settle.most_steps = 60 steps(.|\n)*Increase settle.most_steps .*resume the run. Or start",
    ):
        pellucid.run(type(heavy_column()).model_validate(loose), out=tmp_path / "run")
    failure = json.loads((tmp_path / "run" / "forensics" / "failure.json").read_text())
    assert "most_steps" in failure["message"]
    assert (failure["step"], failure["time"], failure["settling_step"]) == (0, 0.0, 60), "the run has not begun"
    run = Run(tmp_path / "run")
    assert run.history["step"].tolist() == [0]
    assert run.summary["conservation"] == {"mass": 0.0, "momentum": 0.0, "energy": 0.0}, "its record begins here"


def test_a_settling_that_ran_out_of_steps_goes_on_with_more(tmp_path):
    whole = pellucid.run(heavy_column({}, end=0.05), out=tmp_path / "whole", report=False)
    with pytest.raises(RunStopped, match="most_steps = 60 steps"):
        pellucid.run(heavy_column({"most_steps": 60}, end=0.05), out=tmp_path / "parts", report=False)
    for limit, reached in ((None, 60), (80, 80)):
        with pytest.raises(RunStopped, match=f"most_steps = {reached} steps"):
            resume_case(tmp_path / "parts", report=False, settings={"settle.most_steps": limit} if limit else None)
        failure = json.loads((tmp_path / "parts" / "forensics" / "failure.json").read_text())
        assert failure["settling_step"] == reached
    parts = resume_case(tmp_path / "parts", report=False, settings={"settle.most_steps": 1000})
    assert (parts.case.settle.most_steps, parts.finished, parts.stopped) == (1000, True, {})
    assert not (tmp_path / "parts" / "forensics").exists()
    assert parts.summary["settled"] == whole.summary["settled"]
    assert (whole.fields("column")["position"] == parts.fields("column")["position"]).all()
    histories = [(tmp_path / name / "history.csv").read_bytes() for name in ("whole", "parts")]
    assert histories[0] == histories[1]


def test_the_wall_time_of_a_run_has_its_settling_in_it_and_no_compilation(tmp_path, monkeypatch):
    """Also where it was stopped in between: here each step takes a second, and five more in the compiler."""
    seconds, kept = [0.0], Simulation.advance_bodies

    def step(sim):
        kept(sim)
        seconds[0] += 1.0
        with numba_event.trigger_event("numba:compiler_lock"):
            seconds[0] += 5.0

    monkeypatch.setattr(Simulation, "advance_bodies", step)
    monkeypatch.setattr(recorder, "clock", SimpleNamespace(monotonic=lambda: seconds[0]))
    monkeypatch.setattr(numba_event, "timer", lambda: seconds[0])
    found = heavy_column({"most_steps": 60}, end=0.05)
    with pytest.raises(RunStopped):
        pellucid.run(found, out=tmp_path / "run", report=False)
    assert Run(tmp_path / "run").summary["wall_seconds"] == 60.0
    seconds[0] += 1000.0  # until it goes on
    run = resume_case(tmp_path / "run", report=False, settings={"settle.most_steps": 1000})
    assert run.summary["wall_seconds"] == run.summary["settled"]["steps"] + run.summary["steps"]
    assert run.summary["point_steps_per_second"] == run.summary["points"]


def test_a_run_that_does_not_settle_takes_no_steps_of_settling(tmp_path):
    run = pellucid.run(heavy_column(None, end=0.05), out=tmp_path / "run", report=False, until=0.01)
    with pytest.raises(UsageError, match="settle was not set and is now"):
        resume_case(run.out, report=False, settings={"settle.most_steps": 1000})
    assert resume_case(run.out, report=False).finished


def lose_itself(sim, kept=Simulation.advance_bodies):
    """A step; after some of them the positions are no numbers."""
    kept(sim)
    if sim.n_steps == 12:
        sim.bodies[0].arrays["position"][:] = np.nan
        raise RunStopped("lost")


def test_a_settling_that_ends_in_no_numbers_leaves_its_record(tmp_path, monkeypatch):
    monkeypatch.setattr(Simulation, "advance_bodies", lose_itself)
    middle = {"name": "middle", "body": "column", "quantity": "position", "reduce": "point", "at": (0.5, 0.0, 0.0)}
    found = heavy_column({}, probe=[middle | {"change": True}, middle | {"name": "near", "reduce": "nearest"}])
    with pytest.raises(RunStopped, match="lost"):
        pellucid.run(found, out=tmp_path / "run")
    failure = json.loads((tmp_path / "run" / "forensics" / "failure.json").read_text())
    assert (failure["message"], failure["settling_step"]) == ("[settle]: lost", 12)
    assert (tmp_path / "run" / "report.html").is_file()
    assert Run(tmp_path / "run").history["step"].tolist() == [0]


def test_what_cannot_be_recorded_does_not_hide_why_a_settling_stopped(tmp_path, monkeypatch):
    def fails(recorder, sim):
        raise ValueError("no such state")

    monkeypatch.setattr(Simulation, "advance_bodies", lose_itself)
    monkeypatch.setattr(Recorder, "begin", fails)
    with pytest.raises(RunStopped, match="lost") as stopped:
        pellucid.run(heavy_column({}), out=tmp_path / "run", report=False)
    assert "The state at the stop could not be recorded: no such state" in stopped.value.__notes__
    assert (tmp_path / "run" / "forensics" / "failure.json").is_file()


def test_a_run_begins_settled_and_tells_of_it(tmp_path):
    run = pellucid.run(heavy_column({}, end=0.05), out=tmp_path / "run", report=False)
    assert run.summary["settled"]["steps"] > 50
    assert run.history["time"][0] == 0.0
    assert run.fields("column", 0.0)["position"][:, 0].max() < (1.0 - 0.5 / 24) * HEIGHT
    assert np.abs(run.history["kinetic_energy"]).max() < 1e-6 * 1000.0 * 0.125 * 0.1 * PULL


def test_a_run_that_goes_on_does_not_settle_again(tmp_path):
    whole = pellucid.run(heavy_column({}, end=0.2), out=tmp_path / "whole", report=False)
    pellucid.run(heavy_column({}, end=0.2), out=tmp_path / "parts", report=False, until=0.1)
    parts = resume_case(tmp_path / "parts", report=False)
    assert (whole.fields("column")["position"] == parts.fields("column")["position"]).all()
    assert parts.summary["settled"] == whole.summary["settled"]


class Killed(Exception):
    """The end of the process."""


@pytest.mark.parametrize("at", [40, None])
def test_a_run_that_is_killed_while_it_settles_goes_on_with_the_same_bits(tmp_path, monkeypatch, at):
    """In some step, and in the last."""
    found = heavy_column({}, end=0.05, output={"checkpoint": 1e-6})
    whole = pellucid.run(found, out=tmp_path / "whole", report=False)
    at = at or whole.summary["settled"]["steps"]
    left, kept = [at], Recorder.while_settling

    def killed(recorder, sim):
        kept(recorder, sim)
        left[0] -= 1
        if left[0] == 0:
            raise Killed

    monkeypatch.setattr(Recorder, "while_settling", killed)
    with pytest.raises(Killed):
        pellucid.run(found, out=tmp_path / "parts", report=False)
    monkeypatch.setattr(Recorder, "while_settling", kept)
    simulation_of, steps = Simulation.advance_bodies, []
    monkeypatch.setattr(Simulation, "advance_bodies", lambda sim: (steps.append(sim.time), simulation_of(sim))[1])
    parts = resume_case(tmp_path / "parts", report=False)
    assert steps.count(0.0) - 1 == whole.summary["settled"]["steps"] - at, "it does not begin again"
    assert parts.summary["settled"] == whole.summary["settled"]
    assert (whole.fields("column")["position"] == parts.fields("column")["position"]).all()
    histories = [(tmp_path / name / "history.csv").read_bytes() for name in ("whole", "parts")]
    assert histories[0] == histories[1]


def test_a_signal_while_bodies_settle_leaves_a_checkpoint(tmp_path, monkeypatch):
    found, kept = heavy_column({}, end=0.05), Recorder.while_settling

    def signalled(recorder, sim):
        kept(recorder, sim)
        if sim.n_steps == 30:
            os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(Recorder, "while_settling", signalled)
    with pytest.raises(Interrupted):
        pellucid.run(found, out=tmp_path / "run", report=False)
    monkeypatch.setattr(Recorder, "while_settling", kept)
    assert checkpoint.read_latest(tmp_path / "run" / "checkpoint", print) is not None
    assert resume_case(tmp_path / "run", report=False).summary["settled"]["steps"] > 50


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"steady": {}}, r"\[settle\] and \[steady\] cannot be combined"),
        ({"velocity": (0.0, 1.0, 0.0)}, "brings all bodies to rest"),
        ({"moving": (0.0, 1.0, 0.0)}, "a moving support"),
    ],
)
def test_what_cannot_settle_is_refused(change, message):
    data = heavy_column({}).to_data()
    if "velocity" in change:
        data["body"][0] |= change
    elif "moving" in change:
        data["support"][0]["velocity"] = change["moving"]
    else:
        data |= change
    with pytest.raises((CaseError, ValueError), match=message):
        type(heavy_column()).model_validate(data)


def test_a_point_lost_on_the_way_is_told_to_be_of_the_settling(tmp_path):
    """A column that nothing holds falls out of the grid."""
    loose = heavy_column({}, gravity=(-100.0, 0.0, 0.0)).to_data()
    loose["support"] = loose["support"][:2]
    with pytest.raises(
        RunStopped, match=r"^\[settle\]: step \d+, .* left the grid; .*\n    Constrain bodies that can fall"
    ) as stopped:
        pellucid.run(type(heavy_column()).model_validate(loose), out=tmp_path / "run", report=False)
    assert stopped.value.place["settling_step"] == stopped.value.place["step"]
    assert stopped.value.place["body"] == "column"


def test_motion_that_settling_takes_is_told_and_does_not_count():
    """Bodies that go on from an earlier run bring it; what is left of one that was settled there is none."""
    sim, still = (Simulation(heavy_column({}, step=4e-3), threads=1) for _ in range(2))
    still.settle()
    sim.bodies[0].arrays["velocity"][:, 0] = 1e-3
    sim.bodies[0].renew_totals()
    kinetic = 0.5 * sim.bodies[0].mass * 1e-6
    with pytest.warns(UserWarning, match=rf"\[settle\] sets all velocities to zero, .* kinetic energy of {kinetic:.3g} J"):
        sim.settle()
    assert (sim.bodies[0].arrays["position"] == still.bodies[0].arrays["position"]).all()
    advance(sim, 10)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.settle()


def test_without_the_table_nothing_settles():
    sim = simulation(box((1, 1, 1), (3, 3, 3)))
    sim.settle()
    assert sim.facts() == {}


def test_a_gel_is_filled_in_settles_and_is_let_go():
    """Behind a gate it keeps its width; when that is gone it bulges, and the ledger knows of no loss."""
    gel = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3}
    gate = {"where": {"box": {"lower": (8, 0, 0), "upper": (8, 10, 0)}}, "fix": ["x"], "until": 0.0}
    walls = [wall for wall in SLIP[:4] if wall["where"] in ("x-lower", "y-lower")]
    block = box((0, 0, 0), (8, 8, 0), gel, (3, 3, 1))
    size = {"cell": 1.0, "counts": (16, 10, 1), "functions": "quadratic-bspline", "thickness": 1.0}
    found = case(block, support=[*walls, gate], gravity=(0.0, -0.2, 0.0), end=2.0, **size)
    sim = Simulation(type(found).model_validate(found.to_data() | {"settle": {}}), threads=1)
    sim.settle()
    arrays = sim.bodies[0].arrays
    outer = arrays["id"][arrays["position"][:, 0] > 7.7]
    before = arrays["position"][np.isin(arrays["id"], outer), 0].mean()
    assert arrays["position"][:, 0].max() < 8.0
    while sim.time < 1.0:
        sim.step()
    arrays = sim.bodies[0].arrays
    moved = arrays["position"][np.isin(arrays["id"], outer), 0].mean() - before
    # the gate bore ν/(1 - ν) ρ g h/2 in the mean; behind the wave that frees the face, v = σ/(ρ c)
    wave = np.sqrt(1e4 * 0.7 / (1.3 * 0.4) / 1000.0)
    assert moved == pytest.approx(0.3 / 0.7 * 0.5 * 1000.0 * 0.2 * 8.0 / (1000.0 * wave), rel=0.2)
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


def test_bodies_at_rest_in_contact_stay_at_rest():
    """A block on soil in velocity fields of their own: contact that is left in what strains them would let waves grow."""
    soil = box((0, 0, 0), (0.6, 0.3, 0), SOFT | {"young_modulus": 2e6, "poisson_ratio": 0.3}, (2, 2, 1), name="soil")
    block = box(
        (0.2, 0.3, 0),
        (0.4, 0.5, 0),
        SOFT | {"young_modulus": 2e7, "poisson_ratio": 0.2},
        (2, 2, 1),
        name="block",
        field="block",
    )
    how = {"cell": 0.1, "thickness": 0.1, "support": SLIP[:4], "gravity": (0.0, -10.0, 0.0), "end": 1e3}
    found = case(soil, block, counts=(6, 6, 0), **how)
    sim = Simulation(type(found).model_validate(found.to_data() | {"settle": {"share": 1e-6}}), threads=1)
    sim.settle()
    moving = []
    for _ in range(8):
        advance(sim, 250)
        moving.append(sim.kinetic_energy())
    # it swings as settling left it, at first still more; left in the strains, it grows ten thousand times
    assert max(moving[4:]) < 10.0 * max(moving[:2])
    assert max(moving) < 1e-8 * sim.budget.energy_scale


def test_soft_bodies_in_contact_come_to_rest():
    """A soft block sinks into soft soil of another velocity field, at the default Courant number; contact wins no energy."""
    soft = SOFT | {"young_modulus": 1e5, "poisson_ratio": 0.3}
    soil = box((0, 0, 0), (1.0, 0.4, 0), soft, (2, 2, 1), name="soil")
    block = box((0.3, 0.4, 0), (0.7, 0.7, 0), soft, (2, 2, 1), name="block", field="block")
    how = {"cell": 0.05, "thickness": 0.05, "support": SLIP[:3], "gravity": (0.0, -9.81, 0.0), "end": 0.1}
    found = case(soil, block, counts=(20, 20, 0), **how)
    sim = Simulation(type(found).model_validate(found.to_data() | {"settle": {"share": 1e-6}}), threads=1)
    sim.settle()
    advance(sim, 200)
    assert abs(sim.budget.energies()["contact_work"]) < 1e-5 * sim.budget.energy_scale
    places = sim.bodies[1].arrays["position"]
    assert places[:, 1].min() - sim.bodies[0].arrays["position"][:, 1].max() < 0.06
    assert np.ptp(places[:, 1]) < 0.3  # the block is whole, and shorter
