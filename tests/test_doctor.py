from pathlib import Path

import pytest
from typer.testing import CliRunner

from pellucid.cli import app


def test_the_doctor_looks_at_everything() -> None:
    result = CliRunner().invoke(app, ["doctor"])
    assert result.exit_code == 0
    for word in ("python", "numba", "threads", "kernel cache", "drawing in 3-D", "memory", "disk"):
        assert word in result.stdout


def test_a_cache_that_cannot_be_written_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from pellucid import doctor

    def refuse(**_options: object) -> None:
        raise PermissionError

    monkeypatch.setattr(doctor, "TemporaryFile", refuse)
    _, found, advice = doctor._kernel_cache()
    assert "cannot be written" in found
    assert "NUMBA_CACHE_DIR" in advice
