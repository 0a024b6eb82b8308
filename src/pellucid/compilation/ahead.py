"""Compilation of kernels into the cache by other processes: ahead of a run, and in advance for several cases."""

import os
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
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


MOST_HELPERS = 3  # largest number of other processes
NICENESS = 10  # of the other processes: on few cores, the process that needs the kernels has priority
MOST_SECONDS = 120  # limit of computing time [s]: as kernels are not executed, a loop over their results may not end
MOST_MEMORY = 0.05  # largest memory of the bodies over that of the machine: each process builds the bodies again


@contextmanager
def compiled_ahead(case: "Case") -> Iterator[Callable[[], None]]:
    """Context manager that yields a function. A call of this function starts the compilation of a case's kernels in other
    processes, if cores and memory allow.

    The processes are stopped at the end of the block. Results of a run do not depend on these processes: the run finds the
    kernels that they have compiled in the cache.
    """
    helpers: list[Helper] = []

    def begin() -> None:
        from pellucid.case.memory import PROGRAM_BYTES, memory_estimate, physical_memory

        if not helpers and memory_estimate(case) - PROGRAM_BYTES < MOST_MEMORY * (physical_memory() or 0):
            number = min(MOST_HELPERS, free_cores())
            with suppress(Exception):
                from pellucid.case import dumps

                helpers.extend(Helper(compile_from_the_end, dumps(case), k, number) for k in range(number))

    with helped(helpers):
        yield begin


def compile_from_the_end(text: str, first: int, step: int) -> None:
    """Compile every `step`-th kernel of a case, from the last one backwards, then end the process.

    text: the case as TOML. first: index of the first kernel to compile in the reversed list of kernels.
    """
    import resource

    os.nice(NICENESS)
    resource.setrlimit(resource.RLIMIT_CPU, (MOST_SECONDS, MOST_SECONDS))
    from pellucid.case import loads
    from pellucid.jit.cache import NotKept

    warnings.simplefilter("error", NotKept)  # then there is no use in this
    calls = kernels_of(loads(text))
    for compiled, arguments in calls[::-1][first::step]:
        compiled.compile(arguments)
    os._exit(0)


def kernels_of(case: "Case") -> list[tuple[Any, tuple[Any, ...]]]:
    """Return the kernels of a case with the types of their arguments, in the order in which a run calls them: set-up, a step,
    results.

    The kernels are not executed. Code that depends on their results may fail; the kernels after this failure are then missing.
    """
    from pellucid.jit.calls import record_kernel_calls
    from pellucid.simulation.simulation import Simulation

    with record_kernel_calls() as calls, suppress(Exception), warnings.catch_warnings(action="ignore"):
        simulation = Simulation(case, threads=1)
        simulation.advance_bodies()
        for body in simulation.bodies:
            for name in body.field_names:
                body.stored_field(name)
    return list(calls)


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
    from pellucid.compilation.reporting import kernel_key

    chosen: dict[str, tuple[str, Case]] = {}
    for name, case in cases.items():
        key, quick = kernel_key(case), case.quick_variant()
        chosen.setdefault(key, (name, quick if kernel_key(quick) == key else case))
    return dict(chosen.values())


def _warmer() -> Any:
    return compile_case
