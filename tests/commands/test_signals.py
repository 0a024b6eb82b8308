"""SIGTERM and Ctrl-C outside of the steps of a run: one sentence, a status, nothing half-written."""

import os
import signal
import sys
from pathlib import Path

import pytest
from free_flight import FakeSimulation, fake_module, free_flight
from typer.testing import CliRunner

import pellucid
from pellucid.case import dumps
from pellucid.cli import app
from pellucid.results.pictures import figures
from pellucid.results.storage import files, run_folder
from pellucid.running.launch import resume_case, run_case

pytestmark = pytest.mark.usefixtures("interruptible")

SIGNALS = ((signal.SIGTERM, 143), (signal.SIGINT, 130))


@pytest.fixture
def case(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The file of a case that the fake simulation runs."""
    monkeypatch.setitem(sys.modules, "pellucid.simulation.simulation", fake_module())
    path = tmp_path / "mine.toml"
    path.write_text(dumps(free_flight()))
    return path


def struck(monkeypatch: pytest.MonkeyPatch, place: object, name: str, number: int, before: bool = True) -> None:
    """A signal arrives when a function is called, or as it returns."""
    original = getattr(place, name)

    def call(*arguments: object, **more: object) -> object:
        if before:
            os.kill(os.getpid(), number)
        found = original(*arguments, **more)
        os.kill(os.getpid(), number)
        return found

    monkeypatch.setattr(place, name, call)


def invoke(*words: object) -> object:
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.mark.parametrize(("number", "status"), SIGNALS)
def test_in_the_set_up_nothing_is_written(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, status: int
) -> None:
    struck(monkeypatch, FakeSimulation, "state_numbers", number)
    struck(monkeypatch, FakeSimulation, "__init__", number)
    result = invoke("run", case, "--out", tmp_path / "run")
    assert result.exit_code == status
    assert result.stderr == "pellucid: The run was interrupted before its first step; nothing was written.\n"
    assert not (tmp_path / "run").exists()


def test_in_the_set_up_an_earlier_run_stays_as_it_is(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_case(free_flight(), tmp_path / "run", report=False)
    (tmp_path / "run/run.lock").write_text('{"program": "pellucid", "pid": 1, "host": "elsewhere", "since": "long ago"}\n')
    before = {path: path.read_bytes() for path in (tmp_path / "run").rglob("*") if path.is_file()}
    struck(monkeypatch, FakeSimulation, "__init__", signal.SIGTERM)
    result = invoke("run", case, "--out", tmp_path / "run")
    assert result.exit_code == 143
    assert "nothing was written" in result.stderr
    assert {path: path.read_bytes() for path in (tmp_path / "run").rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(("number", "status"), SIGNALS)
@pytest.mark.parametrize("before", [True, False])
def test_between_set_up_and_steps_the_run_can_go_on(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, status: int, before: bool
) -> None:
    with monkeypatch.context() as patch:
        struck(patch, run_folder, "write_text", number, before)
        result = invoke("run", case, "--out", tmp_path / "run")
    assert result.exit_code == status
    if before:  # not even a case
        assert result.stderr == "pellucid: The run was interrupted before its first step; nothing was written.\n"
        assert [path.name for path in (tmp_path / "run").iterdir()] == ["run.lock"]
        assert run_case(free_flight(), tmp_path / "run", report=False).finished
    else:
        assert result.stderr.endswith(f"\n    Run `pellucid resume {tmp_path / 'run'}` to continue.\n")
        assert resume_case(tmp_path / "run", report=False).finished


@pytest.mark.parametrize(("number", "status"), SIGNALS)
@pytest.mark.parametrize("place", [(figures, "energies"), (files, "sync")])
def test_in_the_report_the_results_are_whole(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, status: int, place: tuple
) -> None:
    out = tmp_path / "run"
    with monkeypatch.context() as patch:
        patch.setattr(figures, "bodies", lambda run: struck(patch, *place, number) or {})  # from then on
        result = invoke("run", case, "--out", out)
    assert result.exit_code == status
    text = "Interrupted while the report was drawn; the results are complete."
    assert result.stderr.endswith(f"\npellucid: {text}\n    Run `pellucid report {out}` to draw it.\n")
    assert pellucid.Run(out).finished
    assert not [path for path in out.rglob("*") if path.name.endswith(".writing")]
    with monkeypatch.context() as patch:
        patch.setattr(figures, "bodies", lambda run: struck(patch, *place, number) or {})
        result = invoke("report", out)
    assert result.exit_code == status
    assert f"the report is not complete; the results in {out} are unchanged" in result.stderr


def test_in_another_command_it_is_told_too(monkeypatch: pytest.MonkeyPatch) -> None:
    import pellucid.catalogue

    struck(monkeypatch, pellucid.catalogue, "ids", signal.SIGTERM)
    result = invoke("list")
    assert (result.exit_code, result.stderr) == (143, "pellucid: interrupted\n")
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
