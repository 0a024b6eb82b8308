"""Execution of the members of a study by dask.distributed: on this machine, on a cluster, or as Slurm jobs."""

import logging
import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from threading import Event, Lock, Timer
from typing import Any

from pellucid.case.memory import n_points
from pellucid.errors import UsageError
from pellucid.jit import check_threads
from pellucid.progress import Progress
from pellucid.results.storage.files import refuse_locked
from pellucid.results.storage.run_folder import RunFolder
from pellucid.running.step_number import of_case
from pellucid.studies import need
from pellucid.studies.members import FAILED, INTERRUPTED, Member, Outcome, outcome, places, prepare
from pellucid.system.command_process import SIGTERM, CommandProcess
from pellucid.system.processes import free_cores

THREADS = "threads"
WAIT = 60  # s for a scheduler to answer
START = 600
"""Time in which a job of Slurm must reach the study [s]. One that gives up is not replaced: the study would wait for ever."""


@dataclass(frozen=True)
class Workers:
    """Options of the parallel runs of a study: on this machine, by the workers of a dask scheduler, or as Slurm jobs.

    at_once: number of parallel runs on this machine. threads: threads of each run. scheduler: address of a dask scheduler.
    slurm: arguments of `dask_jobqueue.SLURMCluster`.
    """

    at_once: int | None = None
    threads: int | None = None
    scheduler: str | None = None
    slurm: Mapping[str, str] = field(default_factory=dict)

    def check(self) -> None:
        """Raise UsageError for an invalid combination of options."""
        if self.threads is not None:
            check_threads(self.threads)
        if self.at_once is not None and self.at_once < 1:
            raise UsageError(f"--workers {self.at_once}: must be at least 1")
        if self.scheduler and self.slurm:
            raise UsageError("--scheduler and --slurm cannot be combined.\n    Remove one of them.")


def read_slurm(text: str | None) -> dict[str, str]:
    """Return the options of `dask_jobqueue.SLURMCluster` from a text such as
    "queue=short,cores=8,memory=16GB,walltime=02:00:00". Raises UsageError for an invalid text."""
    found: dict[str, str] = {}
    for item in (text or "").split(","):
        key, equals, value = item.partition("=")
        if text and not (equals and key.strip() and value.strip()):
            example = "queue=short,cores=8,memory=16GB,walltime=02:00:00"
            raise UsageError(f"--slurm {text}: must have the form KEY=VALUE,..., such as {example}")
        if text:
            found[key.strip()] = value.strip()
    if found and not {"cores", "memory"} <= found.keys():
        raise UsageError(f"--slurm {text}: cores and memory of a job are missing; add for example cores=8,memory=16GB")
    return found


class Pool:
    """Runs the members of a study to their ends in the folder `out`; use it as a context manager.

    Workers are started for the first member that has to run, and stop at the end of the `with` block. When interrupted, members
    on this machine write checkpoints first.
    """

    def __init__(self, out: Path, workers: Workers, progress: Progress) -> None:
        self._out, self._workers, self._progress = out, workers, progress
        self._stack = ExitStack()
        self._client: Any = None

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, *_: object) -> None:
        # on a busy machine what dask closes may be late, of which asyncio tells as of a crash when all is done
        logging.getLogger("asyncio").setLevel(logging.CRITICAL)
        self._stack.close()

    @property
    def at_once(self) -> int:
        """Number of members (runs of the study) that this machine computes in parallel."""
        return self._workers.at_once or max(1, _cores() // (self._workers.threads or 1))

    def compute(self, members: Sequence[Member], told: Callable[[Member, Outcome], None] | None = None) -> dict[str, Outcome]:
        """Run the members that are not done, the most expensive first, and return the outcome of every member by its digest.
        told: function called with each new outcome."""
        found = {member.digest: known for member in members if (known := outcome(self._out, member.digest)) is not None}
        left = [member for member in members if member.digest not in found]
        if left and self._client is None:
            self._client = self._start(len(left))  # says where nobody answers, before anything is written
        prepare(self._out, members)
        self._progress.begin("members", len(members))
        self._progress.count(len(found))
        for member, ended in self._ended(left) if left else ():
            found[member.digest] = ended
            self._progress.count(len(found))
            if told is not None:
                told(member, ended)
        return found

    def _ended(self, members: Sequence[Member]) -> Iterator[tuple[Member, Outcome]]:
        costs = _costs(members)
        local = self._workers.scheduler is None and not self._workers.slurm
        jobs = {}
        for member in members:
            threads = self._workers.threads or (_share(costs[member.digest] / sum(costs.values())) if local else 1)
            more: dict[str, Any] = {"resources": {THREADS: min(threads, _cores())}} if local else {}
            key = f"member-{member.digest}-{uuid.uuid4()}"  # of this study alone: a scheduler may have others
            arguments = (self._out.resolve(), member.digest, threads, member.until)
            job = self._client.submit(run_member, *arguments, key=key, priority=costs[member.digest], **more)
            jobs[job] = member
        for job in need("distributed").as_completed(list(jobs)):
            error = job.exception() if job.status != "finished" else None
            yield jobs[job], Outcome(FAILED, f"the worker failed: {error}") if error is not None else job.result()

    def _start(self, number: int) -> Any:
        distributed, enter = need("distributed"), self._stack.enter_context
        if self._workers.scheduler:
            try:
                return enter(distributed.Client(self._workers.scheduler, timeout=WAIT))
            except (OSError, ValueError) as error:
                raise UsageError(
                    f"--scheduler {self._workers.scheduler}: no scheduler answers at this address: {error}"
                ) from None
        if self._workers.slurm:
            cluster = enter(_slurm(self._workers.slurm))
            cluster.scale(jobs=self._workers.at_once or number)
            return enter(distributed.Client(cluster))
        cluster = distributed.LocalCluster(
            n_workers=1,
            threads_per_worker=self.at_once,
            processes=False,  # members run in separate processes
            dashboard_address="127.0.0.1:0",  # any port that is free
            resources={THREADS: max(_cores(), self.at_once)},
            silence_logs=logging.ERROR,
        )
        client = enter(distributed.Client(enter(cluster)))
        allow_running()
        self._stack.callback(end_running)  # before the client and the cluster are closed: members may need a while
        return client


def _slurm(options: Mapping[str, str]) -> Any:
    numbers = {key: int(value) if value.isdecimal() else value for key, value in options.items()}
    try:
        return need("dask_jobqueue").SLURMCluster(**{"processes": 1, "death_timeout": START, **numbers})
    except (TypeError, ValueError) as error:
        raise UsageError(f"--slurm {','.join(f'{key}={value}' for key, value in options.items())}: {error}") from None


def _cores() -> int:
    return free_cores() + 1


def _share(cost: float) -> int:
    """Return the number of threads of a member, at least one: the number of cores times its share `cost` of the total cost of
    the study."""
    return max(1, int(_cores() * cost))


def _costs(members: Sequence[Member]) -> dict[str, float]:
    """Return the relative costs of the members, by digest: number of points times estimated number of steps."""
    found = {}
    for member in members:
        points = n_points(member.case)
        steps = of_case(member.case).number
        found[member.digest] = float(max(points, 1)) * (steps if isfinite(steps) and steps > 0.0 else 1.0)
    return found


PROGRAM = """
from pellucid.system.command_process import execute_commands

def load():
    from pellucid.cli import main
    return main

def is_clean():
    from pellucid.users.users_code import is_loaded
    return not is_loaded()

execute_commands(load, is_clean)
"""
PAUSE = 0.2  # s between two looks at a folder in which another process writes
TAIL = 20  # lines of a log that hold the reason of a failure
BAD_ARGUMENT = 2
IDLE = 60.0  # s after which a process that has no member terminates

_running: set[CommandProcess] = set()
_idle: list[tuple[int, float, CommandProcess]] = []
"""Processes without a member: number of threads of their members, time at which their last member ended [s], process."""
_changing = Lock()
_ending = Event()


def run_member(out: Path, digest: str, threads: int, until: float | None) -> Outcome:
    """Run a member of the study in the folder `out` in a separate process, from the start or from its last checkpoint, and
    return its outcome; a finished member is not run again. A process that has completed a short member takes the next one.

    digest: identifies the member. until: time at which the run ends [s]; None: end of the case.
    """
    where = places(out, digest)
    while _is_held(where.run):  # by the process of a study that was killed just now, or by another study
        time.sleep(PAUSE)
    found = outcome(out, digest)
    if found is not None:
        return found
    options = ["--no-report", "--threads", f"{threads}", *(["--until", repr(until)] if until is not None else [])]
    anew = ["run", f"{where.case}", "--out", f"{where.run}", *options]
    begun = RunFolder(where.run).case.is_file()
    status = _call(["resume", f"{where.run}", *options] if begun else anew, where.log, threads)
    if begun and status == BAD_ARGUMENT:  # it cannot go on: another version of the program began it
        status = _call(anew, where.log, threads)
    return _ended(status, where.log) if status else outcome(out, digest) or Outcome(FAILED, "the run wrote no summary")


def allow_running() -> None:
    """Allow members to start again after `end_running`."""
    _ending.clear()


def end_running() -> None:
    """Make all members that this process runs write a checkpoint and stop, wait until they have stopped, and start no more
    members."""
    with _changing:
        _ending.set()
        processes = [*_running, *(process for _, _, process in _idle)]
        _idle.clear()
        for process in processes:
            process.close()
    for process in processes:
        process.wait()


def _is_held(folder: Path) -> bool:
    try:
        refuse_locked(folder)
    except UsageError:
        return True
    return False


def _call(arguments: list[str], log: Path, threads: int) -> int:
    """Run a `pellucid` command with these arguments in a separate process, with output to `log`; return its exit status.

    threads: number of threads of the command. Processes are shared only by commands with equal numbers, because the largest
    number that a process can use is fixed when it starts.
    """
    with _changing:
        if _ending.is_set():
            return SIGTERM
        process = _waiting_process(threads) or CommandProcess(PROGRAM, log)
        _running.add(process)
    try:
        return process.execute(arguments, log)
    finally:
        with _changing:
            _running.discard(process)
            if process.is_reusable and not _ending.is_set():
                _idle.append((threads, time.monotonic(), process))
                timer = Timer(IDLE, _end_idle)
                timer.daemon = True
                timer.start()
            else:
                process.close()
        if not process.is_reusable:
            process.wait()


def _waiting_process(threads: int) -> CommandProcess | None:
    """Remove a process that waits for a member with this number of threads from the list and return it; None if no process
    waits."""
    for entry in [entry for entry in reversed(_idle) if entry[0] == threads]:
        _idle.remove(entry)
        if entry[2].is_alive:
            return entry[2]
        entry[2].wait()
    return None


def _end_idle() -> None:
    """Terminate the processes that have been without a member for the time `IDLE`, since a cluster may serve others."""
    with _changing:
        ended = [entry for entry in _idle if time.monotonic() - entry[1] >= IDLE]
        for entry in ended:
            _idle.remove(entry)
            entry[2].close()
    for _, _, process in ended:
        process.wait()


def _ended(status: int, log: Path) -> Outcome:
    """Return the outcome of a process that ended with a status other than 0: interrupted, or failed with the error message at
    the end of its log."""
    if status == SIGTERM or status == -15:
        return Outcome(INTERRUPTED, "interrupted; run the same command again to continue from the checkpoint")
    if status < 0:
        return Outcome(FAILED, f"the process was killed by signal {-status}; see {log}")
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()[-TAIL:]
    starts = [number for number, line in enumerate(lines) if line.startswith("pellucid: ")]
    text = "\n".join(lines[starts[-1] :] if starts else lines[-1:]).removeprefix("pellucid: ")
    return Outcome(FAILED, text or f"exit status {status}; see {log}")
