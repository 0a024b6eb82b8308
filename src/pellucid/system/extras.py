"""Packages of extras (optional dependencies), imported when they are needed."""

import sys
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from pellucid.errors import UsageError


def install_command(extra: str) -> str:
    """Return the text of the command that installs an extra (a group of optional dependencies), for messages and help."""
    return f"{pip()} install '.[{extra}]' in the clone of pellucid"


def pip() -> str:
    """Return the command of pip for this environment, which may have been made without pip, as the README does."""
    return "pip" if find_spec("pip") else f"python3 -m pip --python {sys.prefix}"


def needed(module: str, extra: str, what: str) -> Any:
    """Import and return a module of an extra (a group of optional dependencies). Raises UsageError, with the installation
    command, if the module is not installed; what: the features that need the module, in the plural, for the message."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        package = module.partition(".")[0].replace("_", "-")
        text = f"{what} need {package}, but {error.name} is not installed"
        raise UsageError(f"{text}\n    Run {install_command(extra)}") from None
