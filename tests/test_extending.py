"""The examples of the page on extending work: its files, run from its case and from a script."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from registries import forgotten_afterwards
from typer.testing import CliRunner

from pellucid import load, loads
from pellucid.case import Case, json_schema
from pellucid.cli import app
from pellucid.results.storage.run import Run
from pellucid.simulation.simulation import Simulation

PAGE = (Path(__file__).parents[1] / "docs" / "extending.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"`(\w+\.py)`:\n```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL))
(CASE,) = re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
PLAIN = "".join(line for line in CASE.splitlines(True) if not line.startswith("extensions"))
SCRIPT = """
import drag, probes, vortex, viscoelastic
import pellucid

run = pellucid.run(pellucid.load("plain.toml"), out="from_script", until=0.04, report=False)
"""


@pytest.fixture(autouse=True)
def file(tmp_path: Path) -> Iterator[Path]:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "block.toml").write_text(CASE, encoding="utf-8")
    (tmp_path / "plain.toml").write_text(PLAIN, encoding="utf-8")
    with forgotten_afterwards():
        yield tmp_path / "block.toml"


def test_every_block_of_the_page_is_tested() -> None:
    assert list(FILES) == ["viscoelastic.py", "logarithmic.py", "drag.py", "vortex.py", "probes.py"]
    assert PAGE.count("```") == 2 * (len(FILES) + 1)


def test_the_case_is_valid_with_its_files_and_not_without(file: Path) -> None:
    assert CliRunner().invoke(app, ["validate", str(file)]).exit_code == 0


def test_the_case_is_not_valid_without_its_files(file: Path) -> None:
    message = CliRunner().invoke(app, ["validate", str(file.with_name("plain.toml"))]).stderr
    for words in (
        'body.block.material.kind = "viscous-solid"',
        'must be one of "fluid", "linear-elastic", "neo-hookean"',
        'body.block.initial.0.kind = "vortex"',
        'load.0.kind = "drag"',
        'must be one of "body-force"',
        'probe.spread.reduce = "root-mean-square"',
        'must be one of "mean", "max", "min", "sum", "count", "nearest", "point"',
    ):
        assert words in message


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ('viscosity = "20 Pa s"', "viscosity = -1", ["body.block.material.viscosity = -1", "at least 0 Pa*s"]),
        ('viscosity = "20 Pa s"', 'viscosity = "20 m"', ["body.block.material.viscosity", "[length]"]),
        ("rate = 5", "rat = 5", ["load.0.rat", "did you mean `rate`?"]),
        ('body = "block"\nrate', 'body = "blok"\nrate', ["load.0.body", "did you mean `block`?"]),
        ("radius = 0.3", "radius = 0", ["body.block.initial.0.radius = 0", "greater than 0 m"]),
        ('"speed"', '"sped"', ["probe.spread.quantity", "did you mean `speed`?"]),
        ('quantity = "speed"', 'component = "x"\nquantity = "speed"', ["speed has no components"]),
    ],
)
def test_mistakes_are_told_as_for_the_kinds_of_the_package(before: str, after: str, words: list[str], file: Path) -> None:
    assert before in CASE
    file.write_text(CASE.replace(before, after))
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 2
    for word in words:
        assert word in result.stderr


def test_the_schema_tells_them(file: Path) -> None:
    case = load(file)
    definitions = json_schema()["$defs"]
    assert definitions["Drag"]["properties"]["rate"]["unit"] == "1/s"
    assert {"KelvinVoigtMaterial", "Vortex"} <= set(definitions)
    assert "root-mean-square" in definitions["Probe"]["properties"]["reduce"]["enum"]
    assert case.with_settings({"body.block.material.kind": "neo-hookean"}).body[0].material.kind == "neo-hookean"


def test_the_schema_of_a_case_is_printed_with_them(file: Path) -> None:
    plain = CliRunner().invoke(app, ["schema"]).stdout
    assert "Drag" not in json.loads(plain)["$defs"]
    assert "Drag" in json.loads(CliRunner().invoke(app, ["schema", str(file)]).stdout)["$defs"]


LIQUID = """
schema = 1
title = "A plug of liquid that is compressed"
extensions = ["logarithmic.py"]
[grid]
lower = [0, 0, 0]
upper = [1, 0, 0]
cell = 0.1
[time]
end = 0.02
[[body]]
name = "plug"
shape = { box = { lower = [0, 0, 0], upper = [0.8, 0, 0] } }
velocity = [-2, 0, 0]
material = { kind = "fluid", density = 900, pressure = 5e4, eos = { kind = "logarithmic", bulk_modulus = 1e6 } }
[[support]]
where = "x-lower"
fix = "normal"
"""


def test_the_liquid_has_the_pressure_and_sound_speed_of_its_equation(file: Path) -> None:
    path = file.with_name("plug.toml")
    path.write_text(LIQUID, encoding="utf-8")
    case = load(path)
    assert case.body[0].material.wave_speeds()[0] == pytest.approx(np.sqrt(1e6 / 900))
    sim = Simulation(case, threads=1)
    while not sim.clock.finished(None):
        sim.step()
    density, pressure = (sim.bodies[0].field(name) for name in ("density", "pressure"))
    assert np.ptp(density) > 20.0
    assert pressure == pytest.approx(5e4 + 1e6 * np.log(density / 900), rel=1e-9)


def test_the_vortex_turns_the_block(file: Path) -> None:
    body = load(file).body[0]
    velocity = body.initial_velocity(np.array([[0.3, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.0]]))
    assert np.allclose(velocity, [[0, 0.5, 0], [-0.5, 0, 0], [0, 0, 0]])


def test_the_same_from_a_script_that_holds_the_files_itself() -> None:
    for text in FILES.values():
        exec(text, {"__name__": "script"})
    case = loads(PLAIN)
    assert type(case.body[0].material).__module__ == "script"
    assert Case.model_validate(case.to_data()) == case


def test_the_case_runs_and_resumes_and_a_script_gives_the_same(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiled through the command line, where the file of the law is a module of its own; as plain Python from a script."""
    monkeypatch.chdir(file.parent)
    arguments = ["run", "block.toml", "--until", "0.04", "--out", "whole"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.stderr
    whole = Run("whole").history
    assert whole["time"][-1] == pytest.approx(0.04, abs=0.01)
    assert whole["drag_work"][-1] < 0.0
    assert whole["internal_energy"][-1] > 0.0
    assert whole["spread"][0] == pytest.approx(rms_of_vortex(file), rel=1e-12)
    assert whole["spread"][-1] < whole["spread"][0]
    assert "viscous_work" in Run("whole").fields("block")

    for until, command in (("0.02", ["run", "block.toml", "--out", "parts"]), ("0.04", ["resume", "parts"])):
        assert CliRunner().invoke(app, [*command, "--until", until]).exit_code == 0
    assert (file.parent / "parts" / "history.csv").read_bytes() == (file.parent / "whole" / "history.csv").read_bytes()
    (file.parent / "drag.py").write_text(FILES["drag.py"] + "\n")
    refused = CliRunner().invoke(app, ["resume", "parts", "--until", "0.05"])
    assert refused.exit_code == 2
    assert "drag.py has changed since the run started" in refused.stderr

    (file.parent / "script.py").write_text(SCRIPT, encoding="utf-8")
    subprocess.run([sys.executable, "script.py"], check=True, env=os.environ | {"NUMBA_DISABLE_JIT": "1"})
    history = Run("from_script").history
    for name, column in whole.items():
        assert history[name] == pytest.approx(column, rel=1e-9, abs=1e-12), name


def rms_of_vortex(file: Path) -> float:
    """Return the root mean square of the initial speed of the block in a case file [m/s]."""
    body = load(file).body[0]
    places = np.linspace(-0.5 + 1 / 16, 0.5 - 1 / 16, 8)
    x, y = (axis.ravel() for axis in np.meshgrid(places, places))
    return float(np.sqrt(np.mean(np.sum(body.initial_velocity(np.stack([x, y, 0.0 * x], axis=1)) ** 2, axis=1))))
