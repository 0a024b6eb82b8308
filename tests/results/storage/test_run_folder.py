import errno
import os

import pytest
from free_flight import free_flight

from pellucid.errors import UsageError
from pellucid.results.storage import run_folder
from pellucid.results.storage.files import OutputError, explained


def begin(path):
    folder = run_folder.RunFolder(path)
    with folder.made():
        folder.start(free_flight())


def test_a_folder_below_a_file_is_a_bad_argument(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match=r"cannot write results to .*sub: Not a directory\n.*Set `--out` to a writable folder"):
        begin(tmp_path / "file/sub")


@pytest.mark.parametrize("code", [errno.EACCES, errno.EROFS, errno.ENOENT])
def test_a_folder_that_cannot_be_made_is_a_bad_argument(code, tmp_path, monkeypatch):
    def refuse(*arguments, **options):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(run_folder.Path, "mkdir", refuse)
    with pytest.raises(UsageError, match=os.strerror(code)) as caught:
        begin(tmp_path / "out")
    assert caught.value.exit_status == 2


@pytest.mark.parametrize(
    ("code", "remedy"),
    [
        (errno.ENOSPC, "Free disk space"),
        (errno.EDQUOT, "Free disk space"),
        (errno.EFBIG, "Free disk space"),
        (errno.EIO, "Correct the cause"),
    ],
)
def test_a_full_or_failing_disk_stops_the_run(code, remedy, tmp_path):
    with pytest.raises(OutputError, match=f"{remedy}, then start the run again") as caught, explained(tmp_path):
        raise OSError(code, os.strerror(code))
    assert caught.value.exit_status == 3
