"""Errors of the system while results are written: one sentence, the checkpoints intact, and the run goes on later."""

import errno
import json
import os
from pathlib import Path

import numpy as np
import pytest
from commands_of_runs import results
from free_flight import free_flight
from typer.testing import CliRunner

from pellucid.cli import app
from pellucid.errors import UsageError
from pellucid.results.storage import checkpoint, files, history, vtkhdf
from pellucid.results.storage.files import OutputError
from pellucid.running.launch import resume_case, run_case

pytestmark = pytest.mark.usefixtures("fake")

PATH_OPEN = Path.open
WRITERS = {
    "a row": (history.os, "write"),
    "bytes of a frame": (vtkhdf, "put"),
    "the opened fields": (vtkhdf.Path, "open"),
    "a checkpoint": (checkpoint.np, "savez"),
    "a rename": (files.os, "replace"),
    "the disk": (files.os, "fsync"),
}


def failing(code, after):
    """A call that fails with an error of the system at the call of this number and all later ones."""
    calls = iter(range(10**6))

    def wrap(original):
        def call(*arguments, **more):
            reads = original is PATH_OPEN and not {*"wa+"} & {*"".join(arguments[1:2])}
            if not reads and next(calls) >= after:
                raise OSError(code, os.strerror(code), "somewhere")
            return original(*arguments, **more)

        return call

    return wrap


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return tmp_path_factory.mktemp("whole") / "run"


TRIALS = [
    *((writer, 0, code) for writer in WRITERS for code in (errno.ENOSPC, errno.EIO)),
    *((writer, 3, errno.ENOSPC) for writer in WRITERS if writer != "a rename"),
    *(("a row", 1, code) for code in (errno.EROFS, errno.EDQUOT, errno.EACCES, errno.ESTALE)),
]


@pytest.mark.parametrize(("writer", "after", "code"), TRIALS)
def test_an_error_of_any_writer_leaves_a_run_that_goes_on(tmp_path, monkeypatch, whole, writer, code, after):
    if not whole.exists():
        run_case(free_flight(), whole, report=False)
    out = tmp_path / "run"
    run_case(free_flight(**{"output.checkpoint": 1e-9}), out, until=0.2, report=False)
    place, name = WRITERS[writer]
    with monkeypatch.context() as patch:
        patch.setattr(place, name, failing(code, after)(getattr(place, name)))
        with pytest.raises((OutputError, UsageError)) as caught:
            resume_case(out, report=False)
    message = str(caught.value)
    assert os.strerror(code) in message
    assert str(out) in message
    assert len(message.splitlines()) == 2, "a sentence, and what to do"
    assert checkpoint.read_latest(out / "checkpoint", pytest.fail) is not None
    assert not [path for path in out.rglob("*") if path.name.endswith(".writing")]
    resume_case(out, report=False)
    assert results(out) == results(whole)


def test_an_error_of_hdf5_while_a_frame_is_written_is_told(tmp_path, monkeypatch):
    out = tmp_path / "run"
    run_case(free_flight(**{"output.checkpoint": 1e-9}), out, until=0.2, report=False)

    class Broken:
        def __init__(self, *_arguments, **_more):
            raise RuntimeError("Unspecified error in H5Fopen (return value < 0)")

    with monkeypatch.context() as patch:
        patch.setattr(vtkhdf.h5py, "File", Broken)
        with pytest.raises(OutputError, match=r"vtkhdf.*\n?.*Unspecified error in H5Fopen"):
            resume_case(out, report=False)
    assert resume_case(out, report=False).finished


def test_a_checkpoint_that_cannot_be_read_is_not_taken_for_damaged(tmp_path, monkeypatch):
    out = tmp_path / "run"
    run_case(free_flight(), out, until=0.5, report=False)

    def refused(*_arguments, **_more):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    before = sorted(path.name for path in (out / "checkpoint").iterdir())
    with monkeypatch.context() as patch:
        patch.setattr(checkpoint, "_digest", refused)
        with pytest.raises(OutputError, match=r"cannot read .*npz: Permission denied\n"):
            resume_case(out)
    assert sorted(path.name for path in (out / "checkpoint").iterdir()) == before
    assert resume_case(out, report=False).finished


@pytest.mark.parametrize("command", [["resume", "RUN"], ["report", "RUN"], ["run", "CASE", "--out", "RUN"]])
def test_a_command_ends_in_a_sentence_whatever_cannot_be_written(tmp_path, monkeypatch, command):
    from pellucid.case import dumps

    out, case = tmp_path / "run", tmp_path / "mine.toml"
    case.write_text(dumps(free_flight()))
    run_case(free_flight(), out, until=0.5, report=False)
    words = [str({"RUN": out, "CASE": case}.get(word, word)) for word in command]
    with monkeypatch.context() as patch:
        patch.setattr(files.os, "replace", failing(errno.EIO, 0)(os.replace))
        result = CliRunner().invoke(app, words)
    assert result.exit_code == 3, result.output
    assert f"pellucid: cannot write the results to {out}: Input/output error" in result.stderr
    assert "Traceback" not in result.output


def test_an_error_that_nobody_foresaw_names_the_path_and_what_to_do(tmp_path, monkeypatch):
    def fails(*_arguments):
        raise OSError(errno.EIO, os.strerror(errno.EIO), str(tmp_path / "some\x1bwhere"))

    import pellucid.catalogue

    monkeypatch.setattr(pellucid.catalogue, "ids", fails)
    result = CliRunner().invoke(app, ["list"])
    assert result.exit_code == 3
    assert result.stderr.startswith(f"pellucid: {tmp_path}/some\\x1bwhere: Input/output error\n    Correct this")


def test_a_full_disk_at_a_stop_does_not_hide_why_it_stopped(tmp_path, fake, monkeypatch):
    monkeypatch.setattr(fake, "breaks_at", 9)
    monkeypatch.setattr(np, "savez", failing(errno.ENOSPC, 0)(np.savez))
    with pytest.raises(Exception, match="point 7 of gas is lost") as caught:
        run_case(free_flight(), tmp_path / "run", report=False)
    assert any("forensic dump could not be written" in note for note in caught.value.__notes__)
    assert json.loads((tmp_path / "run/forensics/failure.json").read_text())["point"] == 7
