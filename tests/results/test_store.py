import errno
import os
import shutil
import subprocess

import pytest
from free_flight import free_flight

import pellucid
from pellucid.errors import UsageError
from pellucid.results import store
from pellucid.results.files import OutputError, explained


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A checkout of something with a package in it that git does not know."""
    if shutil.which("git") is None:
        pytest.skip("needs git")
    source = tmp_path / "environment/pellucid/__init__.py"
    source.parent.mkdir(parents=True)
    source.write_text("")
    for arguments in (
        ["init", "-q"],
        ["-c", "user.name=a", "-c", "user.email=b", "commit", "-q", "--allow-empty", "-m", "x"],
    ):
        subprocess.run(["git", "-C", tmp_path, *arguments], check=True)
    monkeypatch.setattr(pellucid, "__file__", str(source))
    return tmp_path


def test_a_package_installed_inside_a_checkout_has_no_commit(checkout):
    assert store.package_commit() == ""


def test_a_package_that_git_knows_has_its_commit(checkout):
    subprocess.run(["git", "-C", checkout, "add", "."], check=True)
    head = subprocess.run(["git", "-C", checkout, "rev-parse", "HEAD"], check=True, capture_output=True, text=True)
    assert store.package_commit() == head.stdout.strip()


def test_without_git_there_is_no_commit(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert store.package_commit() == ""


def test_a_folder_below_a_file_is_a_bad_argument(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match=r"cannot write results to .*sub: Not a directory\n.*name a folder"):
        store.RunFolder(tmp_path / "file/sub").start(free_flight())


@pytest.mark.parametrize("code", [errno.EACCES, errno.EROFS, errno.ENOENT])
def test_a_folder_that_cannot_be_made_is_a_bad_argument(code, tmp_path, monkeypatch):
    def refuse(*arguments, **options):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(store.Path, "mkdir", refuse)
    with pytest.raises(UsageError, match=os.strerror(code)) as caught:
        store.RunFolder(tmp_path / "out").start(free_flight())
    assert caught.value.exit_status == 2


@pytest.mark.parametrize(
    ("code", "remedy"),
    [(errno.ENOSPC, "make room"), (errno.EDQUOT, "make room"), (errno.EFBIG, "make room"), (errno.EIO, "mend this")],
)
def test_a_full_or_failing_disk_stops_the_run(code, remedy, tmp_path):
    with pytest.raises(OutputError, match=f"{remedy} and start again") as caught, explained(tmp_path):
        raise OSError(code, os.strerror(code))
    assert caught.value.exit_status == 3
