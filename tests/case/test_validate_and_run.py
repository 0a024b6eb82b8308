"""What `validate` accepts, `run` accepts; what it refuses, `run` refuses with the same message."""

import runpy
import warnings
from pathlib import Path

import numpy as np
import pytest
from mistakes import MISTAKES
from typer.testing import CliRunner

from pellucid.cli import app
from pellucid.running import launch

TESTS = Path(__file__).parents[1]
SAMPLES = sorted((Path(__file__).parent / "samples").glob("*.toml"))
MESHES = [file for file in (Path(__file__).parent / "samples").iterdir() if file.suffix in (".obj", ".stl")]
LONG = {
    "belt",
    "indent",
    "needle-boundary",
    "oocyte-dynamic",
    "oocyte-eighth",
    "slit",
    "burst",
    "ball",
    "ballquarter",
}
"""Whose kernels of the set-up take seconds to compile."""
TANK = """
schema = 1
title = "A stiff tank blows down through a vent"
time = { end = 6, step = 0.005 }
[[body]]
name = "tank"
kind = "membrane-elements"
surface = { box = { lower = [0, 0, 0], upper = [1, 1, 1], points = [3, 3, 3] } }
thickness = "1 mm"
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e9, poisson_ratio = 0.3 }
[[motion]]
name = "stiff"
body = "tank"
hold = ["x", "y", "z"]
[[enclosed]]
name = "air"
body = "tank"
outside = "1 bar"
gas = { pressure = "10 bar", temperature = 300 }
[[enclosed.vent]]
area = "10 cm^2"
coefficient = 0.8
"""
SOLID = """
schema = 1
title = "A block on its own nodes"
time = { end = 1 }
[[body]]
name = "block"
kind = "meshless-solid"
mesh = { box = { lower = [0, 0, 0], upper = [0.1, 0.1, 0.1], cells = [2, 2, 2] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = "20 kPa", poisson_ratio = 0.3 }
[[support]]
where = { box = { lower = [-1, -1, -1], upper = [1, 1, 1e-9] } }
[[motion]]
name = "press"
body = "block"
part = { normal = [0, 0, 1] }
displacement = { z = { kind = "ramp", distance = "-4 mm", duration = 1 } }
"""
FLOW = """
schema = 1
title = "A channel"
grid = { lower = [0, 0, 0], upper = [4, 2, 0], cell = 0.25 }
time = { end = 1 }
[[body]]
name = "water"
shape = { box = { lower = [0, 0, 0], upper = [4, 2, 0] } }
points_per_cell = [2, 2, 1]
material = { kind = "fluid", density = 1, viscosity = 1, eos = { kind = "tait", sound_speed = 20 } }
[[support]]
where = ["y-lower", "y-upper"]
[[inflow]]
where = "x-lower"
body = "water"
velocity = 1
[[outflow]]
where = "x-upper"
"""
REFUSED = {
    "a fixed step, a membrane that encloses a gas": (TANK, "step = 0.005", "step = 0.005", "largest stable step"),
    "a fixed step that only the gas does not allow": (TANK, "step = 0.005", "step = 3.4e-4", "largest stable step"),
    "a fixed step of a meshless solid": (SOLID, "end = 1", "end = 1, step = 0.5", "largest stable step"),
    "more steps than a run can take": (SOLID, "end = 1", "end = 1e15", "requires more than"),
    "a support that holds nothing": (SOLID, "[-1, -1, -1], upper = [1, 1, 1e-9]", "[5, 5, 5], upper = [6, 6, 6]", "support"),
    "a motion of no node": (SOLID, "{ normal = [0, 0, 1] }", "{ box = { lower = [5, 5, 5], upper = [6, 6, 6] } }", "part"),
    "a pressure at a face that no fluid reaches": (
        FLOW.replace("upper = [4, 2, 0] } }", "upper = [2, 2, 0] } }"),
        'where = "x-upper"',
        'where = "x-upper"\npressure = 1',
        "lies in the layer of cells at the face x-upper",
    ),
    "an opening that a support closes": (
        FLOW,
        "[[inflow]]",
        "[[support]]\nwhere = { box = { lower = [-1, -1, -1], upper = [0.1, 3, 1] } }\n[[inflow]]",
        "nothing can flow through",
    ),
    "two motions of one node": (
        SOLID,
        "[[motion]]",
        '[[motion]]\nname = "other"\nbody = "block"\nhold = ["z"]\npart = { normal = [0, 0, 1] }\n[[motion]]',
        "",
    ),
}


class SetUpDone(Exception):
    """A run has reached its first step."""


@pytest.fixture
def judged(monkeypatch, tmp_path):
    """Returns the judgement of a command on a file: its exit status and what it prints as an error."""

    def stop(*_args, **_more):
        raise SetUpDone

    monkeypatch.setattr(launch, "_finish", stop)

    def judge(command: str, file: Path) -> tuple[int, str]:
        more = ["--out", str(tmp_path / "run"), "--threads", "1"] if command == "run" else []
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = CliRunner().invoke(app, [command, str(file), *more])
        if isinstance(result.exception, SetUpDone):
            return 0, ""
        assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
        errors = result.stderr.partition("pellucid: ")[2]
        return result.exit_code, errors

    return judge


def agreed(judged, file: Path) -> tuple[int, str]:
    """The judgement that both commands make."""
    by_validate, by_run = judged("validate", file), judged("run", file)
    assert by_validate == by_run
    return by_validate


def write_inputs(folder: Path) -> None:
    """Write the amplitudes and meshes that some of the samples read."""
    for mesh in MESHES:
        (folder / mesh.name).write_bytes(mesh.read_bytes())
    for name, share in (("cos16.csv", lambda t: np.cos(16.0 * t)), ("pump.csv", lambda t: 0.5 - 0.5 * np.cos(np.pi * t))):
        rows = (f"{t:.4f},{share(t):.6f}" for t in np.linspace(0.0, 2.0, 201))
        (folder / name).write_text("\n".join(["time,share", *rows]) + "\n")


@pytest.mark.parametrize(
    "sample", [pytest.param(each, id=each.stem, marks=[pytest.mark.slow] * (each.stem in LONG)) for each in SAMPLES]
)
def test_both_judge_a_sample_alike(judged, sample, tmp_path):
    write_inputs(tmp_path)
    file = tmp_path / sample.name
    file.write_bytes(sample.read_bytes())
    agreed(judged, file)


@pytest.mark.slow
@pytest.mark.parametrize(
    "sample", [pytest.param(each, id=each.stem, marks=[pytest.mark.full] * (each.stem == "oocyte")) for each in SAMPLES]
)
def test_what_validate_accepts_takes_its_first_step(sample, tmp_path):
    write_inputs(tmp_path)
    file = tmp_path / sample.name
    file.write_bytes(sample.read_bytes())
    if CliRunner().invoke(app, ["validate", str(file)]).exit_code == 2:
        return
    tail = ["--until", "1e-12", "--no-report", "--threads", "1", "--out", str(tmp_path / "run")]
    accepted = {0}
    if "[steady]" in sample.read_text():
        accepted.add(3)  # a relaxation that ends without its steady state
        tail += ["--set", "steady.most_steps=100", "--set", "steady.tolerance=0.1", "--set", "steady.load_steps=1"]
    result = CliRunner().invoke(app, ["run", str(file), *tail])
    assert result.exit_code in accepted, result.output


@pytest.mark.parametrize("name", REFUSED)
def test_what_only_the_set_up_finds_is_refused_by_both(judged, name, tmp_path):
    text, before, after, words = REFUSED[name]
    assert before in text
    file = tmp_path / "my.toml"
    file.write_text(text.replace(before, after))
    status, message = agreed(judged, file)
    assert status == 2
    assert words in message
    assert f"{file}:" in message, "the line is named"


@pytest.mark.parametrize("mistake", MISTAKES)
def test_both_name_a_mistake_alike(judged, mistake, text, tmp_path):
    before, after, _, _ = MISTAKES[mistake]
    file = tmp_path / "my.toml"
    file.write_text(after if before is None else text.replace(before, after, 1), encoding="utf-8")
    assert agreed(judged, file)[0] == 2


@pytest.mark.parametrize(
    "module", ["conditions/test_outflow.py", "conditions/test_inflow_mistakes.py", "case/test_case_surfaces.py"]
)
def test_both_name_the_mistakes_of_other_tests_alike(judged, module, tmp_path):
    tables = runpy.run_path(str(TESTS / module))
    file = tmp_path / "my.toml"
    for before, after, *_ in tables["MISTAKES"].values():
        file.write_text(tables["TEXT"].replace(before, after, 1), encoding="utf-8")
        assert agreed(judged, file)[0] == 2


def test_a_large_case_is_judged_from_its_models_and_that_is_said(monkeypatch, tmp_path):
    file = tmp_path / "my.toml"
    file.write_text(SOLID)
    monkeypatch.setattr(launch, "LARGE", launch.LARGE._replace(points=10))
    found = CliRunner().invoke(app, ["validate", str(file)])
    assert found.exit_code == 0
    assert launch.NOT_SET_UP in found.stdout
    assert "limited by body `block`; the time step is computed when the run starts" in found.stdout


def test_the_remedy_of_a_fixed_step_is_enough(judged, tmp_path):
    file = tmp_path / "my.toml"
    file.write_text(TANK)
    step = agreed(judged, file)[1].partition("at most ")[2].split()[0]
    file.write_text(TANK.replace("step = 0.005", f"step = {step}"))
    assert agreed(judged, file) == (0, "")
