import json
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pellucid import catalogue
from pellucid.cli import app


def test_list_shows_every_case_with_its_title() -> None:
    result = CliRunner().invoke(app, ["list"])
    assert result.exit_code == 0
    for name in catalogue.ids():
        assert f"{name} " in result.stdout
        assert tomllib.loads(catalogue.text(name))["title"] in result.stdout


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if k % 6 == 0 else pytest.mark.slow) for k, name in enumerate(catalogue.ids())]
)
def test_what_show_prints_is_valid_as_a_file(name: str, tmp_path: Path) -> None:
    shown = CliRunner().invoke(app, ["show", name])
    file = tmp_path / "copy.toml"
    file.write_text(shown.stdout, encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 0
    assert "is valid" in result.stdout
    assert "warning" not in result.output
    assert "\nsteps: " in result.stdout
    assert "\ntime: " in result.stdout
    assert CliRunner().invoke(app, ["show", str(file)]).stdout == shown.stdout


SLIVER = """
schema = 1
title = "a sheet with a short edge"
[time]
end = 1
[[body]]
name = "sheet"
kind = "membrane-elements"
surface = { file = { path = "sheet.obj", closed = false } }
thickness = 0.01
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e4, poisson_ratio = 0.3 }
"""


def test_validate_warns_of_what_run_would_warn_of_for_the_same_reason(tmp_path: Path) -> None:
    """A row of triangles, one of which has an edge of a hundredth of the others."""
    n = 200
    places = [(x, y) for x in range(n) for y in (0.0, 1.0)]
    places[n] = (places[n - 2][0] + 0.01, 0.0)
    lines = [f"v {x} {y} 0" for x, y in places]
    lines += [f"f {k + 1} {k + 3} {k + 4}\nf {k + 1} {k + 4} {k + 2}" for k in range(0, 2 * n - 2, 2)]
    (tmp_path / "sheet.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    file = tmp_path / "case.toml"
    file.write_text(SLIVER, encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 0, result.output
    assert "is valid" in result.stdout
    assert "warning: the stable time step of body sheet is" in result.stderr
    assert f"(counted from 0, of {2 * n - 2})" in result.stderr


OVER_TISSUE = """
schema = 1
title = "a punch"
grid = { lower = [0, 0, 0], upper = [20, 20, 0], cell = 1 }
time = { end = 1 }
[[body]]
name = "tissue"
field = "tissue"
shape = { box = { lower = [1, 0, 0], upper = [19, 8, 1] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e4, poisson_ratio = 0.3 }
[[body]]
name = "punch"
field = "punch"
shape = { box = { lower = [9, HEIGHT, 0], upper = [11, 14, 1] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e9, poisson_ratio = 0.3 }
[[motion]]
name = "push"
body = "punch"
hold = ["x", "y", "z"]
"""


def test_validate_warns_of_a_coarse_indenter_and_refuses_one_within_the_tissue(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(OVER_TISSUE.replace("HEIGHT", "9"), encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 0, result.output
    assert "warning: the non-deforming body punch has a radius of 1 m where it can touch body tissue" in result.stderr
    file.write_text(OVER_TISSUE.replace("HEIGHT", "7"), encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 2
    assert "case.toml:" in result.stderr
    assert "start inside body" in result.stderr


def test_validate_foretells_the_steps_of_quick_and_changed_cases() -> None:
    quick = CliRunner().invoke(app, ["validate", "gan2011/shock-tube", "--quick"])
    assert "\nsteps: 1788 of 8e-05 s, time.step is 0.046 of the stable step of body `driver`: " in quick.stdout
    changed = CliRunner().invoke(app, ["validate", "gan2011/shock-tube", "--set", "time.step=1e-5"])
    assert "\nsteps: 14300 of 1e-05 s, " in changed.stdout
    wrong = CliRunner().invoke(app, ["validate", "gan2011/shock-tube", "--set", "time.step=1"])
    assert wrong.exit_code == 2
    assert "--set time.step=1" in wrong.stderr
    assert "the largest stable step at the start, of body driver: wave speed 1.183 m/s in cells" in wrong.stderr


def test_schema_prints_json() -> None:
    schema = json.loads(CliRunner().invoke(app, ["schema"]).stdout)
    assert schema["title"] == "Case"


def test_a_gallery_case_knows_its_module() -> None:
    module = catalogue.module("gan2011/shock-tube")
    assert module is not None
    assert callable(module.metrics)
    assert catalogue.module("") is None
