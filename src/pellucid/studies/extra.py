"""Packages of the extra `sweep`, imported where they are needed."""

from importlib import import_module
from typing import Any

from pellucid.errors import UsageError


def need(module: str) -> Any:
    """A module of the extra. Raises UsageError with what to install where it is not there."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        package = module.partition(".")[0].replace("_", "-")
        text = f"sweeps and fits need {package}, and {error.name} is not installed"
        raise UsageError(f"{text}\n    pip install 'pellucid[sweep]'") from None
