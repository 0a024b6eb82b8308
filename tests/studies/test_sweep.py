import numpy as np
import pandas as pd
import pytest
from small_studies import SPEED, case, run_members_here, write_csv
from typer.testing import CliRunner

import pellucid
from pellucid import studies
from pellucid.cli import app
from pellucid.errors import UsageError
from pellucid.studies.sweep import Sensitivity, write_sweep_page
from pellucid.system import extras


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    return run_members_here(monkeypatch)


def sweep(over: dict, out, **more) -> pd.DataFrame:
    return pellucid.sweep(case(), over, out=out, workers=1, **more)


def test_a_table_has_settings_and_reduced_probes(begun: list[str], tmp_path) -> None:
    table = sweep({SPEED: [1.0, 2.0]}, tmp_path / "s")
    assert list(table[SPEED]) == [1.0, 2.0]
    assert list(table["state"]) == ["done", "done"]
    assert list(np.diff(table["front_last"])) == pytest.approx([1.0]), "a second faster for a second"
    assert list(table["front_mean"]) == pytest.approx(list((table["front_min"] + table["front_max"]) / 2))
    assert len(begun) == 2
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "s" / "members.parquet"), table, check_dtype=False)
    assert list(pd.read_csv(tmp_path / "s" / "members.csv")["member"]) == list(table["member"])
    page = (tmp_path / "s" / "report.html").read_text()
    assert page.count("<img") == 2, "the curves, and the dependence"


def test_what_is_done_is_not_run_again(begun: list[str], tmp_path) -> None:
    sweep({SPEED: [1.0, 2.0]}, tmp_path / "s")
    begun.clear()
    table = sweep({SPEED: [2.0, 3.0, 1.0]}, tmp_path / "s")
    assert len(begun) == 1, "the new value alone"
    assert list(table[SPEED]) == [2.0, 3.0, 1.0]


def test_a_failure_is_kept_and_not_repeated(begun: list[str], tmp_path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(pellucid.dumps(case()))
    command = ["sweep", str(file), "--over", f"{SPEED}=1.0,13.0", "--workers", "1", "--out", str(tmp_path / "s")]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 3
    assert "1 of 2 members failed" in result.stderr
    assert f"({SPEED} = 13.0) failed: point 7 of gas is lost" in result.stderr
    table = pd.read_csv(tmp_path / "s" / "members.csv")
    assert list(table["state"]) == ["done", "failed"]
    assert "point 7 of gas is lost" in table["message"][1]
    assert "Failures" in (tmp_path / "s" / "report.html").read_text()
    begun.clear()
    assert CliRunner().invoke(app, command).exit_code == 3
    assert begun == []


def test_bad_members_are_told_before_anything_runs(begun: list[str], tmp_path) -> None:
    table = write_csv(tmp_path / "t.csv", ("grid.cell",), ("0.5",), ("-1",))
    result = CliRunner().invoke(app, ["sweep", "basics/sod", "--from", str(table), "--out", str(tmp_path / "s")])
    assert result.exit_code == 2
    assert "--set grid.cell=-1: must be greater than 0 m" in result.stderr
    assert begun == []
    assert not (tmp_path / "s").exists()


def test_numbers_beside_words_are_one_column(begun: list[str], tmp_path) -> None:
    table = sweep({"body.gas.points_per_cell": [[5, 4, 1], 1]}, tmp_path / "s")
    assert list(table["body.gas.points_per_cell"]) == ["[5, 4, 1]", "1"]


def test_an_end_that_members_do_not_reach_is_refused(begun: list[str], tmp_path) -> None:
    with pytest.raises(UsageError, match="is later than the end of the case"):
        sweep({"time.end": [1.0, 0.4]}, tmp_path / "s", until=0.5)
    assert begun == []


def test_the_folder_of_a_run_is_refused(begun: list[str], tmp_path) -> None:
    pellucid.run(case(), tmp_path / "r", report=False)
    with pytest.raises(UsageError, match="is the folder of a run"):
        sweep({SPEED: [1.0]}, tmp_path / "r")


def test_a_page_shows_sensitivities(tmp_path) -> None:
    table = pd.DataFrame({"member": list("abcd"), "state": "done", "speed": [1.0, 2.0, 3.0, 4.0], "y": [1.0, 4.0, 9.0, 16.0]})
    found = [Sensitivity("y", "speed", 0.97, 0.02)]
    page = write_sweep_page(tmp_path, "a case", [], table, ["speed"], found).read_text()
    assert "first-order index" in page
    assert "0.97" in page


def test_a_missing_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError("No module named 'pandas'", name="pandas")

    monkeypatch.setattr(extras, "import_module", missing)
    with pytest.raises(UsageError, match=r"pip.* install '\.\[sweep\]' in the clone"):
        studies.need("pandas")
