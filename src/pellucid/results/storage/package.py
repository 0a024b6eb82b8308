"""Version of the package that made a run."""

import shutil
import subprocess
from importlib.metadata import version
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "__init__.py"


def package_version() -> str:
    """The version of the package."""
    return version("pellucid")


def package_release() -> str:
    """The release that a version is of, or goes towards: runs go on with any state of the source on the way to it."""
    return package_version().partition("+")[0].partition(".dev")[0]


def package_commit() -> str:
    """The git commit of the package's source where it is a checkout, else empty."""
    git = shutil.which("git")
    if git is None:
        return ""
    call = [git, "-C", str(SOURCE.parent)]
    # an environment inside someone's checkout is not a checkout of the package: git must know this very file
    tracked = subprocess.run([*call, "ls-files", "--error-unmatch", SOURCE.name], capture_output=True, check=False)
    if tracked.returncode:
        return ""
    head = subprocess.run([*call, "rev-parse", "HEAD"], capture_output=True, text=True, check=False)
    return head.stdout.strip()
