from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

import pellucid.studies.verification
from pellucid.cli import app
from pellucid.results.metrics import Metric


def rows(*errors: float) -> list[SimpleNamespace]:
    return [
        SimpleNamespace(case="basics/sod", name=f"m{i}", metric=Metric(1.0, 1.0, error, 0.01, "", "distance"))
        for i, error in enumerate(errors)
    ]


@pytest.mark.parametrize(("errors", "status"), [((0.001, 0.002), 0), ((0.001, 0.02), 3), ((float("nan"),), 3)])
def test_verify_prints_a_table_and_its_status_tells(
    errors: tuple[float, ...], status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pellucid.studies.verification, "verify", lambda *_, **__: rows(*errors))
    result = CliRunner().invoke(app, ["verify", "basics/sod"])
    assert result.exit_code == status
    for word in ("case", "metric", "value", "reference", "error", "tolerance", "m0"):
        assert word in result.stdout
    assert ("fail" in result.stdout) == (status == 3)


def test_verify_takes_quick_variants_of_all_cases_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}

    def record(ids: list[str], **options: Any) -> list:
        seen.update(options, ids=ids)
        return rows(0.0)

    monkeypatch.setattr(pellucid.studies.verification, "verify", record)
    assert CliRunner().invoke(app, ["verify"]).exit_code == 0
    assert seen["full"] is False
    assert "gan2011/shock-tube" in seen["ids"]


def test_verify_of_no_case_is_status_2() -> None:
    result = CliRunner().invoke(app, ["verify", "gan2011/shok-tube"])
    assert result.exit_code == 2
    assert "did you mean `gan2011/shock-tube`?" in result.stderr
