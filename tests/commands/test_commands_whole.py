"""The commands as a user gives them, on a case of a second."""

import signal
import subprocess
import sys
import time
from pathlib import Path

from typer.testing import CliRunner

from pellucid.cli import app

BAR = ["basics/elastic-wave", "--quick"]


def test_a_run_leaves_its_folder_and_report_draws_again(tmp_path: Path) -> None:
    folder = tmp_path / "bar"
    result = CliRunner().invoke(app, ["run", *BAR, "--out", str(folder), "--until", "0.1"])
    assert result.exit_code == 0, result.output
    assert "M point-steps/s" in result.stdout
    for name in ("case.toml", "history.csv", "summary.json", "report.html"):
        assert (folder / name).is_file()
    (folder / "report.html").unlink()
    assert CliRunner().invoke(app, ["report", str(folder)]).exit_code == 0
    assert (folder / "report.html").is_file()
    assert CliRunner().invoke(app, ["validate", str(folder / "case.toml")]).exit_code == 0


def test_an_unstable_fixed_step_names_line_or_setting(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["run", *BAR, "--set", "time.step=1", "--out", str(tmp_path / "bar")])
    assert result.exit_code == 2
    assert "--set time.step=1" in result.stderr
    file = tmp_path / "spin.toml"  # the rotation makes it unstable, which only the set-up of the run sees
    text = CliRunner().invoke(app, ["show", "basics/spinning-disc"]).stdout
    text = text.replace("[time]\n", "[time]\nstep = 1e-3\n")
    file.write_text(text.replace("angular_velocity = ", "angular_velocity = [0, 0, 1e6] # "), encoding="utf-8")
    result = CliRunner().invoke(app, ["run", str(file), "--out", str(tmp_path / "spin")])
    assert result.exit_code == 2, result.output
    line = file.read_text().splitlines().index("step = 1e-3") + 1
    assert f"{file}:{line}: time.step = 0.001" in result.stderr
    assert not (tmp_path / "spin").exists()


def test_sigterm_leaves_a_checkpoint_status_143_and_word_how_to_resume(tmp_path: Path) -> None:
    folder = tmp_path / "bar"
    command = [sys.executable, "-m", "pellucid", "run", *BAR, "--set", "time.end=1e4", "--out", str(folder)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 200
        while not (folder / "history.csv").is_file() and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(0.5)
        process.send_signal(signal.SIGTERM)
        _, message = process.communicate(timeout=60)
    assert process.returncode == 143
    assert f"`pellucid resume {folder}`" in message
    assert any((folder / "checkpoint").iterdir())
    result = CliRunner().invoke(app, ["resume", str(folder), "--until", "0.001"])
    assert result.exit_code == 0, result.output
