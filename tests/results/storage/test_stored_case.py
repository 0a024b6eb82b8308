"""What a run needs of its case when the kinds that it names are gone: nothing to be read, all to go on."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from registries import forgotten_afterwards
from typer.testing import CliRunner
from user_files import CASE, told, write

from pellucid import Run, load
from pellucid.cli import app
from pellucid.errors import CaseError
from pellucid.registry import Registry
from pellucid.running.launch import resume_case, run_case
from pellucid.users import users_code

pytestmark = pytest.mark.usefixtures("fake")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    write(tmp_path)
    with forgotten_afterwards():
        yield tmp_path


def forget() -> None:
    """Be another process, which has not loaded the extension."""
    for registry in Registry.every:
        for name in ("push", "shear", "glide", "middle", "speed"):
            registry.entries.pop(name, None)
    users_code._loaded.clear()
    Registry.changes += 1


def run_a_little(case: str) -> Path:
    """A run that was stopped early, by another process."""
    run_case(load(case), "out", until=0.003, report=False)
    forget()
    return Path("out")


def test_results_are_read_without_the_extension_and_resume_names_it(folder: Path) -> None:
    finished = run_a_little("case.toml")
    (folder / "mine.py").unlink()
    run = Run(finished)
    assert not run.finished
    assert run.fields("block", 0.002)["position"].shape == (32, 3)
    assert run.metrics == {}
    assert len(run.history["typical"]) == 4
    assert len(run.cells("block").points) == 32
    assert CliRunner().invoke(app, ["report", "out"]).exit_code == 0
    assert "neo hookean" in (finished / "report.html").read_text(encoding="utf-8")
    with pytest.raises(CaseError, match=r"extensions.0 = .*\n.*the file cannot be read: No such file"):
        _ = run.case
    before = (finished / "history.csv").read_bytes()
    message = told(2, "resume", "out")
    assert "The run in out cannot continue, because its case can no longer be read" in message
    assert f"The file {folder / 'mine.py'} is missing. Restore it." in message
    assert "Its results can still be read with `pellucid report out`" in message
    assert (finished / "history.csv").read_bytes() == before
    write(folder)
    assert resume_case("out", until=0.004, report=False).history["time"][-1] == pytest.approx(0.004)


def test_results_are_read_without_the_script_and_resume_names_it(folder: Path) -> None:
    script = str(folder / "mine.py")
    (folder / "plain.toml").write_text(CASE.replace('extensions = ["mine.py"]\n', ""), encoding="utf-8")
    users_code.load_file(script)  # as a script would that holds it
    assert len(Run(run_a_little("plain.toml")).times("block")) == 4
    message = told(2, "resume", "out")
    for name in ("push", "shear", "glide", "middle", "speed"):
        assert f'"{name}" was registered by {script}, which is not listed in `extensions` of the case' in message
    assert 'Import it in a script that calls `pellucid.resume("out")`' in message
    users_code.load_file(script)
    assert resume_case("out", until=0.004, report=False).history["time"][-1] == pytest.approx(0.004)
