from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

import pellucid.running.launch
from pellucid.cli import app
from pellucid.errors import UsageError
from pellucid.results.metrics import Metric
from pellucid.studies.verification import Step, observed_order, read_sweep

TUBE = ["converge", "gan2011/shock-tube", "--metric", "density_l1"]


@pytest.fixture
def second_order(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Runs whose error is three times the cell squared; returns the folders asked for."""
    folders: list[Path] = []

    def solve(case: Any, out: Path, **_options: Any) -> SimpleNamespace:
        folders.append(out)
        return SimpleNamespace(case=case, metrics={"density_l1": Metric(0.0, 0.0, 3 * case.grid.cell**2, 1.0)})

    monkeypatch.setattr(pellucid.running.launch, "run_case", solve, raising=False)
    return folders


def test_error_ratio_and_order_are_printed_and_kept(second_order: list[Path], tmp_path: Path) -> None:
    result = CliRunner().invoke(app, [*TUBE, "--over", "grid.cell=10 mm,5mm,0.0025", "--out", str(tmp_path / "study")])
    assert result.exit_code == 0, result.stderr
    assert "observed order of convergence (least squares over all values): 2.00" in result.stdout
    assert second_order == [tmp_path / "study" / f"{i}" for i in (1, 2, 3)]
    rows = (tmp_path / "study" / "convergence.csv").read_text().splitlines()
    assert rows[0] == "grid.cell,error_of_density_l1,ratio,order"
    assert [float(cell) for cell in rows[2].split(",")] == pytest.approx([0.005, 7.5e-5, 4.0, 2.0])
    assert (tmp_path / "study" / "convergence.png").stat().st_size > 1000


def test_two_fields_go_in_step() -> None:
    assert read_sweep(["grid.cell=0.1,0.05", "time.step=2e-4,1e-4"]) == {
        "grid.cell": [0.1, 0.05],
        "time.step": [2e-4, 1e-4],
    }
    assert read_sweep(["time.scheme=usf,musl"]) == {"time.scheme": ["usf", "musl"]}
    assert read_sweep(["body.a.points_per_cell=[1,1,1],[2,2,2]"])["body.a.points_per_cell"] == [[1, 1, 1], [2, 2, 2]]


@pytest.mark.parametrize("texts", [["grid.cell"], ["grid.cell=1"], ["grid.cell=1,2", "time.step=1,2,3"], ["=1,2"]])
def test_a_bad_sweep_is_refused(texts: list[str]) -> None:
    with pytest.raises(UsageError):
        read_sweep(texts)


def test_an_impossible_value_stops_before_anything_runs(second_order: list[Path]) -> None:
    result = CliRunner().invoke(app, [*TUBE, "--over", "grid.cell=0.01,0.003"])
    assert result.exit_code == 2
    assert "whole number of cells" in result.stderr
    assert not second_order


def test_an_unknown_metric_is_named_with_those_there_are(second_order: list[Path]) -> None:
    result = CliRunner().invoke(app, ["converge", "basics/sod", "--metric", "mass", "--over", "grid.cell=0.02,0.01"])
    assert result.exit_code == 2
    assert "basics/sod has no metric `mass`; available: density_l1, " in result.stderr
    assert not second_order, "nothing has run"


def test_a_case_of_ones_own_has_no_metrics(second_order: list[Path], tmp_path: Path) -> None:
    case = tmp_path / "mine.toml"
    case.write_text(pellucid.dumps(pellucid.load("basics/sod").model_copy(update={"id": ""})))
    result = CliRunner().invoke(app, ["converge", str(case), "--metric", "density_l1", "--over", "grid.cell=0.02,0.01"])
    assert result.exit_code == 2
    assert "has no metric `density_l1`; available: none; add a [[check]] to the case" in result.stderr
    assert not second_order


def test_a_metric_that_a_setting_takes_away_is_named(second_order: list[Path]) -> None:
    over = ["--over", "grid.cell=0.01,0.005"]
    result = CliRunner().invoke(app, ["converge", "gan2011/shock-tube", "--metric", "shock_position", *over])
    assert result.exit_code == 2
    assert "With these settings, gan2011/shock-tube has no metric `shock_position`; available: density_l1" in result.stderr
    assert len(second_order) == 1


def test_no_order_is_claimed_without_numbers() -> None:
    assert observed_order([Step("usf", 0.1, None, None), Step("musl", 0.2, 0.5, None)]) is None
    assert observed_order([Step(0.1, 0.0, None, None), Step(0.05, 0.1, None, None)]) is None
