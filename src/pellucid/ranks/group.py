"""The group of processes that share a simulation, and operations in which all these processes take part."""

import os
import sys
import time
import traceback
from array import array
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from typing import Any, TextIO, TypeVar

import numpy as np

from pellucid.errors import PellucidError, UsageError
from pellucid.system.extras import install_command

SIZES = "OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_SIZE", "MPI_LOCALNRANKS", "SLURM_STEP_NUM_TASKS"
NUMBERS = "OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK", "SLURM_PROCID"
"""Environment variables in which launchers store the number of processes, and the index of this process."""
NO_MPI = f"mpi4py is not installed.\n    Run {install_command('mpi')}, or start only one process."
OTHER_MPI = (
    "mpi4py uses another MPI, which finds only one process.\n    Start the processes with the launcher of the MPI of mpi4py "
    "(srun: with --mpi=pmi2 or --mpi=pmix), or install mpi4py for the MPI of this launcher."
)
PATIENCE = 10.0  # s in which all processes must come to the same end
Value = TypeVar("Value")


class Group:
    """The group of processes that share a simulation, for exchanging data between them; contains only this process until
    `join` is called."""

    rank, size = 0, 1
    here = 1
    """Number of processes of the group on this machine."""
    _comm: Any = None
    _mpi: Any = None

    def __init__(self) -> None:
        self._agreed: list[BaseException] = []
        self._ended: list[BaseException] = []
        self.waited = 0.0
        """Time spent in communication so far [s], mostly waiting for other processes."""

    @contextmanager
    def _waiting(self) -> Iterator[None]:
        began = time.perf_counter()
        yield
        self.waited += time.perf_counter() - began

    @property
    def is_first(self) -> bool:
        """True for the first process, which alone writes files and reports progress."""
        return self.rank == 0

    def join(self) -> None:
        """Join the processes that a launcher such as mpirun started together with this process, if there are any. Raises
        UsageError if mpi4py is not installed, or belongs to another MPI library than the launcher."""
        started = max(int(os.environ.get(name, "1")) for name in SIZES)
        if self._comm is not None or started == 1:
            return
        self.rank = max(int(os.environ.get(name, "0")) for name in NUMBERS)  # who tells, if there is no more
        why = f"{started} processes were started together, but "
        try:
            from mpi4py import MPI
        except ImportError:
            raise UsageError(why + NO_MPI) from None
        if MPI.COMM_WORLD.size == 1:
            raise UsageError(why + OTHER_MPI)
        self._mpi, self._comm = MPI, MPI.COMM_WORLD
        self.rank, self.size = self._comm.rank, self._comm.size
        self.here = self._comm.Split_type(MPI.COMM_TYPE_SHARED).size

    def any(self, flag: bool) -> bool:
        """Return True if the flag is set in any process."""
        return self.largest(float(flag)) > 0.0

    def largest(self, value: float) -> float:
        """Return the largest of the values that all processes pass."""
        if self.size == 1:
            return value
        with self._waiting():
            return float(self._comm.allreduce(value, op=self._mpi.MAX))

    def told(self, value: Value, by: int = 0) -> Value:
        """Broadcast a value from the process with the number `by` to all processes, and return this value."""
        if self.size == 1:
            return value
        with self._waiting():
            return self._comm.bcast(value, root=by)

    def each(self, value: Value) -> list[Value]:
        """Gather a value from every process; return the values in the order of the processes, on each process."""
        if self.size == 1:
            return [value]
        with self._waiting():
            return self._comm.allgather(value)

    def total(self, own: np.ndarray) -> np.ndarray:
        """Return the elementwise sum of the arrays of all processes, shape (n,); own: array of this process."""
        with self._waiting():
            return np.sum(self._comm.allgather(own), axis=0)

    def joined(self, own: np.ndarray, lengths: np.ndarray | None = None, to_first: bool = False) -> np.ndarray:
        """Gather the rows of the arrays of all processes in the order of the processes, and return all rows; own: array of
        this process. If `to_first` is set, only the first process gets the rows, and all others get no rows.

        lengths: number of rows of each process; None if unknown.
        """
        own = np.ascontiguousarray(own)
        if lengths is None:
            with self._waiting():
                lengths = np.array(self._comm.allgather(len(own)))
        wanted = self.is_first or not to_first
        found = np.empty((int(lengths.sum()) if wanted else 0, *own.shape[1:]), own.dtype)
        into = _bytes(found), lengths * _bytes_each(own)
        with self._waiting():
            if to_first:
                self._comm.Gatherv(_bytes(own), into if wanted else None)
            else:
                self._comm.Allgatherv(_bytes(own), into)
        return found

    def exchanged(self, rows: np.ndarray, send: np.ndarray, receive: np.ndarray) -> np.ndarray:
        """Send rows to the other processes and return the rows received from them; rows sent and rows received are ordered
        by process.

        send, receive: number of rows sent to and received from each process, shape (processes,).
        """
        rows = np.ascontiguousarray(rows)
        found = np.empty((int(receive.sum()), *rows.shape[1:]), rows.dtype)
        each = _bytes_each(rows)
        with self._waiting():
            self._comm.Alltoallv((_bytes(rows), send * each), (_bytes(found), receive * each))
        return found

    def numbers_from_each(self, for_each: np.ndarray) -> np.ndarray:
        """Send an integer to each process, `for_each`, shape (processes,), and return the integers received from each, same
        shape."""
        with self._waiting():
            return np.array(self._comm.alltoall(for_each.tolist()))

    def agrees(self, seconds: float) -> bool:
        """Return True if all processes call this method within `seconds` of wall-clock time, otherwise False after this
        time."""
        if self.size == 1:
            return True
        end, request = time.monotonic() + seconds, self._comm.Ibarrier()
        while not request.Test():
            if time.monotonic() > end:
                return False
            time.sleep(0.01)
        return True

    def wait(self) -> None:
        """Wait until all processes call this method, without using a CPU."""
        self.agrees(inf)

    def agree_on(self, error: BaseException) -> None:
        """Wait until all processes have raised the error `error`, before any of them reports it; if some process does not
        raise it within PATIENCE [s], abort all processes."""
        if self.size == 1 or error in self._agreed:
            return
        if not self.agrees(PATIENCE):
            if not isinstance(error, PellucidError):
                traceback.print_exception(error)
            told = "\n    ".join([f"pellucid: {error}", *getattr(error, "__notes__", ())])
            print(f"{told}\n    (process {self.rank} of {self.size})", file=sys.stderr, flush=True)  # noqa: T201
            status = getattr(error, "exit_status", 1)
            _wait_until_read(sys.stderr, seconds=2.0)
            self._comm.Abort(status)
            os._exit(status)  # if the launcher does not end the process at once
        self.know(error)

    def know(self, error: BaseException) -> None:
        """Record an error that all processes raise, so that `end` waits for the other processes instead of aborting them."""
        self._agreed.append(error)

    def end(self, error: BaseException) -> None:
        """End this process because of an error; a second call for the same error does nothing. Wait for the other processes
        if all raise the error, otherwise abort all processes."""
        if self.size == 1 or error in self._ended:
            return
        self._ended.append(error)
        if error in self._agreed:
            self.wait()
        else:
            self.agree_on(error)

    def pass_on(self, messages: list[tuple[int, np.ndarray, bool]]) -> None:
        """Send bytes to other processes, or receive bytes from them; messages: process, buffer, and True to send or False to
        receive."""
        begin = {True: self._comm.Isend, False: self._comm.Irecv}
        with self._waiting():
            self._mpi.Request.Waitall([begin[sends](buffer, process) for process, buffer, sends in messages])


def _wait_until_read(stream: TextIO, seconds: float) -> None:
    """Wait, at most `seconds`, until the launcher has read all output from the pipe of the stream, since an abort would
    discard unread output."""
    try:
        import fcntl
        import termios
    except ImportError:  # no such system
        return
    end, unread = time.monotonic() + seconds, array("i", [1])
    while unread[0] and time.monotonic() < end:
        time.sleep(0.001)
        try:
            fcntl.ioctl(stream.fileno(), termios.FIONREAD, unread)
        except OSError:  # no pipe
            return


def _bytes(rows: np.ndarray) -> np.ndarray:
    return rows.reshape(-1).view(np.uint8)


def _bytes_each(rows: np.ndarray) -> int:
    return rows.dtype.itemsize * int(np.prod(rows.shape[1:]))


processes = Group()
"""The group of processes of this simulation."""
