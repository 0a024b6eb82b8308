from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

import pellucid.running.launch
from pellucid.cli import app
from pellucid.errors import CaseError
from pellucid.results.metrics import Metric
from pellucid.results.storage.run_folder import RunFolder

SUMMARY = {"end_time": 0.2, "steps": 10, "points": 100, "wall_seconds": 0.5, "point_steps_per_second": 2e3}


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[tuple[Any, Path, dict[str, Any]]]:
    """What `run_case` is asked for; it runs nothing. The working folder is empty."""
    seen = []

    def record(case: Any, out: Path, **options: Any) -> SimpleNamespace:
        seen.append((case, out, options))
        return SimpleNamespace(summary=SUMMARY, metrics={"density": Metric(1.0, 1.1, 0.1, 0.2)})

    monkeypatch.setattr(pellucid.running.launch, "run_case", record, raising=False)
    monkeypatch.chdir(tmp_path)
    return seen


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, ["run", *arguments])


def test_options_reach_the_run(calls: list) -> None:
    result = run("basics/sod", "--quick", "--set", "time.courant=0.2", "--until", "10 ms", "--threads", "2", "--every", "0.05")
    assert result.exit_code == 0, result.stderr
    case, folder, options = calls[0]
    assert case.id == "basics/sod"
    assert case.time.courant == 0.2
    assert case.output.frames == 0.05
    assert folder == Path("runs/sod")
    assert options["until"] == 0.01
    assert options["threads"] == 2
    assert "results in runs/sod" in result.stdout
    assert "density" in result.stdout
    assert "pass" in result.stdout


def test_a_setting_comes_after_the_quick_ones(calls: list) -> None:
    assert run("gan2011/shock-tube", "--quick", "--set", "grid.cell=0.01").exit_code == 0
    assert calls[0][0].grid.cell == 0.01


def test_the_default_folder_is_never_one_that_exists(calls: list) -> None:
    Path("runs/sod").mkdir(parents=True)
    Path("runs/sod-2").mkdir()
    assert run("basics/sod").exit_code == 0
    assert calls[0][1] == Path("runs/sod-3")


def test_a_file_names_its_folder(calls: list) -> None:
    Path("mine.toml").write_text(pellucid.dumps(pellucid.load("basics/sod")))
    assert run("mine.toml").exit_code == 0
    assert calls[0][1] == Path("runs/mine")


def test_a_folder_with_other_things_is_refused_and_untouched(calls: list) -> None:
    for names in (["thesis.tex"], ["case.toml"], ["case.toml", "history.csv"]):
        folder = Path("-".join(names)).with_suffix("")
        folder.mkdir()
        for name in names:
            (folder / name).write_text("mine")
        result = run("basics/sod", "--out", str(folder))
        assert result.exit_code == 2
        assert "contains files that do not belong to a run" in result.stderr
        assert sorted(item.name for item in folder.iterdir()) == sorted(names)
    assert not calls


def test_a_file_as_folder_is_refused(calls: list) -> None:
    Path("taken").write_text("")
    result = run("basics/sod", "--out", "taken")
    assert result.exit_code == 2
    assert "is a file" in result.stderr


def test_a_place_that_cannot_be_looked_at_is_refused(calls: list, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path) -> bool:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "exists", refuse)
    result = run("basics/sod", "--out", "secret")
    assert result.exit_code == 2
    assert "cannot write results to secret: Permission denied" in result.stderr


def test_an_earlier_run_may_be_replaced(calls: list) -> None:
    folder = RunFolder("again")
    with folder.made():
        folder.start(pellucid.load("basics/sod"))
    result = run("basics/sod", "--out", "again")
    assert result.exit_code == 0
    assert calls[0][1] == Path("again")


def test_nothing_is_said_of_an_earlier_run_before_the_new_case_is_set_up(calls: list, monkeypatch: pytest.MonkeyPatch) -> None:
    def bad(*_arguments: Any, **_options: Any) -> None:
        raise CaseError("no such points")

    folder = RunFolder("again")
    with folder.made():
        folder.start(pellucid.load("basics/sod"))
    monkeypatch.setattr(pellucid.running.launch, "run_case", bad)
    result = run("basics/sod", "--out", "again")
    assert result.exit_code == 2
    assert "replacing" not in result.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--until", "soon"], "--until"),
        (["--until", "-1"], "greater than 0 s"),
        (["--until", "3 kg"], "[mass]"),
        (["--every", "nan"], "greater than 0 s"),
        (["--every", "1 fs"], "--every 1 fs: output.frames"),
        (["--set", 'time.end="5 ms'], "Close all quotes"),
        (["--set", "grid.cel=1"], "did you mean `cell`?"),
        (["--set", "grid.cell"], "KEY=VALUE"),
    ],
)
def test_bad_options_are_explained(calls: list, arguments: list[str], words: str) -> None:
    result = run("basics/sod", *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert not calls
    assert not Path("runs").exists()


@pytest.mark.parametrize("command", ["resume", "report", "view"])
def test_a_folder_without_a_run_is_named(command: str, tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "nowhere"):
        result = CliRunner().invoke(app, [command, str(folder)])
        assert result.exit_code == 2
        assert str(folder) in result.stderr


@pytest.mark.parametrize("has_browser", [True, False])
def test_view_opens_the_report_or_says_where_it_is(has_browser: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    folder, opened = RunFolder("a run"), []
    with folder.made():
        folder.start(pellucid.load("basics/sod"))
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or has_browser)
    result = CliRunner().invoke(app, ["view", "a run"])
    assert result.exit_code == 2
    assert "Run `pellucid report a run` to write it." in result.stderr
    folder.report.write_text("")
    result = CliRunner().invoke(app, ["view", "a run"])
    assert opened == [f"{folder.report.resolve().as_uri()}#view"]
    assert f"the report is {folder.report.resolve()}" in result.stdout
    assert ("No browser was found" in result.stdout) != has_browser
