"""Start of several MPI processes that share the run of a command."""

import os
import shutil
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from pellucid.errors import UsageError
from pellucid.system.extras import install_command

LAUNCHER = "mpiexec"
INSTALL = f"Run {install_command('mpi')}, or install mpi4py for the MPI of the machine."


def start_together(processes: int, arguments: Sequence[str]) -> None:
    """Replace this process by the MPI launcher, which starts `processes` processes of this program with the command line
    `arguments`; do nothing for one process.

    Raises UsageError if MPI is not installed.
    """
    if processes == 1:
        return
    beside = Path(sys.executable).parent / LAUNCHER
    launcher = str(beside) if beside.is_file() else shutil.which(LAUNCHER)
    if launcher is None or find_spec("mpi4py") is None:
        missing = LAUNCHER if launcher is None else "mpi4py"
        raise UsageError(f"--ranks {processes} requires {missing}, which is not installed.\n    {INSTALL}")
    sys.stdout.flush()
    os.execv(launcher, [launcher, "-n", str(processes), sys.executable, "-m", "pellucid", *arguments])


def without(option: str, arguments: Sequence[str]) -> list[str]:
    """Return the arguments of a command line without the option `option`, such as "--ranks", and without its value."""
    left, skip = list[str](), False
    for argument in arguments:
        if not (skip or argument == option or argument.startswith(f"{option}=")):
            left.append(argument)
        skip = argument == option
    return left
