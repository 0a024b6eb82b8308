from pathlib import Path

import pytest
from typer.testing import CliRunner

from pellucid.case import load, loads, parse_setting, parse_value
from pellucid.case.settings import split_key
from pellucid.cli import app
from pellucid.errors import CaseError


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0.02", 0.02),
        ("3", 3),
        ("true", True),
        ("[1, 2]", [1, 2]),
        ('"usl"', "usl"),
        ("usl", "usl"),
        ("3 kPa", "3 kPa"),
        ("the 'wet' wall", "the 'wet' wall"),
        ('{ kind = "ideal-gas", gamma = 1.4 }', {"kind": "ideal-gas", "gamma": 1.4}),
    ],
)
def test_values_are_toml_or_else_plain_text(text: str, value: object) -> None:
    assert parse_value(text) == value


def test_keys_are_split_at_dots_outside_quotes() -> None:
    assert split_key('quick."grid.cell"') == ["quick", "grid.cell"]
    for bad in ("a..b", ".a", "a.", ""):
        with pytest.raises(CaseError):
            split_key(bad)


@pytest.mark.parametrize(
    ("setting", "key", "value"),
    [
        ("grid.cell=0.1", ["grid", "cell"], 0.1),
        ("grid.cell=10 cm", ["grid", "cell"], 0.1),
        ("title=Two words", ["title"], "Two words"),
        ("time.step=1e-5", ["time", "step"], 1e-5),
        ("body.drop.material.eos.sound_speed=30", ["body", 0, "material", "eos", "sound_speed"], 30.0),
        ("body.1.material.poisson_ratio=0.2", ["body", 1, "material", "poisson_ratio"], 0.2),
        ("body.drop.velocity.1=-2", ["body", 0, "velocity", 1], -2.0),
        (
            "body.drop.velocity_wave={amplitude=[1,0,0],wave_vector=[2,0,0]}",
            ["body", 0, "velocity_wave", "amplitude"],
            (1, 0, 0),
        ),
        (
            "body.drop.material.artificial_viscosity.linear=0.5",
            ["body", 0, "material", "artificial_viscosity", "linear"],
            0.5,
        ),
        ("support.0.velocity=[1,0,0]", ["support", 0, "velocity"], (1, 0, 0)),
        ("probe.front.reduce=min", ["probe", 0, "reduce"], "min"),
        ("energy.stop=0.5", ["energy", "stop"], 0.5),
    ],
)
def test_a_setting_reaches_any_field(text: str, setting: str, key: list, value: object) -> None:
    case = loads(text).with_settings(dict([parse_setting(setting)]))
    found: object = case
    for part in key:
        found = found[part] if isinstance(part, int) else getattr(found, part)  # type: ignore[index]
    assert found == value


def test_settings_are_checked_together_and_leave_the_case_as_it_was(text: str) -> None:
    case = loads(text)
    finer = case.with_settings({"grid.upper": [1.2, 0.6, 0], "grid.cell": 0.06})
    assert finer.grid.counts() == (20, 10, 1)
    assert case.grid.cell == 0.05


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("grid.cell=-1", ["--set grid.cell=-1", "greater than 0 m", "edge of the cubic cells"]),
        ("grid.cel=1", ["--set grid.cel=1", "unknown key", "did you mean `cell`?"]),
        ("gird.cell=1", ["--set gird.cell=1", "did you mean `grid`?"]),
        ("grid.cell=0.03", ["--set grid.cell=0.03", "whole number of cells"]),
        ("grid.cell.x=1", ["--set grid.cell.x=1", "`grid.cell` is 0.05, not a table"]),
        ("grid.upper=[0.7, 0.5, 0]", ["--set grid.upper=[0.7, 0.5, 0]", "body.block.shape", "outside the grid"]),
        ("body.dorp.velocity=[0,0,0]", ["`body` has no item `dorp`", "drop, block", "did you mean `body.drop`?"]),
        ("body.drop.velocity=[0,0]", ["--set body.drop.velocity=[0, 0]", "must have 3 components"]),
        ("support.5.fix=normal", ["`support` has no item `5`", "2 items, with indices from 0"]),
        ("time.end=3 kg", ["--set time.end=3 kg", "[mass]", "[time]"]),
        ("time.scheme=mulls", ["--set time.scheme=mulls", '"musl", "usf", "usl"', "did you mean `musl`?"]),
        ("a..b=1", ["is not a dotted key"]),
    ],
)
def test_a_bad_setting_is_named(text: str, setting: str, words: list[str]) -> None:
    with pytest.raises(CaseError) as caught:
        loads(text, "my.toml").with_settings(dict([parse_setting(setting)]))
    for word in words:
        assert word in str(caught.value)
    assert "my.toml" not in str(caught.value)


def test_another_kind_starts_from_its_own_defaults(text: str) -> None:
    case = loads(text).with_settings(
        {
            "body.drop.material.eos.kind": "stiffened-gas",
            "body.drop.material.eos.gruneisen": 4,
            "body.drop.material.eos.p_infinity": 1e8,
        }
    )
    assert case.body[0].material.eos.p_infinity == 1e8
    solid = case.with_settings(
        {
            "body.drop.material.kind": "neo-hookean",
            "body.drop.material.young_modulus": 1e5,
            "body.drop.material.poisson_ratio": 0.4,
        }
    )
    assert solid.body[0].material.density == 1000.0
    with pytest.raises(CaseError, match="sound_speed\n    is missing"):
        case.with_settings({"body.drop.material.eos.kind": "tait"})
    with pytest.raises(CaseError, match="unknown key"):
        case.with_settings({"body.drop.material.eos.kind": "ideal-gas", "body.drop.material.eos.p_infinity": 1})


@pytest.mark.parametrize("setting", ["grid.cell", "=3"])
def test_a_setting_needs_key_and_value(setting: str) -> None:
    with pytest.raises(CaseError, match="KEY=VALUE"):
        parse_setting(setting)


@pytest.mark.parametrize(
    "setting", ['time.end="5 ms', 'time.end=5 ms"', "title='Gas", "grid.upper=[1, 0.5, 0", "body.drop.shape={ box = 3"]
)
def test_toml_that_was_begun_is_ended(setting: str) -> None:
    with pytest.raises(CaseError, match="valid TOML"):
        parse_setting(setting)


def test_every_bad_setting_is_reported(text: str) -> None:
    with pytest.raises(CaseError) as caught:
        loads(text).with_settings({"grid.cell": -1, "time.end": -2, "body.drop.material.density": 0})
    assert "3 errors" in str(caught.value)


@pytest.mark.parametrize("setting", [f"body.{'1' * 5000}.name=x", "body.drop.material.density.0=1"])
def test_a_key_that_leads_nowhere_is_told(text: str, setting: str) -> None:
    with pytest.raises(CaseError, match="has no"):
        loads(text).with_settings(dict([parse_setting(setting)]))


def test_a_kind_within_what_another_setting_has_made_a_list_or_number(text: str) -> None:
    with pytest.raises(CaseError):
        loads(text).with_settings({"body.drop.material.kind": "fluid", "body": 3})


def write_faulty(folder: Path, text: str) -> Path:
    """A case with a wrong step, a wrong density, and a missing end."""
    wrong = text.replace("end = 0.1\n", "").replace("courant = 0.5", "courant = 3").replace("density = 1200.0", "density = -1")
    (folder / "faulty.toml").write_text(wrong)
    return folder / "faulty.toml"


RIGHT = {"time.end": 0.1, "time.courant": 0.5, "body.block.material.density": "1200 kg/m^3"}


def test_a_faulty_case_is_judged_with_its_settings(text: str, tmp_path: Path) -> None:
    file = write_faulty(tmp_path, text)
    found = load(file, RIGHT)
    assert found.body[1].material.density == pytest.approx(1200.0)
    assert found.to_data() == load(file, RIGHT | {"title": found.title}).to_data()
    (tmp_path / "sound.toml").write_text(text)
    assert found.to_data() == load(tmp_path / "sound.toml").to_data()


def test_what_is_left_is_named_with_its_line_and_what_settings_break_with_these(text: str, tmp_path: Path) -> None:
    file = write_faulty(tmp_path, text)
    with pytest.raises(CaseError) as caught:
        load(file, RIGHT | {"time.courant": 0.0})
    assert str(caught.value).startswith("--set time.courant=0.0: must be greater than 0")
    with pytest.raises(CaseError) as caught:
        load(file, {"time.end": 0.1, "time.courant": 0.5})
    line = file.read_text().splitlines().index("density = -1") + 1
    assert f"{file}:{line}: body.block.material.density = -1" in str(caught.value)
    assert "courant" not in str(caught.value)
    with pytest.raises(CaseError, match=r"--set body\.blok\.material\.density=1: `body` has no item `blok`"):
        load(file, {"body.blok.material.density": 1})


def test_faulty_quick_settings_can_be_corrected(text: str, tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(text.replace('"grid.cell" = 0.1', '"grid.cell" = -0.1\n"time.end" = 0.05'))
    with pytest.raises(CaseError, match="quick"):
        load(file)
    found = load(file, {"grid.cell": 0.1}, quick=True)
    assert (found.grid.cell, found.time.end) == (0.1, 0.05)
    assert load(file, {"grid.cell": 0.05}).time.end == 0.1
    with pytest.raises(CaseError) as caught:
        load(file, {"time.end": 0.1}, quick=True)
    line = file.read_text().splitlines().index('"grid.cell" = -0.1') + 1
    assert f"{file}:{line}: grid.cell = -0.1" in str(caught.value)


def test_a_file_that_is_no_toml_stays_one(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text("a = [")
    with pytest.raises(CaseError, match="valid TOML"):
        load(tmp_path / "my.toml", {"a": 1})


@pytest.mark.parametrize(
    "command",
    [
        ["validate"],
        ["run", "--no-report", "--until", "1e-9", "--out", "r"],
        ["sweep", "--over", "time.end=-1", "--out", "s"],
        ["converge", "--over", "time.end=-1,-2", "--metric", "none"],
        ["fit", "--measured", "c.csv", "--probe", "none", "--free", "time.end=-2:-1"],
    ],
)
def test_every_command_judges_the_case_after_its_settings(command: list[str], text: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    name, *more = command
    settings = [f"--set={key}={value}" for key, value in RIGHT.items()]
    result = CliRunner().invoke(app, [name, write_faulty(tmp_path, text).name, *more, *settings])
    if name in ("validate", "run"):
        assert result.exit_code == 0, result.stderr
    else:  # the case is accepted; what the study itself asks is not
        assert result.exit_code == 2
        assert "density" not in result.stderr
        assert "courant" not in result.stderr
    bare = CliRunner().invoke(app, [name, "faulty.toml", *more])
    assert "density = -1" in bare.stderr


def test_a_study_replaces_a_faulty_value(text: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text(text.replace("cell = 0.05", "cell = -1"))
    result = CliRunner().invoke(app, ["converge", "my.toml", "--over", "grid.cell=0.1,0.05", "--metric", "none"])
    assert "cell = -1" not in result.stderr
    assert "none" in result.stderr, "the metric is what is wrong"
