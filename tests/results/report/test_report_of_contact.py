"""What the report tells of contact: where membranes touch others, and what overlapped at the start."""

import pytest
from pressed_oocytes import RADIUS, pressed_oocyte
from typer.testing import CliRunner

from pellucid.case import Case, dumps
from pellucid.cli import app
from pellucid.results.report.report import write_report
from pellucid.running.launch import run_case


def test_validate_and_the_report_state_offsets_and_the_overlap_of_the_start(tmp_path):
    case = Case.model_validate(pressed_oocyte(RADIUS + 0.3e-6, end=1e-6, divisions=6))
    file = tmp_path / "case.toml"
    file.write_text(dumps(case), encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 0, result.output
    assert "contact: faces of membrane zona are 4e-06 m from `surface` on both sides (half the thickness)" in result.stdout
    assert "warning: body zona and wall plate start 3.7e-06 m closer to each other" in " ".join(result.stderr.split())
    with pytest.warns(UserWarning, match="body zona and wall plate"):
        run = run_case(case, tmp_path / "run", report=False)
    (overlap,) = run.summary["start_overlaps"]
    assert overlap["between"] == ["body zona", "wall plate"]
    page = write_report(run).read_text(encoding="utf-8")
    assert "thickness 8e-06 m, contact offset 4e-06 m from its mid-surface" in page
    assert (
        "body zona and wall plate: 3.7 × 10<sup>−6</sup> m; this overlap exerts no force until the bodies have separated"
        in page
    )
