"""`pellucid warm` and `--no-report`, as a user gives them."""

import subprocess
import sys
from pathlib import Path

from typer.testing import CliRunner

from pellucid.cli import app
from pellucid.jit import cache_folder

WAVE = "basics/elastic-wave"


def invoke(*words: object) -> object:
    return CliRunner().invoke(app, [str(word) for word in words])


def warmed(*cases: str) -> list[str]:
    """In a process of its own: in this one a kernel may be compiled already, and kept elsewhere."""
    command = [sys.executable, "-m", "pellucid", "warm", *cases]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def test_kernels_are_in_the_cache_afterwards(tmp_path: Path, monkeypatch) -> None:
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    # a cache of its own: of two processes that compile the same at once, a driver of one may stay beside a kernel of the other
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    Path("mine.toml").write_text(invoke("show", WAVE).stdout, encoding="utf-8")
    header, *rows, last = warmed(WAVE, "mine.toml")
    assert header.split() == ["case", "kernels", "compiled", "time"]
    assert [row.split()[0] for row in rows] == [WAVE], "both need the same kernels"
    assert last == f"the kernels are in {cache_folder()}"
    assert list(cache_folder().rglob("*.nbc"))
    assert warmed("mine.toml")[1].split()[:2] == ["mine.toml", "0"]
    assert [path.name for path in work.iterdir()] == ["mine.toml"], "nothing else is written"


def test_a_case_that_is_none_is_told_before_anything_is_compiled(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    result = invoke("warm", WAVE, "basics/elastic-wafe")
    assert result.exit_code == 2
    assert "basics/elastic-wafe" in result.stderr
    assert not (tmp_path / "cache").exists()


def test_a_cache_that_cannot_be_written_is_an_error(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    result = invoke("warm", WAVE)
    assert result.exit_code == 2, result.output
    assert f"Compiled kernels cannot be stored in {cache_folder()}" in result.stderr


def test_a_run_without_report_is_drawn_later(tmp_path: Path) -> None:
    out = tmp_path / "run"
    for words in (("run", WAVE, "--quick", "--out", out, "--until", "0.1"), ("resume", out, "--until", "0.2")):
        result = invoke(*words, "--no-report")
        assert result.exit_code == 0, result.output
        assert (out / "summary.json").is_file()
        assert not (out / "report.html").exists()
        assert not (out / "figures").exists()
    assert invoke("report", out).exit_code == 0
    assert (out / "report.html").is_file()
    assert list((out / "figures").glob("*.png"))
