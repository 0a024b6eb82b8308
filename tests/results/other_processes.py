"""Other processes of the tests, of which some are killed.

They begin as copies of a process that has no threads. Copies of this one, whose threads may hold locks, might wait for ever.
"""

import multiprocessing
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from free_flight import fake_module

from pellucid.errors import UsageError

PATIENCE = 120.0  # s, for a busy machine
REFUSED = 2  # exit status
IMPORTED = ["numba", "h5py", "pytest", "pellucid.case", "pellucid.results.launch", "pellucid.simulation.ahead"]

_context = multiprocessing.get_context("forkserver")
_context.set_forkserver_preload(IMPORTED)


def start(work: Callable, *arguments: object) -> BaseProcess:
    """Another process that has just begun its work. Runs are made by the fake simulation there.

    It exits with `REFUSED` where another one is writing to the run's folder.
    """
    here, there = pipe()
    process = _context.Process(target=_do, args=(there, work, arguments), daemon=True)
    process.start()
    assert here.poll(PATIENCE), "it did not begin"
    return process


@contextmanager
def killed_at_last(work: Callable, *arguments: object) -> Iterator[BaseProcess]:
    """Another process at work, which is killed at the end of the block."""
    process = start(work, *arguments)
    try:
        yield process
    finally:
        process.kill()
        process.join(PATIENCE)
        assert process.exitcode is not None


def pipe() -> tuple[Connection, Connection]:
    """Two ends, of which the second is for the other process."""
    return _context.Pipe()


def _do(begun: Connection, work: Callable, arguments: tuple) -> None:
    sys.modules["pellucid.simulation.simulation"] = fake_module()
    begun.send(True)
    try:
        work(*arguments)
    except UsageError as error:
        if "is writing to" in str(error):
            sys.exit(REFUSED)
        raise
