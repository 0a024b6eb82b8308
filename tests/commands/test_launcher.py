import sys

import pytest

from pellucid.commands import runs
from pellucid.errors import UsageError

COMMAND = ["run", "case.toml", "--ranks", "4", "--quick", "--ranks=2", "--set", "a=--ranks"]


def test_the_option_and_its_value_are_taken_out():
    assert runs.without("--ranks", COMMAND) == ["run", "case.toml", "--quick", "--set", "a=--ranks"]
    assert runs.without("--ranks", ["run", "--ranks"]) == ["run"]


def test_one_process_starts_none(monkeypatch):
    monkeypatch.setattr(runs.os, "execv", None)
    runs.start_together(1, ["run"])


@pytest.mark.parametrize("missing", ["mpiexec", "mpi4py"])
def test_what_is_missing_is_named_with_its_extra(monkeypatch, tmp_path, missing):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setattr(runs.shutil, "which", lambda name: None if missing == "mpiexec" else f"/bin/{name}")
    monkeypatch.setattr(runs, "find_spec", lambda name: None if missing == "mpi4py" else name)
    with pytest.raises(UsageError, match=rf"--ranks 3 requires {missing}.*\n?.*pip.* install '\.\[mpi\]' in the clone"):
        runs.start_together(3, ["run"])


def test_the_launcher_gets_the_command(monkeypatch, tmp_path):
    started = []
    (tmp_path / "mpiexec").touch()
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setattr(runs, "find_spec", lambda name: name)
    monkeypatch.setattr(runs.os, "execv", lambda *command: started.append(command))
    runs.start_together(3, ["run", "case.toml"])
    beside = str(tmp_path / "mpiexec")
    assert started == [(beside, [beside, "-n", "3", str(tmp_path / "python"), "-m", "pellucid", "run", "case.toml"])]
