"""Progress of a long run: a live line on a terminal, otherwise messages only."""

import sys
import warnings
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from statistics import median
from time import monotonic
from typing import Any

BETWEEN_LINES = 10.0  # s of wall-clock time between lines about a search if the output is not a terminal
WINDOW = 10.0  # s of wall-clock time from which speed and time left are estimated
FEWEST_STEPS = 10  # from which they are estimated at least: first steps also load kernels and allocate memory


class Progress:
    """Interface for reports of the progress of a run or study; this base class reports nothing. Times are in seconds,
    `energy_error` is relative."""

    def begin(self, phase: str, total: float | None = None) -> None:
        """Start a phase such as "running" or "drawing", which ends the previous phase; total: final value of the counter of the
        phase (the simulated time in a run), if it is known."""

    def compiling(self, kernel: str, number: int, expected: int) -> None:
        """Report that kernel `number` is compiled during a phase; expected: number of kernels to compile, 0 if unknown."""

    def compiled(self) -> None:
        """Report that the compilation of a kernel has ended and the phase continues."""

    def update(self, *, step: int, time: float, dt: float, points: int, energy_error: float, search: str = "") -> None:
        """Report the state of the run after `step` steps at the simulated time `time` [s]; dt: last time step [s]; points:
        number of points; energy_error: relative error of the energy balance; search: state of the search for an
        equilibrium, empty in other runs."""

    def count(self, done: int) -> None:
        """Report the number of completed parts of a phase that is not a run, such as drawn frames."""

    def message(self, text: str) -> None:
        """Report a text that the user must see."""

    def note(self, text: str) -> None:
        """Report a text for the user of the command line. Unlike a text for `message`, this text is not needed when a
        program calls pellucid."""
        self.message(text)

    def stop(self) -> None:
        """Report that all phases have ended, with or without an error."""


class QuietProgress(Progress):
    """Progress for output that is not a terminal: messages on stderr, and from time to time a line about the search for an
    equilibrium, which shows whether it converges."""

    def __init__(self) -> None:
        self._said, self._searched = False, monotonic()

    def update(self, *, step: int, time: float, dt: float, points: int, energy_error: float, search: str = "") -> None:
        if search and monotonic() - self._searched > BETWEEN_LINES:
            self._searched = monotonic()
            self.message(search)

    def compiling(self, kernel: str, number: int, expected: int) -> None:
        if not self._said:
            self._said = True
            self.message("compiling kernels (first run only) ...")

    def message(self, text: str) -> None:
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()


class WarningsOnly(Progress):
    """Progress for programs that call pellucid: messages are issued as warnings."""

    def message(self, text: str) -> None:
        warnings.warn(text, stacklevel=3)

    def note(self, text: str) -> None:
        pass


class TerminalProgress(Progress):
    """Progress on a terminal: a live line with the phase and its progress; at the end, the duration of each phase."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, ProgressColumn, TaskProgressColumn, TextColumn
        from rich.table import Column
        from rich.text import Text

        class Taken(ProgressColumn):
            """Column of the live progress line with the duration of the phase; it also advances between updates."""

            def render(_self, task: Any) -> Text:
                return Text(clock(self._taken()))

        self._bar = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=12),
            TaskProgressColumn(),
            Taken(),
            TextColumn("{task.fields[state]}", markup=False, table_column=Column(overflow="fold", no_wrap=False)),
            console=Console(stderr=True),
            transient=True,
        )
        self._task: Any = None
        self._phase, self._paused, self._total = "", "", 0.0
        self._since = 0.0
        self._seconds: dict[str, float] = {}  # of each phase in all
        self._before: dict[str, float] = {}  # of each phase when the present one began
        self._pace = Pace()

    def begin(self, phase: str, total: float | None = None) -> None:
        self._book(phase)
        self._total, self._pace, self._before = total or 0.0, Pace(), dict(self._seconds)
        self._show(phase, total)
        self._bar.start()

    def compiling(self, kernel: str, number: int, expected: int) -> None:
        self._paused = self._phase
        self._book("compiling")
        of = f" of {expected}" if expected >= number else ""
        self._bar.update(self._task, description="compiling", state=f"kernel {number}{of}, {kernel}")

    def compiled(self) -> None:
        self._book(self._paused)
        self._pace.start_again()
        self._bar.update(self._task, description=self._phase, state="")

    def update(self, *, step: int, time: float, dt: float, points: int, energy_error: float, search: str = "") -> None:
        self._pace.add(monotonic(), step, time)
        rate, left = points * self._pace.steps_per_second(), self._pace.time_left(self._total)
        state = state_line(step=step, time=time, dt=dt, rate=rate, energy_error=energy_error, left=left)
        if search:
            state = f"{search}  {clock(left)} left"
        self._bar.update(self._task, completed=time, state=state)

    def count(self, done: int) -> None:
        self._bar.update(self._task, completed=done, state=f"{done} of {self._total:g}")

    def message(self, text: str) -> None:
        self._bar.console.print(text, markup=False, highlight=False)

    def stop(self) -> None:
        self._book("")
        if self._task is not None:
            self._bar.remove_task(self._task)
            self._task = None
        self._bar.stop()
        if self._seconds:
            self.message(", ".join(f"{phase} {clock(seconds)}" for phase, seconds in self._seconds.items()))
            self._seconds = {}

    def _book(self, phase: str) -> float:
        """Begin a phase and add the duration of the previous phase to its total; return this duration [s]."""
        now = monotonic()
        taken = now - self._since
        if self._phase:
            self._seconds[self._phase] = self._seconds.get(self._phase, 0.0) + taken
        self._phase, self._since = phase, now
        return taken

    def _taken(self) -> float:
        """Return the duration of the current phase since it began [s]."""
        known = self._seconds.get(self._phase, 0.0) - self._before.get(self._phase, 0.0)
        return known + monotonic() - self._since

    def _show(self, phase: str, total: float | None) -> None:
        if self._task is not None:
            self._bar.remove_task(self._task)
        self._task = self._bar.add_task(phase, total=total, state="")


class Pace:
    """Speed of a run in steps per second and its remaining time, estimated from the last WINDOW seconds of wall-clock time, and
    at least FEWEST_STEPS steps, since the last compilation."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, int, float]] = deque()
        self._starts = False

    def start_again(self) -> None:
        """Measure from the next recorded step on, because time since the last one was not spent in steps, such as that of a
        compilation."""
        self._starts = True

    def add(self, now: float, step: int, time: float) -> None:
        """Record that a run has done `step` steps up to the simulated time `time` [s] at the wall-clock time `now` [s]."""
        if self._starts:
            self._samples.clear()
            self._starts = False
        self._samples.append((now, step, time))
        while len(self._samples) > 2 and self._is_enough(self._samples[1]) and now - self._samples[1][0] >= WINDOW:
            self._samples.popleft()

    def _is_enough(self, since: tuple[float, int, float]) -> bool:
        return self._samples[-1][1] - since[1] >= FEWEST_STEPS

    @property
    def is_known(self) -> bool:
        """True if enough steps have been recorded."""
        return len(self._samples) > 0 and self._is_enough(self._samples[0])

    def seconds(self) -> float:
        """Return the wall-clock time between the first and the last recorded step [s]."""
        (begun, _, _), (now, _, _) = self._ends()
        return now - begun

    def steps_per_second(self) -> float:
        """Return the number of steps per second of wall-clock time; NaN before it is known."""
        (begun, first, _), (now, last, _) = self._ends()
        return (last - first) / (now - begun) if self.is_known and now > begun else float("nan")

    def time_left(self, end: float) -> float:
        """Return the remaining wall-clock time to the simulated time `end` [s]; NaN before it is known."""
        (begun, _, first), (now, _, last) = self._ends()
        return (end - last) * (now - begun) / (last - first) if self.is_known and last > first else float("nan")

    def typical_time_left(self, end: float) -> float:
        """Return the remaining wall-clock time to the simulated time `end` [s] like `time_left`, but from the median time per
        step between records, on which single slow steps have no influence."""
        (_, begun, first), (_, done, last) = self._ends()
        if not self.is_known or not last > first:
            return float("nan")
        pairs = zip(self._samples, list(self._samples)[1:], strict=False)
        each = median((now - before) / (step - earlier) for (before, earlier, _), (now, step, _) in pairs if step > earlier)
        return each * (end - last) * (done - begun) / (last - first)

    def _ends(self) -> tuple[tuple[float, int, float], tuple[float, int, float]]:
        none = (0.0, 0, 0.0)
        return (self._samples[0], self._samples[-1]) if self._samples else (none, none)


@contextmanager
def watching() -> Iterator[Progress]:
    """Context manager that yields the progress display for this terminal, which also shows warnings raised in the block and
    stops at its end."""
    progress = for_terminal()
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_where, **_to: progress.message(f"warning: {message}")
        try:
            yield progress
        finally:
            progress.stop()


def for_terminal() -> Progress:
    """Return a live progress line if stderr is a terminal or the program runs in a notebook, otherwise a quiet progress."""
    return TerminalProgress() if sys.stderr.isatty() or "ipykernel" in sys.modules else QuietProgress()


def state_line(*, step: int, time: float, dt: float, rate: float, energy_error: float, left: float) -> str:
    """Return the state of a run as one line of text.

    step: number of steps; time, dt: simulated time and last time step [s]; rate: points times steps per second;
    energy_error: relative; left: remaining wall-clock time [s].
    """
    speed = f"{rate / 1e6:.3g} M point-steps/s  " if rate == rate else ""
    return f"step {step}  t {time:.4g} s  dt {dt:.3g} s  {speed}energy error {energy_error:.1e}  {clock(left)} left"


def clock(seconds: float) -> str:
    """Return a wall-clock time in seconds as text: "8.3 s", "2 min 05 s", "3 h 20 min"."""
    if not seconds >= 0 or seconds == float("inf"):
        return "?"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
