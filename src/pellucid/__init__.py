"""pellucid: membranes, fluids and soft tissue with particles and meshless approximants.

A case file is read by `load`, computed by `run`, and its results are read by `Run`. The names below are imported when first
used, so that `import pellucid` stays light.
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
    from pellucid.results.run import Run as Run
    from pellucid.running.launch import recorded as recorded
    from pellucid.running.launch import resume_case, run_case
    from pellucid.simulation.simulation import Simulation as Simulation
    from pellucid.studies.fit import fit as fit
    from pellucid.studies.sweep import sweep as sweep

    run, resume = run_case, resume_case

_HOMES = {
    "Case": "case.Case",
    "dumps": "case.dumps",
    "load": "case.load",
    "loads": "case.loads",
    "CaseError": "errors.CaseError",
    "Interrupted": "errors.Interrupted",
    "PellucidError": "errors.PellucidError",
    "RunStopped": "errors.RunStopped",
    "Run": "results.run.Run",
    "run": "running.launch.run_case",
    "resume": "running.launch.resume_case",
    "recorded": "running.launch.recorded",
    "Simulation": "simulation.simulation.Simulation",
    "fit": "studies.fit.fit",
    "sweep": "studies.sweep.sweep",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("pellucid")
    if name in _HOMES:
        module, _, attribute = _HOMES[name].rpartition(".")
        return getattr(import_module(f"pellucid.{module}"), attribute)
    raise AttributeError(f"module 'pellucid' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
