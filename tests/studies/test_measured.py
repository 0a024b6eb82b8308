import numpy as np
import pytest
from small_studies import case, run_members_here, write_csv

from pellucid.errors import UsageError
from pellucid.running.launch import run_case
from pellucid.studies.misfit import read_curve

HEAD = (("time", "front", "deviation"), ("ms", "mm", "um"))


def test_units_and_deviations_are_read(tmp_path) -> None:
    curve = read_curve(write_csv(tmp_path / "c.csv", *HEAD, (100, 1600, 500), (500, 2000, 250)), "front", case())
    np.testing.assert_allclose(curve.x, [0.1, 0.5])
    np.testing.assert_allclose(curve.y, [1.6, 2.0])
    np.testing.assert_allclose(curve.deviation, [5e-4, 2.5e-4])
    assert curve.is_stated


def test_a_history_is_a_measured_curve(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    run_members_here(monkeypatch)
    run = run_case(case(), tmp_path / "r", report=False)
    curve = read_curve(tmp_path / "r" / "history.csv", "front", case())
    assert not curve.is_stated
    assert np.abs(curve.residuals(run)).max() < 1e-12


def test_one_deviation_holds_for_all_values(tmp_path) -> None:
    path = write_csv(tmp_path / "c.csv", ("time", "x of the front"), ("s", "m"), (0.1, 1.6), (0.5, 2.0))
    np.testing.assert_allclose(read_curve(path, "front", case(), "2 mm").deviation, 2e-3)
    assert read_curve(path, "front", case(), 2e-3).is_stated
    np.testing.assert_allclose(read_curve(path, "front", case()).deviation, 0.2)
    stated = write_csv(tmp_path / "d.csv", *HEAD, (0.1, 1, 1), (0.2, 1, 2))
    with pytest.raises(UsageError, match=r"already has standard deviations in the column deviation\.\n    Remove the option"):
        read_curve(stated, "front", case(), "2 mm")


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        ([("time", "front"), ("s", "m"), (0.1, 1)], "a curve requires at least two rows"),
        ([("time", "front"), (0.0, 1.0), (0.1, 1), (0.2, 1)], r"c\.csv:1: the column time has no unit"),
        ([("time", "front"), ("s", "kg"), (0.1, 1), (0.2, 1)], r"c\.csv: the unit of the column front: .* dimension"),
        ([("time", "front"), ("s", "m"), (0.1, "wide"), (0.2, 1)], r'c\.csv:3: front = "wide" is not a finite number'),
        ([("time", "front"), ("s", "m"), (0.1, 1), (0.2,)], r"c\.csv:4: the row has 1 cells, but there are 2 columns"),
        ([("time", "front"), ("s", "m"), (0.1, 1), (7.0, 1)], r"c\.csv:4: t = 7 s is not between"),
        ([("x", "front"), ("s", "m"), (0.1, 1), (0.2, 1)], "no column has the name time or the name of a probe"),
        ([*HEAD, (0.1, 1, 1), (0.2, 1, 0)], r"c\.csv:4: deviation is 0; it must be greater than 0"),
    ],
)
def test_a_bad_file_is_refused_with_its_line(rows: list, why: str, tmp_path) -> None:
    with pytest.raises(UsageError, match=why):
        read_curve(write_csv(tmp_path / "c.csv", *rows), "front", case())


def test_an_unknown_probe_is_told_with_those_there_are(tmp_path) -> None:
    with pytest.raises(UsageError, match="did you mean `front`"):
        read_curve(tmp_path / "none.csv", "frnt", case())


def test_a_missing_file_is_told(tmp_path) -> None:
    with pytest.raises(UsageError, match=r"cannot read .*none\.csv: No such file"):
        read_curve(tmp_path / "none.csv", "front", case())
