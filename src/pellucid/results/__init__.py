"""What a run leaves behind, and how it is read again; heavy imports only where they are used."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pellucid.results.launch import resume_case, run_case
    from pellucid.results.storage.run import Run

__all__ = ["Run", "resume_case", "run_case"]

_HOME = {"run_case": "pellucid.results.launch", "resume_case": "pellucid.results.launch", "Run": "pellucid.results.storage.run"}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOME[name]), name)
