"""Files of the user in and beside the folder of a run: nothing that the program did not write is taken, changed or removed."""

import json
import os
import sys

import pytest
from free_flight import FakeSimulation, free_flight

from pellucid.case import loads
from pellucid.errors import CaseError, UsageError
from pellucid.results.storage.files import OutputError
from pellucid.results.storage.run_folder import RunFolder
from pellucid.running.launch import resume_case, run_case

pytestmark = pytest.mark.usefixtures("fake")


def contents(folder) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    "lock",
    [
        "",
        "12345\n",
        "{}",
        '{"pid": 1, "host": "here", "since": "today"}',
        '{"program": "another", "pid": 1}',
        "[1, 2]",
        "\x00\x80",
    ],
)
def test_a_folder_with_a_lock_of_another_program_is_left_alone(tmp_path, lock):
    (tmp_path / "run.lock").write_text(lock)
    (tmp_path / "history.csv").write_text("years of work")
    before = contents(tmp_path)
    with pytest.raises(
        UsageError, match=r"contains files that do not belong to a run \(its run\.lock was not written by pellucid"
    ):
        run_case(free_flight(), tmp_path)
    with pytest.raises(UsageError, match="contains no run"):
        resume_case(tmp_path)
    assert contents(tmp_path) == before


def test_a_foreign_lock_alone_is_not_written_over_but_an_empty_one_of_a_killed_run_is(tmp_path):
    (tmp_path / "run.lock").write_text("another")
    with pytest.raises(UsageError, match="was not written by pellucid"):
        run_case(free_flight(), tmp_path)
    (tmp_path / "run.lock").write_text("")
    assert run_case(free_flight(), tmp_path, report=False).finished


def test_a_run_whose_lock_lost_its_signature_is_known_by_its_case(tmp_path):
    run_case(free_flight(), tmp_path, until=0.3, report=False)
    (tmp_path / "run.lock").write_text("")
    assert resume_case(tmp_path, report=False).finished


def test_a_lock_that_cannot_be_signed_keeps_the_signature_before(tmp_path, monkeypatch):
    def full(*_arguments):
        raise OSError(28, os.strerror(28))

    run_case(free_flight(), tmp_path, until=0.3, report=False)
    with monkeypatch.context() as patch:
        patch.setattr(os, "pwrite", full)
        with RunFolder(tmp_path).held():
            pass
    assert json.loads((tmp_path / "run.lock").read_text())["program"] == "pellucid"


def add_own(out) -> dict[str, bytes]:
    """Files of the user in every folder of a run."""
    own = ("figures/mine.png", "figures/mine.gif", "fields/mine.vtkhdf", "checkpoint/mine.npz", "checkpoint/notes.txt")
    own = (*own, "forensics/mine.json", "forensics/mine.npz", "notes.txt", "figures/.mine.writing")
    for name in own:
        (out / name).parent.mkdir(exist_ok=True)
        (out / name).write_bytes(name.encode())
    return {name: name.encode() for name in own}


@pytest.mark.parametrize("again", [resume_case, lambda out: run_case(free_flight(**{"time.end": 0.3}), out)])
def test_files_of_the_user_in_the_folders_of_a_run_stay(tmp_path, again, fake, monkeypatch):
    monkeypatch.setattr(fake, "breaks_at", 9)
    with pytest.raises(Exception, match="point 7"):
        run_case(free_flight(), tmp_path)
    monkeypatch.setattr(fake, "breaks_at", None)
    own = add_own(tmp_path)
    assert (tmp_path / "figures/where_it_stopped.png").is_file()
    again(tmp_path)
    found = contents(tmp_path)
    assert {name: found.get(name) for name in own} == own
    assert "figures/where_it_stopped.png" not in found, "what the program drew goes"
    assert "forensics/failure.json" not in found
    assert "figures/energies.png" in found


def test_a_run_of_other_bodies_leaves_no_fields_of_the_one_before(tmp_path, monkeypatch):
    run_case(free_flight(), tmp_path, until=0.1, report=False)
    text = (tmp_path / "case.toml").read_bytes().partition(b"\n")[2].decode()
    other = text.replace('"gas"', '"air"')

    class Renamed(FakeSimulation):
        def __init__(self, *arguments, **more) -> None:
            super().__init__(*arguments, **more)
            self.bodies[0].name = "air"

    monkeypatch.setattr(sys.modules["pellucid.simulation.simulation"], "Simulation", Renamed)
    run_case(loads(other), tmp_path, until=0.1, report=False)
    assert sorted(path.name for path in (tmp_path / "fields").iterdir()) == ["air.vtkhdf", "block.vtkhdf"]


def test_nothing_is_said_or_removed_before_the_case_is_found_good(tmp_path, fake, monkeypatch):
    """What only the set-up finds: a body, or a file, that cannot be had."""
    run_case(free_flight(), tmp_path, report=False)
    before, said = contents(tmp_path), []

    class Listening:
        def __getattr__(self, name):
            return lambda *what, **more: said.append((name, *what))

    def bad(*_arguments, **_more):
        raise CaseError("no such points")

    with monkeypatch.context() as patch:
        patch.setattr(fake, "__init__", bad)
        with pytest.raises(CaseError, match="no such points"):
            run_case(free_flight(), tmp_path, progress=Listening())
    assert contents(tmp_path) == before
    assert [what for what in said if what[0] in ("message", "note")] == []
    run_case(free_flight(), tmp_path, progress=Listening(), report=False)
    assert ("note", f"replacing the earlier run in {tmp_path}") in said


def test_a_resumed_run_loses_nothing_before_its_files_are_found_whole(tmp_path):
    run_case(free_flight(), tmp_path, until=0.5, report=False)
    history = tmp_path / "history.csv"
    history.write_bytes(history.read_bytes().replace(b"0.12", b"0.13", 1))
    before = contents(tmp_path)
    with pytest.raises(OutputError, match="was changed"):
        resume_case(tmp_path)
    after = contents(tmp_path)
    assert {name: data for name, data in after.items() if name != "run.lock"} == {
        name: data for name, data in before.items() if name != "run.lock"
    }
