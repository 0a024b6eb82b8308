"""Other processes of the tests, of which some are killed.

They begin as copies of a process that has no threads. Copies of this one, whose threads may hold locks, might wait for ever.
"""

import multiprocessing
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from free_flight import fake_module

from pellucid.errors import UsageError

PATIENCE = 120.0  # s, for a busy machine
REFUSED = 2  # exit status
IMPORTED = ["numba", "h5py", "pytest", "pellucid.case", "pellucid.running.launch", "pellucid.compilation.ahead"]

_context = multiprocessing.get_context("forkserver")
_context.set_forkserver_preload(IMPORTED)


def start_together(works: Sequence[Callable], *arguments: object) -> list[BaseProcess]:
    """Other processes that begin their works at once, when all of them are there. Runs are made by the fake simulation there.

    They exit with `REFUSED` where another one is writing to the run's folder.
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
    """Another process at work, which is killed at the end of the block."""
    (process,) = start_together([work], *arguments)
    try:
        yield process
    finally:
        process.kill()
        process.join(PATIENCE)
        assert process.exitcode is not None


def pipe() -> tuple[Connection, Connection]:
    """Two ends, of which the second is for the other process."""
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
