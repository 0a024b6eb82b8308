"""Processes that tests start in addition to their own, some of which are killed.

They are forked from a server process without threads. A fork of this process, whose threads may hold locks, could wait for
ever.
"""

import multiprocessing
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from free_flight import fake_module

from pellucid.errors import UsageError

PATIENCE = 120.0  # longest time to wait for a process [s], on a busy machine
REFUSED = 2  # exit status of a process that finds the run folder in use
IMPORTED = ["numba", "h5py", "pytest", "pellucid.case", "pellucid.running.launch", "pellucid.compilation.ahead"]

_context = multiprocessing.get_context("forkserver")
_context.set_forkserver_preload(IMPORTED)


def start_together(works: Sequence[Callable], *arguments: object) -> list[BaseProcess]:
    """Start a process for each function in `works`, all at the same time, and return the processes. They use the fake
    simulation of `free_flight`.

    A process exits with `REFUSED` if another one is writing to the folder of the run.
    """
    processes, ends = [], []
    for work in works:
        here, there = pipe()
        process = _context.Process(target=_do, args=(there, work, arguments), daemon=True)
        process.start()
        processes.append(process)
        ends.append(here)
    for end in ends:
        assert end.poll(PATIENCE), "a process did not begin"
    for end in ends:
        end.send(True)
    return processes


@contextmanager
def killed_at_last(work: Callable, *arguments: object) -> Iterator[BaseProcess]:
    """Yield a process that executes a function, and kill it at the end of the block."""
    (process,) = start_together([work], *arguments)
    try:
        yield process
    finally:
        process.kill()
        process.join(PATIENCE)
        assert process.exitcode is not None


def pipe() -> tuple[Connection, Connection]:
    """Return the two ends of a pipe; the second is for the other process."""
    return _context.Pipe()


def _do(end: Connection, work: Callable, arguments: tuple) -> None:
    sys.modules["pellucid.simulation.simulation"] = fake_module()
    end.send(True)
    end.recv()  # until all are there
    try:
        work(*arguments)
    except UsageError as error:
        if "is writing to" in str(error):
            sys.exit(REFUSED)
        raise
