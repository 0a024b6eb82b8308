"""Compilation of a case's kernels into the cache by other processes, from the last kernel backwards, while this process
compiles the first ones."""

import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from pellucid.system.processes import Helper, free_cores, helped

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
        if not helpers and _is_small(case):
            number = min(MOST_HELPERS, free_cores())
            with suppress(Exception):
                from pellucid.case import dumps

                helpers.extend(Helper(compile_from_the_end, dumps(case), k, number) for k in range(number))

    with helped(helpers):
        yield begin


def _is_small(case: "Case") -> bool:
    from pellucid.case.memory import PROGRAM_BYTES, memory_estimate, physical_memory

    return memory_estimate(case) - PROGRAM_BYTES < MOST_MEMORY * (physical_memory() or 0)


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
