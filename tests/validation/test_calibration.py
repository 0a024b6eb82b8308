"""The calibrations under validation: one of them on a mesh of a few nodes, and the numbers that are kept of them."""

import csv
from pathlib import Path
from types import ModuleType

import pytest
from small_studies import run_members_here_as_they_are

FOLDER = Path(__file__).parents[2] / "validation" / "calibration"


@pytest.fixture
def calibration() -> ModuleType:
    module = ModuleType("calibrate")
    module.__file__ = str(FOLDER / "calibrate.py")
    exec((FOLDER / "calibrate.py").read_text(encoding="utf-8"), module.__dict__)
    return module


@pytest.mark.slow
def test_modulus_and_poisson_ratio_are_found(calibration: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    begun = run_members_here_as_they_are(monkeypatch)
    mesh = {"body.cylinder.mesh.cylinder.across": 4, "body.cylinder.mesh.cylinder.along": 2, "steady.load_steps": 2}
    rows = calibration.calibrate("indentation", tmp_path, seeds=(1,), settings={**mesh, "output.history": 0.5})
    assert [row["within"] for row in rows] == [True, True]
    assert all(row["high"] - row["low"] < 0.5 * row["truth"] for row in rows)
    assert len(set(begun)) == len(begun) < 40


@pytest.mark.parametrize("name", ["indentation", "zona"])
def test_kept_intervals_hold_the_truth(calibration: ModuleType, name: str) -> None:
    with (FOLDER / f"{name}.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {int(row["seed"]) for row in rows} == {1, 2, 3}
    for row in rows:
        assert calibration.CALIBRATIONS[name].truth[row["parameter"]] == float(row["truth"])
        assert float(row["low"]) <= float(row["truth"]) <= float(row["high"])
        assert float(row["seconds"]) < 600
