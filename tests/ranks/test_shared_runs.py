"""Several processes that share a run: the bits of one, and how they end."""

import json
import os
import signal
import subprocess
import sys
import time
from functools import cache
from pathlib import Path

import numba
import pytest

from pellucid.results.storage import history

LAUNCHER = Path(sys.executable).parent / "mpiexec"
STEPS = Path(__file__).with_name("shared_steps.py")
PATIENT = os.environ | {"OMP_WAIT_POLICY": "PASSIVE", "HYDRA_LAUNCHER": "fork"}  # there may be more threads than cores
pytestmark = [
    pytest.mark.skipif(not LAUNCHER.is_file(), reason="the extra mpi is not installed"),
    pytest.mark.skipif(numba.config.DISABLE_JIT, reason="takes minutes in plain Python"),
]
FEW = [
    "basics/dam-break:16",  # APIC, quadratic B-splines
    f"{STEPS.with_name('tower.toml')}:6",  # at rest under gravity, which goes across the rows
    f"{STEPS.with_name('fold.toml')}:40",  # a membrane that touches itself
]
CASES = [
    *FEW,
    "gan2011/piezo-icsi:6",  # membrane points with damage, prescribed motions, absorbing faces
    "lian2014/water-drop:11",  # elements on nodes of their own, contact on the grid
    "lian2014/gas-expansion:16",  # elements that share a velocity field; two rows of slabs
    "basics/rolling-discs:6",  # contact of surfaces with friction, a rigid body
    "basics/hydrostatic-column:11",  # mean pressures of full cells
    "benet2015/vesicle-in-shear:11",  # a film on the grid
    f"{STEPS.with_name('wall.toml')}:6",  # a fluid at a wall, of which some processes have no points
    f"{STEPS.with_name('channel.toml')}:30",  # a periodic axis across the rows, contact across its seam, a driven fluid
    f"{STEPS.with_name('stream.toml')}:20",  # a liquid with implicit pressure and a membrane in it
    f"{STEPS.with_name('capsule.toml')}:8",  # an enclosed volume, whose pressure is solved for with that of the liquid
    f"{STEPS.with_name('bag.toml')}:6",  # contents of membranes, pressure in a region
    f"{STEPS.with_name('drop.toml')}:30",  # surface tension, at a wall; consistent masses
    f"{STEPS.with_name('paddle.toml')}:130",  # rigid bodies in a fluid, across the rows, and angular momentum
    f"{STEPS.with_name('duct.toml')}:40",  # points that come in and leave, led and pushed
    f"{STEPS.with_name('blood.toml')}:30",  # a yield stress with implicit pressure, in and out through faces
    f"{STEPS.with_name('vessel.toml')}:20",  # a wall at the surface of a region, at a plane of symmetry
    f"{STEPS.with_name('slit.toml')}:12",  # walls of regions, two liquids with implicit pressure and a membrane
    f"{STEPS.with_name('cavity.toml')}:15",  # even points in a closed box with implicit pressure
    f"{STEPS.with_name('shelf.toml')}:40",  # clamps of membranes that bend, at a support and by a motion
    f"{STEPS.with_name('press.toml')}:2",  # a search for equilibria, with a rigid tool in contact
]


def shared(processes, *arguments, of=STEPS):
    command = [LAUNCHER, "-n", str(processes), sys.executable, *map(str, (of, *arguments))]
    return subprocess.run(command, env=PATIENT, capture_output=True, text=True, timeout=250, check=False)


@cache
def alone(cases):
    return json.loads(shared(1, "1,1", *cases).stdout)


@pytest.mark.parametrize(
    ("processes", "ways", "cases"),
    [
        (3, "2,1+recut", tuple(FEW)),
        pytest.param(2, "1,2+recut", tuple(CASES), marks=pytest.mark.full),
        pytest.param(3, "2,1+recut", tuple(CASES), marks=pytest.mark.slow),
    ],
    ids=["3-few", "2-all", "3-all"],
)
def test_processes_and_threads_change_no_bit(processes, ways, cases):
    run = shared(processes, ways, *cases)
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
    assert found.keys() == alone(cases).keys()
    for case, known in found.items():
        assert known.pop("bytes") > 0
        built = known.pop("built")  # each process builds the points in its rows, but rigid tools as a whole
        assert built < (0.6 if case == "basics/dam-break" else 1.1) or case.endswith("press.toml")
        assert known == {name: alone(cases)[case][name] for name in known}, case


DAM = ["-m", "pellucid", "run", "basics/dam-break", "--quick", "--threads", "1", "--no-report"]


def processes_of(launcher):
    """The Python processes below a launcher."""
    parents = {}
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, rest = status.read_text().rsplit(")", 1)
        except OSError:
            continue
        parents[int(name.split(" ", 1)[0])] = int(rest.split()[1]), name.partition("(")[2]
    below = {launcher}
    for _ in range(3):
        below |= {pid for pid, (parent, _) in parents.items() if parent in below}
    return sorted(pid for pid in below if parents.get(pid, (0, ""))[1].startswith("python"))


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
def test_one_killed_ends_all_and_another_number_goes_on(tmp_path):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    short = ["--set", "output.checkpoint=0.2", "--set", "time.end=0.04"]
    subprocess.run([sys.executable, *DAM, *short, "--out", whole], check=True, capture_output=True)
    command = [LAUNCHER, "-n", "2", sys.executable, *DAM, *short, "--out", str(killed)]
    with subprocess.Popen(command, env=PATIENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as launcher:
        until = time.monotonic() + 120
        while not list(killed.glob("checkpoint/*.npz")):
            assert launcher.poll() is None, "it ended before it could be killed"
            assert time.monotonic() < until
            time.sleep(0.01)
        os.kill(processes_of(launcher.pid)[-1], signal.SIGKILL)
        assert launcher.wait(timeout=30) != 0
    assert not processes_of(launcher.pid)
    resume = ["-m", "pellucid", "resume", killed, "--ranks", "3", "--threads", "1", "--no-report"]
    resumed = subprocess.run([sys.executable, *map(str, resume)], env=PATIENT, capture_output=True, text=True, check=False)
    assert resumed.returncode == 0, resumed.stderr
    assert (killed / "history.csv").read_bytes() == (whole / "history.csv").read_bytes()
    assert history.read(killed / "history.csv")["time"][-1] >= 0.04


def test_a_fault_in_one_process_is_told_once(tmp_path):
    """The water leaves the grid on the right, where the last process has it."""
    case = tmp_path / "case.toml"
    case.write_text(LEAVES)
    command = ["-m", "pellucid", "run", case, "--ranks", "2", "--threads", "1", "--no-report", "--out", tmp_path / "run"]
    run = subprocess.run([sys.executable, *map(str, command)], env=PATIENT, capture_output=True, text=True, timeout=200)
    assert run.returncode == 3
    assert run.stderr.count("it left the grid") == 1
    assert (tmp_path / "run" / "forensics" / "failure.json").is_file()


def test_an_error_of_one_process_ends_all(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(FAILS)
    run = shared(2, of=script)
    assert run.returncode != 0
    assert run.stderr.count("the second one fails") == run.stderr.count("(process 1 of 2)") == 1


def test_a_run_that_one_process_alone_stops_ends(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(STOPS)
    run = shared(2, tmp_path / "run", of=script)
    assert run.returncode == 3
    assert run.stderr.count("only here") == run.stderr.count("(process 1 of 2)") == 1


def test_different_cases_are_no_run(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(DIFFERS)
    run = shared(2, tmp_path, of=script)
    assert run.returncode != 0
    assert "their cases, folders or end times differ" in run.stderr
    assert not list(tmp_path.glob("run*"))


def test_bad_input_is_told_once(tmp_path):
    run = subprocess.run(
        [LAUNCHER, "-n", "2", sys.executable, "-m", "pellucid", "run", "basics/dam-brake"],
        env=PATIENT,
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert run.returncode == 2
    assert run.stderr.count("dam-break") == 1


LEAVES = """
schema = 1
title = "A block leaves the grid"
[grid]
lower = [0, 0, 0]
upper = [3, 0.6, 0]
cell = 0.1
functions = "quadratic-bspline"
[time]
end = 1.0
transfer = "apic"
[[body]]
name = "block"
shape = { box = { lower = [0.3, 0.2, 0], upper = [2.5, 0.4, 0] } }
points_per_cell = [2, 2, 1]
velocity = [10.0, 0, 0]
material = { kind = "fluid", density = 1000.0, pressure = 0.0, eos = { kind = "tait", sound_speed = 15.0, exponent = 7 } }
"""
SHORT = """
import sys
import pellucid
from pellucid.ranks import group
from pellucid.ranks.domain import domain
group.PATIENCE = 1.0
domain.group.join()
case = pellucid.load("basics/dam-break").quick_variant().with_settings({"time.end": 0.002})
"""
STOPS = (
    SHORT
    + """
from pellucid.errors import RunStopped
from pellucid.simulation.simulation import Simulation
record = Simulation.record
def stop(simulation, dt):
    record(simulation, dt)
    if simulation.n_steps == 5 and domain.group.rank == 1:
        raise RunStopped("only here")
Simulation.record = stop
pellucid.run(case, sys.argv[1], threads=1)
"""
)
DIFFERS = (
    SHORT
    + """
pellucid.run(case, f"{sys.argv[1]}/run{domain.group.rank}", threads=1)
"""
)
FAILS = """
from pellucid.errors import UsageError
from pellucid.ranks import group
from pellucid.ranks.domain import domain
group.PATIENCE = 1.0
domain.group.join()
with domain.together():
    if domain.group.rank == 1:
        raise UsageError("the second one fails")
    domain.group.told(0, by=1)
"""
