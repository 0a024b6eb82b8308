"""Work shared with worker processes, which end with this process for any reason."""

import os
import pickle
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Thread
from time import sleep
from typing import Any

Work = Callable[[Any], Any]
PAUSE = 0.02  # s between two looks at what helpers have done
BEGIN = """
import sys
from multiprocessing.connection import Connection
connection = Connection(int(sys.argv[1]))
sys.path[:] = connection.recv()
from pellucid.system.processes import serve
serve(connection)
"""


class Helper:
    """Worker process that computes jobs for this process. It builds a function, `make(*arguments)`, and calls this function
    with each job that `ask` sends.

    The worker prints nothing and is not affected by Ctrl-C. `multiprocessing` is not used because it would run the user's
    script a second time.
    """

    def __init__(self, make: Callable[..., Work | None], *arguments: Any) -> None:
        self._connection, there = Pipe()
        with there:
            self._process = subprocess.Popen(
                [sys.executable, "-c", BEGIN, str(there.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=[there.fileno()],
                process_group=0,
            )
        self._connection.send(sys.path)
        self._connection.send_bytes(pickle.dumps((make, arguments)))

    def ask(self, job: Any) -> Any:
        """Send a job to the worker process, wait, and return the result. Raises RuntimeError with the message of an error
        in the worker process, EOFError if the worker process ended."""
        self._connection.send_bytes(pickle.dumps(job))
        done, answer = self._connection.recv()
        if not done:
            raise RuntimeError(answer)
        return answer

    def end(self) -> None:
        """End the worker process immediately."""
        self._process.kill()
        self._process.wait()
        self._connection.close()


def serve(connection: Connection) -> None:
    """Process jobs of a `Helper` in its worker process until the other end of the connection is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    received: SimpleQueue[bytes] = SimpleQueue()

    def listen() -> None:
        try:
            while True:
                received.put(connection.recv_bytes())
        finally:
            os._exit(0)

    Thread(target=listen, daemon=True).start()
    make, arguments = pickle.loads(received.get())
    work = make(*arguments)
    while True:
        job = pickle.loads(received.get())
        try:
            answer = True, work(job)
        except Exception as error:
            answer = False, f"{type(error).__name__}: {error}"
        connection.send(answer)


@contextmanager
def helped(helpers: Sequence[Helper]) -> Iterator[None]:
    """End the worker processes `helpers` at the end of the block."""
    try:
        yield
    finally:
        for helper in helpers:
            helper.end()


def shared(jobs: Sequence[Any], work: Work, helpers: Sequence[Helper], count: Callable[[int], None]) -> list[Any]:
    """Return the results of all jobs, in the order of the jobs. Each worker process, and this process, takes the next job
    when it is free.

    work: function that does a job in this process; the workers (`helpers`) have built their own functions. count: called
    with the number of completed jobs. A job that fails in a worker is repeated in this process.
    """
    waiting, answers = deque(enumerate(jobs)), dict[int, Any]()

    def give(helper: Helper) -> None:
        with suppress(IndexError):
            while True:
                number, job = waiting.popleft()
                try:
                    answers[number] = helper.ask(job)
                except Exception:
                    waiting.append((number, job))
                    return

    for helper in helpers:
        Thread(target=give, args=(helper,), daemon=True).start()
    while len(answers) < len(jobs):
        try:
            number, job = waiting.popleft()
        except IndexError:
            sleep(PAUSE)
        else:
            answers[number] = work(job)
        count(len(answers))
    count(len(jobs))
    return [answers[number] for number in range(len(jobs))]


def free_cores() -> int:
    """Return the number of cores available to this process, minus one."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return cores - 1
