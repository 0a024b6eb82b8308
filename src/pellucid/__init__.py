"""pellucid: membranes, fluids and soft tissue with particles and meshless approximants.

The names below are imported when first used, so that `import pellucid` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pellucid.case import Case as Case
    from pellucid.case import dumps as dumps
    from pellucid.case import load as load
    from pellucid.case import loads as loads
    from pellucid.errors import CaseError as CaseError
    from pellucid.errors import Interrupted as Interrupted
    from pellucid.errors import PellucidError as PellucidError
    from pellucid.errors import RunStopped as RunStopped
    from pellucid.results import Run as Run
    from pellucid.results import run as run
    from pellucid.simulation import Simulation as Simulation

_HOMES = {
    "Case": "pellucid.case",
    "dumps": "pellucid.case",
    "load": "pellucid.case",
    "loads": "pellucid.case",
    "CaseError": "pellucid.errors",
    "Interrupted": "pellucid.errors",
    "PellucidError": "pellucid.errors",
    "RunStopped": "pellucid.errors",
    "Run": "pellucid.results",
    "run": "pellucid.results",
    "Simulation": "pellucid.simulation",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("pellucid")
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'pellucid' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
