"""Version and git commit of the package."""

import shutil
import subprocess
from importlib.metadata import version
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "__init__.py"


def package_version() -> str:
    """Return the version of the pellucid package."""
    return version("pellucid")


def package_release() -> str:
    """Return the release number without development suffixes. A run can be resumed with any development version of the same
    release."""
    return package_version().partition("+")[0].partition(".dev")[0]


def package_commit() -> str:
    """Return the git commit of the package's source; empty if the source is not a git checkout."""
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
