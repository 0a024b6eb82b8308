"""Compilation of kernels into the cache in advance, in parallel for several cases."""

import warnings
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryFile
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

from pellucid.compilation.reporting import laws_blamed
from pellucid.errors import PellucidError, UsageError
from pellucid.jit import cache_folder
from pellucid.progress import Progress, WarningsOnly
from pellucid.results.storage.start import read_start
from pellucid.system.processes import Helper, free_cores, helped, shared

if TYPE_CHECKING:
    from pellucid.case import Case


class Warmed(NamedTuple):
    """Result of compiling the kernels of one case, for the table that `pellucid warm` prints: name of the case, number of
    kernels, duration [s], and error."""

    case: str  # name of the case
    kernels: int  # number of compiled kernels
    seconds: float  # duration of the compilation [s]
    trouble: str = ""  # error if not all kernels were compiled


def warm(cases: "Mapping[str, Case]", progress: Progress | None = None) -> list[Warmed]:
    """Compile the kernels of set-up and first step of the cases, given by name, into the cache. Nothing else is written.

    Only the first of several cases with the same kernels is compiled. Kernels that are needed later in a run, e.g. when a
    membrane tears, are compiled by the run. Raises `UsageError` if the cache cannot be written.
    """
    from pellucid.case import dumps

    _check_writable(cache_folder())
    jobs = [(name, dumps(case)) for name, case in _different(cases).items()]
    helpers = [Helper(_warmer) for _ in range(min(free_cores(), len(jobs) - 1))]
    progress = progress or WarningsOnly()
    progress.begin("compiling", len(jobs))
    with helped(helpers):
        return shared(jobs, compile_case, helpers, progress.count)


def _check_writable(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
    except OSError as error:
        text = f"Compiled kernels cannot be stored in {folder}: {error.strerror}"
        raise UsageError(f"{text}.\n    Free disk space, or set NUMBA_CACHE_DIR to another folder.") from None


def compile_case(job: tuple[str, str]) -> Warmed:
    """Compile the kernels of a case; job: name of the case and its text in TOML. Return number, duration and error."""
    from numba.core.event import RecordingListener, install_listener

    from pellucid.case import check_memory, loads
    from pellucid.jit.cache import NotKept
    from pellucid.simulation.simulation import Simulation

    name, text = job
    begun, compiled, trouble = monotonic(), RecordingListener(), ""
    with install_listener("numba:compile", compiled), warnings.catch_warnings(action="ignore"):
        warnings.simplefilter("error", NotKept)
        try:
            case = loads(text)
            check_memory(case)
            with laws_blamed(case):
                simulation = Simulation(case, threads=1, start=read_start(case, lambda text: None))
                simulation.step()
                for body in simulation.bodies:
                    for field in body.field_names:
                        body.field(field)
        except (PellucidError, NotKept) as error:
            trouble = str(error)
    return Warmed(name, len(compiled.buffer) // 2, monotonic() - begun, trouble)


def _different(cases: "Mapping[str, Case]") -> "dict[str, Case]":
    """Return one case for each set of kernels, by name; a case is returned in its quick variant (with its settings for a
    run within seconds) if this variant needs the same kernels."""
    from pellucid.compilation.kernel_key import kernel_key

    chosen: dict[str, tuple[str, Case]] = {}
    for name, case in cases.items():
        key, quick = kernel_key(case), case.quick_variant()
        chosen.setdefault(key, (name, quick if kernel_key(quick) == key else case))
    return dict(chosen.values())


def _warmer() -> Any:
    return compile_case
