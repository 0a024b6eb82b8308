import json

import numpy as np
import pytest
from small_studies import LAG, SPEED, case, run_members_here, write_csv
from typer.testing import CliRunner

import pellucid
from pellucid.cli import app
from pellucid.errors import UsageError

TRUTH = 1.7


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    return run_members_here(monkeypatch)


@pytest.fixture
def curve(begun: list[str], tmp_path):
    """The front of the gas that flies with 1.7 m/s, with noise of 10 mm."""
    history = pellucid.run(case(**{SPEED: TRUTH}), tmp_path / "truth", report=False).history
    noise = np.random.default_rng(5).normal(0.0, 0.01, len(history["time"]))
    rows = zip(1e3 * history["time"], 1e3 * (history["front"] + noise), strict=True)
    return write_csv(tmp_path / "front.csv", ("time", "front"), ("ms", "mm"), *rows)


def fit(curve, out, **more) -> "pellucid.fit":
    chosen = {"free": {SPEED: (0.5, 3.0)}, "deviation": {"front": "10 mm"}, "workers": 1} | more
    return pellucid.fit(case(), {"front": curve}, out=out, **chosen)


def test_a_parameter_is_found_within_its_interval(begun: list[str], curve, tmp_path) -> None:
    found = fit(curve, tmp_path / "f")
    one = found.estimates[SPEED]
    assert one.low < TRUTH < one.high
    assert one.high - one.low < 0.05
    assert 0.3 < found.chi_square < 2.5
    assert found.warnings == []
    assert found.case.body[0].velocity[0] == one.value
    assert len(begun) == len(set(begun)) == len(found.members), "nothing is run twice"
    names = {path.name for path in (tmp_path / "f").iterdir() if path.is_file()}
    assert names == {"estimates.json", "fitted.toml", "fit.png", "report.html", "members.csv", "members.parquet"}
    assert json.loads((tmp_path / "f" / "estimates.json").read_text())["estimates"][SPEED]["value"] == one.value


def test_the_same_fit_again_runs_nothing(begun: list[str], curve, tmp_path) -> None:
    first = fit(curve, tmp_path / "f")
    begun.clear()
    assert fit(curve, tmp_path / "f").estimates == first.estimates
    assert begun == []


def test_optuna_finds_it_too(begun: list[str], curve, tmp_path) -> None:
    one = fit(curve, tmp_path / "f", method="optuna", trials=25).estimates[SPEED]
    assert abs(one.value - TRUTH) < 0.15
    assert len(set(begun)) == len(begun)


def test_what_the_data_do_not_determine_is_told(begun: list[str], curve, tmp_path) -> None:
    with pytest.warns(UserWarning, match="do not determine body.block.material.young_modulus"):
        found = fit(curve, tmp_path / "f", free={SPEED: (0.5, 3.0), "body.block.material.young_modulus": (1e2, 1e4)})
    assert found.estimates[SPEED].low < TRUTH < found.estimates[SPEED].high


def test_parameters_that_act_alike_are_told_together(begun: list[str], curve, tmp_path) -> None:
    with pytest.warns(UserWarning, match=f"do not determine {SPEED} and {LAG} independently"):
        fit(curve, tmp_path / "f", free={SPEED: (1.0, 3.0), LAG: (0.0, 4.0)})


def test_runs_that_fail_turn_the_search_back(begun: list[str], curve, tmp_path) -> None:
    one = fit(curve, tmp_path / "f", free={SPEED: (1.0, 14.0)}).estimates[SPEED]
    assert one.low < TRUTH < one.high


def test_the_command_prints_the_estimates(curve, tmp_path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(pellucid.dumps(case()))
    more = ["--deviation", "10 mm", "--free", f"{SPEED}=0.5:3", "--workers", "1", "--out", str(tmp_path / "f")]
    result = CliRunner().invoke(app, ["fit", str(file), "--measured", str(curve), "--probe", "front", *more])
    assert result.exit_code == 0, result.stderr
    assert SPEED in result.stdout
    assert "estimates.json" in result.stdout


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ({"method": "guess"}, "there is no method"),
        ({"free": {}}, "requires a measured curve and a free parameter"),
        ({"free": {SPEED: (3.0, 0.5)}}, "must be less"),
        ({"trials": 0}, "at least 1"),
        ({"deviation": {"frnt": 1.0}}, "did you mean `front`"),
        ({"scheduler": "tcp://a:1", "slurm": {"cores": "1", "memory": "1GB"}}, "Remove one of them"),
    ],
)
def test_what_makes_no_sense_is_refused(begun: list[str], curve, more: dict, why: str, tmp_path) -> None:
    begun.clear()
    with pytest.raises(UsageError, match=why):
        fit(curve, tmp_path / "f", **more)
    assert begun == []


def test_members_have_rows_as_close_as_the_measured_ones(begun: list[str], tmp_path) -> None:
    """Not the two of the case: a curve through these would be a straight line."""
    coarse = case(**{"output.history": 0.5})
    times = np.linspace(0.05, 0.95, 19)
    start = pellucid.run(case(), tmp_path / "start", report=False).history["front"][0]
    rows = zip(times, start + TRUTH * times, strict=True)
    file = write_csv(tmp_path / "front.csv", ("time", "front"), ("s", "m"), *rows)
    found = pellucid.fit(coarse, {"front": file}, {SPEED: (0.5, 3.0)}, workers=1, out=tmp_path / "f")
    assert found.case.output.history == 0.5
    assert abs(found.estimates[SPEED].value - TRUTH) < 1e-3
    member = next(path for path in (tmp_path / "f" / "members").iterdir() if path.is_dir())
    assert len(pellucid.Run(member).history["time"]) > 30, "a row at each step"
