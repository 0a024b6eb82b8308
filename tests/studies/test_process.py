import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

import pytest
from small_studies import SPEED, case, run_members_here

from pellucid.results.storage.files import lock_held
from pellucid.studies import pool
from pellucid.studies.members import FAILED, INTERRUPTED, Member, members_of, places, prepare
from pellucid.studies.pool import allow_running, end_running, run_member

SLEEP = "from pellucid.system.processes import terminated_with_parent\nterminated_with_parent()\nimport time\ntime.sleep(100)"


@pytest.fixture
def member(tmp_path: Path) -> Member:
    found = members_of(case(), [{SPEED: 2.0}])[0]
    prepare(tmp_path, [found])
    allow_running()
    return found


def commands(monkeypatch: pytest.MonkeyPatch, *statuses: int) -> list[list[str]]:
    """Give these exit statuses to the commands that are called; give those commands."""
    called: list[list[str]] = []
    left = list(statuses)

    def call(arguments: list[str], log: Path) -> int:
        called.append(arguments)
        log.write_text("of no interest\npellucid: it is broken\n    mend it\n")
        return left.pop(0)

    monkeypatch.setattr(pool, "_call", call)
    return called


def test_a_new_member_is_run(member: Member, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    called = commands(monkeypatch, 3)
    assert run_member(tmp_path, member.digest, 2, 0.5) == (FAILED, "it is broken\n    mend it")
    where = places(tmp_path, member.digest)
    options = ["--no-report", "--threads", "2", "--until", "0.5"]
    assert called == [["run", str(where.case), "--out", str(where.run), *options]]


def test_one_that_was_begun_goes_on(member: Member, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    begun = run_members_here(monkeypatch)
    from pellucid.studies.pool import run_member as run_here

    assert run_here(tmp_path, member.digest, 1, None).state == "done"
    assert begun == [member.digest]
    called = commands(monkeypatch, 143)
    assert run_member(tmp_path, member.digest, 1, None).state == "done"
    assert called == [], "what is done is left as it is"
    (places(tmp_path, member.digest).run / "summary.json").unlink()
    assert run_member(tmp_path, member.digest, 1, None).state == INTERRUPTED
    assert [command[0] for command in called] == ["resume"]


def test_one_that_cannot_go_on_is_run_anew(member: Member, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    where = places(tmp_path, member.digest)
    where.run.mkdir()
    (where.run / "case.toml").write_text("")
    called = commands(monkeypatch, 2, -9)
    assert "signal 9" in run_member(tmp_path, member.digest, 1, None).message
    assert [command[0] for command in called] == ["resume", "run"]


def test_a_member_waits_for_who_writes_in_its_folder(member: Member, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    called = commands(monkeypatch, 3)
    run = places(tmp_path, member.digest).run
    run.mkdir()
    waiting = Thread(target=run_member, args=(tmp_path, member.digest, 1, None))
    with lock_held(run):
        waiting.start()
        time.sleep(0.5)
        assert called == []
    waiting.join()
    assert len(called) == 1


def test_a_command_is_a_process_whose_words_are_kept(tmp_path: Path) -> None:
    allow_running()
    log = tmp_path / "log.txt"
    assert pool._call(["run", "no/such-case"], log) == 2
    assert "pellucid: " in log.read_text()


def test_running_members_end_when_they_are_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(pool, "BEGIN", SLEEP)
    allow_running()
    ended: list[int] = []
    thread = Thread(target=lambda: ended.append(pool._call([], tmp_path / "log.txt")))
    thread.start()
    while not pool._running:
        time.sleep(0.01)
    end_running()
    thread.join(timeout=20)
    assert ended == [-15]
    assert pool._call([], tmp_path / "log.txt") == 143, "and no other begins"


def test_a_member_ends_with_who_began_it() -> None:
    begun = subprocess.Popen([sys.executable, "-c", SLEEP], stdin=subprocess.PIPE)
    assert begun.stdin
    begun.stdin.close()
    assert begun.wait(timeout=20) == -15
