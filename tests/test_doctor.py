from pathlib import Path

import pytest
from typer.testing import CliRunner

from pellucid.cli import app


def test_the_doctor_looks_at_everything() -> None:
    result = CliRunner().invoke(app, ["doctor"])
    assert result.exit_code == 0
    for word in (
        "python",
        "numba",
        "threads",
        "kernel cache",
        "stills and films",
        "interactive 3-D view",
        "memory bandwidth",
        "disk",
    ):
        assert word in result.stdout


def test_a_cache_that_cannot_be_written_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from pellucid import doctor

    def refuse(**_options: object) -> None:
        raise PermissionError

    monkeypatch.setattr(doctor, "TemporaryFile", refuse)
    _, found, advice = doctor._kernel_cache()
    assert "is not writable" in found
    assert "NUMBA_CACHE_DIR" in advice


def test_every_package_that_is_declared_is_looked_at() -> None:
    from pellucid import doctor

    names = [name for name, _ in doctor._packages("")]
    assert {"numpy", "numba", "h5py"} <= set(names)
    assert not {"ruff", "meshlane", "dask"} & set(names)
    assert {"meshlane", "tetgen"} == {name for name, _ in doctor._packages("mesh")}
    assert "dask" in {name for name, _ in doctor._packages("sweep")}, "its own extras are no part of the name"


def test_a_machine_without_a_browser_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    from pellucid import doctor

    monkeypatch.setattr(doctor.shutil, "which", lambda name: None)
    _, found, advice = doctor._browser()
    assert "no browser" in found
    assert "report.html" in advice
