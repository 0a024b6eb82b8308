"""Folders that a run leaves alone: one in which another process runs, and those of the user."""

import errno
import os

import pytest
from commands_of_runs import hold
from free_flight import free_flight
from other_processes import PATIENCE, killed_at_last, pipe

import pellucid
from pellucid.errors import UsageError
from pellucid.results.report.report import write_report
from pellucid.results.storage import files
from pellucid.results.storage.files import OutputError
from pellucid.running.launch import resume_case, run_case

pytestmark = pytest.mark.usefixtures("fake")


@pytest.fixture
def live(tmp_path):
    """The folder of a run that goes on in another process until the test ends."""
    out = tmp_path / "run"
    run_case(free_flight(), out, until=0.3, report=False)
    here, there = pipe()
    with killed_at_last(hold, out, there) as process:
        assert here.poll(PATIENCE)
        yield out, process


@pytest.mark.parametrize("command", [lambda out: run_case(free_flight(), out), resume_case, write_report])
def test_a_folder_in_which_another_process_runs_is_left_alone(live, command):
    out, process = live
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    with pytest.raises(
        UsageError, match=rf"process {process.pid} on .*, since 20.* is writing to .*run\.\n.*Wait until it has finished"
    ):
        command(out)
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before


def test_the_lock_goes_with_a_killed_process(live):
    out, process = live
    process.kill()
    process.join(PATIENCE)
    assert resume_case(out, report=False).finished


def test_a_disk_without_room_for_the_lock_ends_in_a_message(tmp_path, monkeypatch):
    def full(*_arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(files.os, "open", full)
    with pytest.raises(OutputError, match=r"No space left on device\n.*Free disk space, then start the run again"):
        run_case(free_flight(), tmp_path / "run")


def test_a_folder_with_a_case_of_the_user_is_left_alone(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text("# mine\n" + pellucid.dumps(free_flight()))
    before = case.read_text()
    with pytest.raises(UsageError, match="contains files that do not belong to a run"):
        run_case(free_flight(), tmp_path)
    with pytest.raises(UsageError, match=r"contains no run: it has no run\.lock"):
        resume_case(tmp_path)
    assert case.read_text() == before
    assert list(tmp_path.iterdir()) == [case]


def test_a_case_that_was_changed_by_hand_is_not_replaced(tmp_path):
    run = run_case(free_flight(), tmp_path, report=False)
    edited = run.folder.case.read_text().replace("Free flight", "Free flight, my own")
    run.folder.case.write_text(edited)
    with pytest.raises(UsageError, match=r"case\.toml has changed since its run started"):
        run_case(free_flight(), tmp_path)
    assert run.folder.case.read_text() == edited
