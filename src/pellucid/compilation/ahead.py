"""Kernels compiled into the cache by other processes, from the last one back, while this one compiles the first ones."""

import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from pellucid.system.processes import Helper, free_cores, helped

if TYPE_CHECKING:
    from pellucid.case import Case

MOST_HELPERS = 3
NICENESS = 10  # of the other processes: where cores are few, the one that needs the kernels goes first
MOST_SECONDS = 120  # of a core; state that no kernel has filled may send a search round for ever
MOST_MEMORY = 0.05  # of the machine's that the bodies may take once more


@contextmanager
def compiled_ahead(case: "Case") -> Iterator[Callable[[], None]]:
    """Gives a function by which other processes begin to compile the kernels of a case, if cores and memory allow.

    They end with the block. Nothing depends on them: kernels that they have put into the cache are found there.
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
    """Compile the kernels of a case, written as TOML, from the last one back, every so many from the first on; then end."""
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
    """The kernels of a case with the types of their arguments, as set-up, a step and results call them one after the other.

    None of them is run: what depends on their results may go wrong, and what would follow is not known then.
    """
    from pellucid.jit.kernel_tracing import record_kernel_calls
    from pellucid.simulation.simulation import Simulation

    with record_kernel_calls() as calls, suppress(Exception), warnings.catch_warnings(action="ignore"):
        simulation = Simulation(case, threads=1)
        simulation.advance_bodies()
        for body in simulation.bodies:
            for name in body.field_names:
                body.stored_field(name)
    return list(calls)
