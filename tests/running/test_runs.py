"""Whole runs of the fake simulation: what they leave behind, and that a broken-off run ends as an undisturbed one."""

import json
import resource
import time

import numpy as np
import pytest
from commands_of_runs import OFTEN, begin_with_a_checkpoint_each_step, go_on, results
from free_flight import FakeBudget, FakeSimulation, free_flight
from other_processes import killed_at_last

import pellucid
from pellucid.errors import RunStopped, UnknownName, UsageError
from pellucid.results.report.report import write_report
from pellucid.results.storage.files import OutputError
from pellucid.results.storage.run import Run
from pellucid.running.launch import resume_case, run_case

pytestmark = pytest.mark.usefixtures("fake")

SUMMARY = {
    "case", "version", "commit", "threads", "processes", "points", "steps", "wall_seconds", "point_steps_per_second",
    "end_time", "conservation", "energies", "metrics",
}  # fmt: skip


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    return tmp_path_factory.mktemp("undisturbed") / "run"


@pytest.fixture
def expected(undisturbed, fake):
    if not undisturbed.exists():
        run_case(free_flight(), undisturbed, report=False)
    return results(undisturbed)


def test_a_run_leaves_what_was_promised(tmp_path):
    case = free_flight()
    run = run_case(case, tmp_path / "run", threads=2)
    names = {str(path.relative_to(run.out)) for path in run.out.rglob("*") if path.is_file()}
    assert {
        "case.toml",
        "history.csv",
        "summary.json",
        "report.html",
        "fields/gas.vtkhdf",
        "fields/block.vtkhdf",
    } <= names
    assert {"figures/energies.png", "figures/momentum.png", "figures/bodies_speed.png"} <= names
    assert run.case == case
    assert run.summary.keys() == SUMMARY
    assert run.summary["threads"] == 2
    assert run.summary["points"] == 112
    assert run.summary["conservation"].keys() == {"mass", "momentum", "energy"}
    assert run.metrics == {}


def test_rows_and_frames_come_at_the_first_step_at_or_after_each_instant(tmp_path):
    run = run_case(free_flight(), tmp_path / "run", report=False)
    assert run.history["time"] == pytest.approx([0.0, 0.12, 0.21, 0.3, 0.42, 0.51, 0.6, 0.72, 0.81, 0.9, 1.0])
    assert run.times("gas") == pytest.approx([0.0, 0.27, 0.51, 0.75, 1.0])
    assert list(run.history)[:3] == ["time", "step", "dt"]
    assert {"kinetic_energy", "internal_energy", "energy_error", "momentum_z", "front"} < set(run.history)
    assert run.history["front"][-1] == run.fields("gas")["position"][:, 0].max()


def test_fields_are_those_of_the_nearest_frame(tmp_path):
    run = run_case(free_flight(), tmp_path / "run", report=False)
    start = FakeSimulation(free_flight()).bodies[0].frame()
    for name, values in run.fields("gas", 0.1).items():
        assert np.array_equal(values, start[name])


def test_a_body_that_the_run_does_not_have_is_named_with_those_it_has(tmp_path):
    run = run_case(free_flight(), tmp_path / "run", report=False)
    for ask in (run.fields, run.times, run.cells, run.triangles):
        with pytest.raises(UsageError, match=r"has no body `nosuch`; available: gas, block"):
            ask("nosuch")


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda run: run.history["tme"], r"the history of the run in .* has no column `tme`; available: time, .*mean `time`\?"),
        (lambda run: run.units["tme"], "has no column `tme`; available: time"),
        (lambda run: run.summary["stps"], r"summary.json has no entry `stps`; available: case, .*mean `steps`\?"),
        (lambda run: run.summary["conservation"]["mas"], r"summary.json has no entry `mas`; available: .*mean `mass`\?"),
        (lambda run: run.metrics["order"], "the run in .* has no metric `order`; available: none"),
        (
            lambda run: run.fields("gas")["velocty"],
            r"body gas of the run in .* has no field `velocty`; available: .*`velocity`\?",
        ),
        (
            lambda run: run.fields("gas", 0.5, ("position", "velocty")),
            r"has no field `velocty`; available: .*mean `velocity`\?",
        ),
        (lambda run: run.fields("gas", names=("velocty",)), "has no field `velocty`"),
        (lambda run: run.fields("gas", names="velocty"), "has no field `velocty`"),
        (lambda run: run.fields("block", names=["position"])["mass"], "has no field `mass`; available: position$"),
        (lambda run: run.times("ga"), r"has no body `ga`; available: gas, block\n    did you mean `gas`\?"),
    ],
)
def test_names_that_are_not_there_are_told_with_those_that_are(tmp_path, ask, words):
    with pytest.raises(UnknownName, match=f"(?s){words}"):
        ask(run_case(free_flight(), tmp_path / "run", report=False))


def test_a_single_name_needs_no_list(tmp_path):
    run = run_case(free_flight(), tmp_path / "run", report=False)
    assert list(run.fields("gas", names="mass")) == ["mass"]


@pytest.mark.parametrize("time", [-1.0, -0.126, 1.126, 5.0])
def test_a_time_beyond_the_frames_is_told_the_first_and_the_last(tmp_path, time):
    run = run_case(free_flight(), tmp_path / "run", report=False)
    with pytest.raises(UsageError, match=r"body gas has no frame near t = .*; its first is at 0 s, its last at 1 s"):
        run.fields("gas", time)


def test_half_an_interval_beyond_the_frames_is_near_enough(tmp_path):
    run = run_case(free_flight(), tmp_path / "run", report=False)
    assert np.array_equal(run.fields("gas", 1.125)["position"], run.fields("gas")["position"])
    assert np.array_equal(run.fields("gas", -0.125)["position"], run.fields("gas", 0.0)["position"])


def test_a_run_is_finished_at_the_end_of_its_case_only(tmp_path, fake, monkeypatch):
    out = tmp_path / "run"
    assert not run_case(free_flight(), out, until=0.3, report=False).finished
    assert resume_case(out, report=False).finished
    monkeypatch.setattr(fake, "breaks_at", 3)
    with pytest.raises(RunStopped):
        run_case(free_flight(), out, report=False)
    run = Run(out)
    assert not run.finished
    assert run.metrics == {}


def test_without_a_folder_the_results_live_as_long_as_the_run(tmp_path):
    run = run_case(free_flight(), report=False)
    out = run.out
    assert run.summary["steps"] == 34
    del run
    assert not out.exists()


def test_a_second_run_replaces_the_first(tmp_path):
    run_case(free_flight(), tmp_path / "run")
    run = run_case(free_flight(**{"time.end": 0.5}), tmp_path / "run", report=False)
    assert run.summary["end_time"] == 0.5
    assert not (run.out / "report.html").exists()


def test_a_folder_with_other_things_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(UsageError, match="contains files that do not belong to a run"):
        run_case(free_flight(), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize("until", [0.1, 0.3, 0.5, 0.99])
def test_stopped_early_and_resumed_ends_in_the_same_bits(tmp_path, expected, until):
    early = run_case(free_flight(), tmp_path / "run", until=until, report=False)
    assert until <= early.summary["end_time"] < 1.0
    assert early.times("gas")[-1] == early.history["time"][-1] == early.summary["end_time"]
    resume_case(tmp_path / "run", report=False)
    assert results(tmp_path / "run") == expected


def test_stopped_early_again_and_again(tmp_path, expected):
    run_case(free_flight(), tmp_path / "run", until=0.2, report=False)
    for until in (0.2, 0.4, 0.4, 0.7):
        resume_case(tmp_path / "run", until=until, report=False)
    resume_case(tmp_path / "run", report=False)
    assert results(tmp_path / "run") == expected


def test_resuming_a_finished_run_changes_nothing(tmp_path, expected):
    run_case(free_flight(), tmp_path / "run", report=False)
    resume_case(tmp_path / "run", report=False)
    assert results(tmp_path / "run") == expected


def test_resuming_from_the_checkpoint_before_a_damaged_one(tmp_path, expected):
    run = run_case(free_flight(**OFTEN), tmp_path / "run", report=False)
    newest = newest_checkpoint(run.out)
    newest.write_bytes(newest.read_bytes()[:-1])
    with pytest.warns(UserWarning, match="damaged"):
        resume_case(run.out, report=False)
    assert results(run.out) == expected


def newest_checkpoint(out):
    return max((out / "checkpoint").glob("*.npz"), default=None)


def test_killed_at_any_moment_and_resumed_ends_in_the_same_bits(tmp_path, expected):
    out, generator = tmp_path / "run", np.random.default_rng(11)
    for attempt in range(12):
        before = newest_checkpoint(out)
        command = go_on if (out / "case.toml").exists() else begin_with_a_checkpoint_each_step
        with killed_at_last(command, out) as process:
            while attempt % 3 and newest_checkpoint(out) == before and process.is_alive():
                time.sleep(0.001)  # others are killed while they set up
            time.sleep(0.04 * generator.random())
    assert newest_checkpoint(out)
    resume_case(out, report=False)
    assert results(out) == expected


def test_resuming_where_there_is_no_run_is_told(tmp_path):
    with pytest.raises(UsageError, match=r"contains no run: it has no case\.toml"):
        resume_case(tmp_path)


def test_a_run_that_stops_itself_leaves_a_forensic_dump(tmp_path, fake, monkeypatch):
    monkeypatch.setattr(fake, "breaks_at", 9)
    with pytest.raises(RunStopped, match="point 7"):
        run_case(free_flight(), tmp_path / "run", report=False)
    failure = json.loads((tmp_path / "run/forensics/failure.json").read_text())
    assert failure["message"] == "point 7 of gas is lost"
    assert (failure["step"], failure["body"], failure["point"]) == (9, "gas", 7)
    with np.load(tmp_path / "run/forensics/state.npz") as dump:
        assert dump["gas/position"].shape == (80, 3)
    run = Run(tmp_path / "run")
    assert not run.finished
    assert run.stopped == failure
    assert run.summary["steps"] == 9
    assert run.metrics == {}


def test_a_run_that_stops_itself_has_a_report(tmp_path, fake, monkeypatch):
    monkeypatch.setattr(fake, "breaks_at", 9)
    with pytest.raises(RunStopped) as stopped:
        run_case(free_flight(), tmp_path / "run")
    page = (tmp_path / "run/report.html").read_text()
    assert "the run stopped with an error" in page
    assert "point 7 of gas is lost" in page
    assert (tmp_path / "run/figures/where_it_stopped.png").is_file()
    assert stopped.value.__notes__ == [f"Curves and last pictures of the run: {tmp_path / 'run/report.html'}"]
    monkeypatch.setattr(fake, "breaks_at", None)
    assert resume_case(tmp_path / "run").finished
    assert not (tmp_path / "run/figures/where_it_stopped.png").exists()
    assert "stopped" not in (tmp_path / "run/report.html").read_text()


def test_the_report_speaks_of_a_ring_where_there_is_one(tmp_path, fake, monkeypatch):
    monkeypatch.setattr(fake, "breaks_at", 9)
    with pytest.raises(RunStopped):
        run_case(free_flight(), tmp_path / "run")
    assert "the ring marks the point" in (tmp_path / "run/report.html").read_text()
    failure = tmp_path / "run/forensics/failure.json"
    failure.write_text(json.dumps({"message": "no rest", "step": 9, "time": 0.27}))
    page = write_report(tmp_path / "run").read_text()
    assert "The state at which the run stopped with an error." in page
    assert "the ring marks the point" not in page


def test_curves_reach_the_stop_where_all_of_the_row_is_known(tmp_path, fake, monkeypatch, expected):
    monkeypatch.setattr(fake, "breaks_at", 9)
    for balanced, last in ((True, 0.27), (False, 0.21)):
        monkeypatch.setattr(FakeBudget, "is_complete", balanced)
        out = tmp_path / f"run-{balanced}"
        with pytest.raises(RunStopped):
            run_case(free_flight(**OFTEN), out, report=False)
        assert Run(out).history["time"][-1] == pytest.approx(last)
    monkeypatch.setattr(fake, "breaks_at", None)
    resume_case(tmp_path / "run-True", report=False)
    assert results(tmp_path / "run-True") == expected


def test_a_row_without_numbers_is_not_written_at_a_stop(tmp_path, fake, monkeypatch):
    monkeypatch.setattr(fake, "breaks_at", 9)
    monkeypatch.setattr(fake, "momentum", lambda self: np.full(3, np.nan if self.n_steps == 9 else 0.0))
    with pytest.raises(RunStopped):
        run_case(free_flight(), tmp_path / "run", report=False)
    assert Run(tmp_path / "run").history["time"][-1] == pytest.approx(0.21)


def test_a_failure_with_values_that_are_no_numbers_is_strict_json(tmp_path, fake, monkeypatch):
    monkeypatch.setattr(fake, "breaks_at", 9)
    monkeypatch.setattr(fake, "place", {"state": {"position": [np.nan, 1.0], "speed": np.inf}})
    with pytest.raises(RunStopped):
        run_case(free_flight(), tmp_path / "run", report=False)
    text = (tmp_path / "run/forensics/failure.json").read_text()
    assert json.loads(text, parse_constant=pytest.fail)["state"] == {"position": [None, 1.0], "speed": None}


@pytest.mark.slow
def test_a_run_that_was_killed_has_a_report_of_what_there_is(tmp_path):
    out = tmp_path / "run"
    run_case(free_flight(), out, until=0.5)
    for name in ("summary.json", "report.html"):
        (out / name).unlink()
    page = write_report(out).read_text()
    assert "Interrupted or killed at 0.51 s of 1 s" in page
    assert "pellucid resume" in page


def test_a_full_disk_ends_in_a_message_and_the_run_goes_on_later(tmp_path, expected):
    out = tmp_path / "run"
    run_case(free_flight(), out, until=0.2, report=False)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (600, limits[1]))  # as a disk with no more room
    try:
        with pytest.raises(OutputError, match="Free disk space, then run `pellucid resume"):
            resume_case(out, report=False)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    resume_case(out, report=False)
    assert results(out) == expected


@pytest.mark.parametrize(("name", "what"), [("history.csv", "rows"), ("fields/gas.vtkhdf", "frames")])
def test_a_file_that_was_changed_since_its_checkpoint_is_told_and_nothing_is_cut(tmp_path, name, what):
    out = tmp_path / "run"
    run = run_case(free_flight(), out, until=0.5, report=False)
    path, old = out / name, (b"0.12" if what == "rows" else run.fields("gas", 0.27)["velocity"][3].tobytes())
    data = path.read_bytes()
    assert data.count(old) >= 1
    changed = data.replace(old, old[:-1] + bytes([old[-1] ^ 1]), 1)
    path.write_bytes(changed)
    with pytest.raises(OutputError, match=rf"was changed: its first \d {what} are not those written before the checkpoint"):
        resume_case(out)
    assert path.read_bytes() == changed
    path.write_bytes(data)
    assert resume_case(out, report=False).finished


def test_what_a_killed_process_left_before_the_case_was_written_is_no_obstacle(tmp_path):
    (tmp_path / "run.lock").touch()
    (tmp_path / ".case.toml.writing").write_text("schema =")
    assert run_case(free_flight(), tmp_path, report=False).summary["steps"] == 34


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"until": -1.0}, "until = -1.0 must be a positive time"),
        ({"until": 99.0}, r"until = 99.0 s is later than the end of the case, time.end = 0.2 s\.\n .* set a later time.end"),
        ({"threads": 0}, "threads = 0 must be a whole number from 1 to"),
        ({"threads": "two"}, "threads = 'two' must be a whole number"),
        ({"threads": 100_000}, "threads = 100000 must be a whole number"),
    ],
)
def test_arguments_that_make_no_sense_are_refused_before_anything_is_written(tmp_path, more, words):
    with pytest.raises(UsageError, match=words):
        pellucid.run(pellucid.load("basics/sod"), tmp_path / "run", **more)
    assert not (tmp_path / "run").exists()


def test_a_run_is_not_resumed_until_after_its_end(tmp_path):
    run_case(free_flight(), tmp_path, until=0.3, report=False)
    with pytest.raises(UsageError, match=r"until = 2\.0 s is later than the end of the case, time\.end = 1\.0 s"):
        resume_case(tmp_path, until=2.0, report=False)
    longer = resume_case(tmp_path, until=1.1, settings={"time.end": 1.2}, report=False)
    assert 1.1 <= longer.summary["end_time"] < 1.2


def test_what_a_killed_process_left_before_the_case_is_told_at_a_resume(tmp_path):
    (tmp_path / "run.lock").touch()
    words = r"ended before it wrote anything\n    Run it again: `pellucid run CASE --out "
    with pytest.raises(UsageError, match=words):
        resume_case(tmp_path)


def test_a_folder_that_is_not_there_says_so(tmp_path):
    with pytest.raises(UsageError, match="does not exist"):
        _ = pellucid.Run(tmp_path / "nosuch").summary
