import time
from pathlib import Path
from threading import Thread

import pytest
from small_studies import SPEED, case, run_members_here

from pellucid.case import Case
from pellucid.results.storage.files import lock_held
from pellucid.running.launch import run_case
from pellucid.studies import pool
from pellucid.studies.members import FAILED, INTERRUPTED, Member, members_of, places, prepare
from pellucid.studies.pool import allow_running, end_running, run_member

SLEEP = """
import time
from pellucid.system.command_process import execute_commands
execute_commands(lambda: lambda: time.sleep(100), lambda: True)
"""


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

    def call(arguments: list[str], log: Path, threads: int) -> int:
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


def test_a_process_runs_one_member_after_the_other(tmp_path: Path) -> None:
    allow_running()
    assert pool._call(["list"], tmp_path / "1.txt", 1) == 0
    (_, _, process), *others = pool._idle
    assert others == []
    assert pool._call(["doctor", "--no-such-option"], tmp_path / "2.txt", 1) == 2, "by the same process"
    assert pool._idle == [], "which ends after a failure"
    assert not process.is_alive
    assert "gan2011/shock-tube" in (tmp_path / "1.txt").read_text()
    assert "no-such-option" in (tmp_path / "2.txt").read_text()
    end_running()


def test_members_with_other_threads_get_other_processes(tmp_path: Path) -> None:
    allow_running()
    for threads in 1, 2, 1:
        assert pool._call(["--version"], tmp_path / "log.txt", threads) == 0
    assert sorted(threads for threads, _, _ in pool._idle) == [1, 2]
    waiting = [process for _, _, process in pool._idle]
    end_running()
    assert not any(process.is_alive for process in waiting)


def test_a_process_without_members_ends(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(pool, "IDLE", 0.1)
    allow_running()
    assert pool._call(["--version"], tmp_path / "log.txt", 1) == 0
    while pool._idle:
        time.sleep(0.01)


def test_a_process_that_was_killed_while_it_waited_is_replaced(tmp_path: Path) -> None:
    allow_running()
    assert pool._call(["--version"], tmp_path / "log.txt", 1) == 0
    process = pool._idle[0][2]._process
    process.kill()
    process.wait()
    assert pool._call(["--version"], tmp_path / "log.txt", 1) == 0
    end_running()


def test_running_members_end_when_they_are_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(pool, "PROGRAM", SLEEP)
    allow_running()
    ended: list[int] = []
    thread = Thread(target=lambda: ended.append(pool._call([], tmp_path / "log.txt", 1)))
    thread.start()
    while not pool._running:
        time.sleep(0.01)
    end_running()
    thread.join(timeout=20)
    assert ended == [-15]
    assert pool._call([], tmp_path / "log.txt", 1) == 143, "and no other begins"


def test_members_in_one_process_have_the_bits_of_single_runs(tmp_path: Path) -> None:
    table = {"schema": 1, "title": "A sheet", "time": {"end": 1.0}, "steady": {}}
    surface = {"disc": {"centre": [0, 0, 0], "normal": [0, 0, 1], "radius": 1, "rings": 3}}
    law = {"kind": "linear-membrane", "density": 1000, "young_modulus": 1e9, "poisson_ratio": 0.3}
    body = {"name": "sheet", "kind": "membrane-elements", "elements": "triangles", "surface": surface, "thickness": 1e-3}
    support, pressure = {"body": "sheet", "where": "boundary"}, {"body": "sheet", "value": 100}
    sheet = Case.model_validate(table | {"body": [body | {"material": law}], "support": [support], "pressure": [pressure]})
    members = members_of(sheet, [{"pressure.0.value": value} for value in (50.0, 100.0)])
    prepare(tmp_path, members)
    allow_running()
    for member in members:
        assert run_member(tmp_path, member.digest, 1, None).state == "done"
        assert len(pool._idle) == 1
    end_running()
    for member in members:
        run_case(member.case, tmp_path / "alone", threads=1, report=False)
        alone = (tmp_path / "alone" / "history.csv").read_bytes()
        assert (places(tmp_path, member.digest).run / "history.csv").read_bytes() == alone
