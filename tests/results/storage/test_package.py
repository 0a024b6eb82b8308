import shutil
import subprocess

import pytest

from pellucid.results.storage import identity


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
    monkeypatch.setattr(identity, "SOURCE", source)
    return tmp_path


def test_a_package_installed_inside_a_checkout_has_no_commit(checkout):
    assert identity.package_commit() == ""


def test_a_package_that_git_knows_has_its_commit(checkout):
    subprocess.run(["git", "-C", checkout, "add", "."], check=True)
    head = subprocess.run(["git", "-C", checkout, "rev-parse", "HEAD"], check=True, capture_output=True, text=True)
    assert identity.package_commit() == head.stdout.strip()


def test_without_git_there_is_no_commit(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert identity.package_commit() == ""
