import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pellucid import catalogue
from pellucid.case import loads
from pellucid.cli import app


def test_list_shows_every_case_with_its_title() -> None:
    result = CliRunner().invoke(app, ["list"])
    assert result.exit_code == 0
    for name in catalogue.ids():
        assert f"{name} " in result.stdout
        assert loads(catalogue.text(name)).title in result.stdout


@pytest.mark.parametrize("name", catalogue.ids())
def test_what_show_prints_is_valid_as_a_file(name: str, tmp_path: Path) -> None:
    shown = CliRunner().invoke(app, ["show", name])
    file = tmp_path / "copy.toml"
    file.write_text(shown.stdout, encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 0
    assert "is valid" in result.stdout
    assert CliRunner().invoke(app, ["show", str(file)]).stdout == shown.stdout


def test_schema_prints_json() -> None:
    schema = json.loads(CliRunner().invoke(app, ["schema"]).stdout)
    assert schema["title"] == "Case"


def test_a_gallery_case_knows_its_module() -> None:
    module = catalogue.module("gan2011/shock-tube")
    assert module is not None
    assert callable(module.metrics)
    assert catalogue.module("") is None
