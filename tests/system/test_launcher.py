import sys

import pytest

from pellucid.errors import UsageError
from pellucid.system import launcher

COMMAND = ["run", "case.toml", "--ranks", "4", "--quick", "--ranks=2", "--set", "a=--ranks"]


def test_the_option_and_its_value_are_taken_out():
    assert launcher.without("--ranks", COMMAND) == ["run", "case.toml", "--quick", "--set", "a=--ranks"]
    assert launcher.without("--ranks", ["run", "--ranks"]) == ["run"]


def test_one_process_starts_none(monkeypatch):
    monkeypatch.setattr(launcher.os, "execv", None)
    launcher.start_together(1, ["run"])


@pytest.mark.parametrize("missing", ["mpiexec", "mpi4py"])
def test_what_is_missing_is_named_with_its_extra(monkeypatch, tmp_path, missing):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setattr(launcher.shutil, "which", lambda name: None if missing == "mpiexec" else f"/bin/{name}")
    monkeypatch.setattr(launcher, "find_spec", lambda name: None if missing == "mpi4py" else name)
    with pytest.raises(UsageError, match=rf"--ranks 3 requires {missing}.*\n?.*pip.* install '\.\[mpi\]' in the clone"):
        launcher.start_together(3, ["run"])


def test_the_launcher_gets_the_command(monkeypatch, tmp_path):
    started = []
    (tmp_path / "mpiexec").touch()
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setattr(launcher, "find_spec", lambda name: name)
    monkeypatch.setattr(launcher.os, "execv", lambda *command: started.append(command))
    launcher.start_together(3, ["run", "case.toml"])
    beside = str(tmp_path / "mpiexec")
    assert started == [(beside, [beside, "-n", "3", str(tmp_path / "python"), "-m", "pellucid", "run", "case.toml"])]
