"""Loops over the steps of a simulation that leave a run."""

import pytest

import pellucid
from pellucid.errors import RunStopped, UsageError

DISC = """
schema = 1
title = "A disc in flight"
[grid]
lower = [0, 0, 0]
upper = [4, 2, 0]
cell = 0.25
[time]
end = 0.2
step = 1e-3
[[body]]
name = "disc"
kind = "material-points"
shape = { sphere = { centre = [1, 1, 0], radius = 0.5 } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
velocity = [1, 0, 0]
[output]
frames = 0.1
history = 0.01
"""


def files(folder):
    return {path.name: path.read_bytes() for path in (folder / "history.csv", folder / "fields" / "disc.vtkhdf")}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return pellucid.run(pellucid.loads(DISC), tmp_path_factory.mktemp("loop") / "run", threads=1, report=False)


def test_a_loop_leaves_what_a_run_leaves(run, tmp_path):
    simulation = pellucid.Simulation(pellucid.loads(DISC), threads=1)
    times = [state.time for state in pellucid.recorded(simulation, tmp_path / "run")]
    assert len(times) == simulation.n_steps == run.summary["steps"]
    assert files(tmp_path / "run") == files(run.out)
    there = pellucid.Run(tmp_path / "run").summary
    assert there.keys() == run.summary.keys()
    assert there["end_time"] == run.summary["end_time"]


def test_a_loop_that_is_left_goes_on_with_resume(run, tmp_path):
    simulation = pellucid.Simulation(pellucid.loads(DISC), threads=1)
    for state in pellucid.recorded(simulation, tmp_path / "run"):
        if state.time > 0.123:
            break
    left = pellucid.Run(tmp_path / "run")
    assert left.history["time"][-1] == simulation.time
    assert left.summary["steps"] == simulation.n_steps
    pellucid.resume(tmp_path / "run", threads=1, report=False)
    assert files(tmp_path / "run") == files(run.out)


def test_an_error_in_the_loop_leaves_what_was_so_far(tmp_path):
    simulation = pellucid.Simulation(pellucid.loads(DISC), threads=1)
    loop = pellucid.recorded(simulation, tmp_path / "run")
    with pytest.raises(ZeroDivisionError):
        sum(1 / (state.n_steps - 50) for state in loop)
    loop.close()  # as the end of a script does
    assert pellucid.Run(tmp_path / "run").history["time"][-1] == pytest.approx(0.05)


def test_other_files_and_impossible_times_are_refused(tmp_path):
    simulation = pellucid.Simulation(pellucid.loads(DISC), threads=1)
    (tmp_path / "own.txt").write_text("mine")
    with pytest.raises(UsageError, match="files that do not belong to a run"):
        next(iter(pellucid.recorded(simulation, tmp_path)))
    with pytest.raises(UsageError, match="later than the end"):
        next(iter(pellucid.recorded(simulation, tmp_path / "run", until=1.0)))


def test_bodies_settle_before_a_loop_too():
    falling = pellucid.loads(DISC.replace("velocity = [1, 0, 0]", ""))
    case = falling.with_settings({"settle": {"most_steps": 10}, "gravity": [0, -10, 0]})
    with pytest.raises(RunStopped, match="settle"):
        next(iter(pellucid.Simulation(case, threads=1)))
