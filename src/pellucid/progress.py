"""What a long run tells while it goes: a live line on a terminal, next to nothing elsewhere."""

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Protocol


class Progress(Protocol):
    """What a run calls; all times are in seconds, `rate` in point-steps per second, `energy_error` relative."""

    def start(self, total_time: float) -> None:
        """The run begins, to end at simulated time `total_time`."""

    def update(self, *, step: int, time: float, dt: float, rate: float, energy_error: float, eta: float) -> None:
        """The run stands after `step` steps at simulated time `time`; `eta` is the wall-clock time left."""

    def message(self, text: str) -> None:
        """Something that the user should know in any case."""

    def stop(self) -> None:
        """The run has ended, well or not."""


class QuietProgress:
    """Off a terminal: messages only, on stderr."""

    def start(self, total_time: float) -> None:
        pass

    def update(self, *, step: int, time: float, dt: float, rate: float, energy_error: float, eta: float) -> None:
        pass

    def message(self, text: str) -> None:
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()

    def stop(self) -> None:
        pass


class TerminalProgress:
    """On a terminal: one live line with step, time, dt, point-steps/s, energy error and time left."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
        from rich.table import Column

        self._bar = Progress(
            BarColumn(bar_width=12),
            TaskProgressColumn(),
            TextColumn("{task.fields[state]}", markup=False, table_column=Column(overflow="fold", no_wrap=False)),
            console=Console(stderr=True),
            transient=True,
        )
        self._task: Any = None

    def start(self, total_time: float) -> None:
        self._task = self._bar.add_task("run", total=total_time, state="setting up")
        self._bar.start()

    def update(self, *, step: int, time: float, dt: float, rate: float, energy_error: float, eta: float) -> None:
        if self._task is not None:
            state = state_line(step=step, time=time, dt=dt, rate=rate, energy_error=energy_error, eta=eta)
            self._bar.update(self._task, completed=time, state=state)

    def message(self, text: str) -> None:
        self._bar.console.print(text, markup=False, highlight=False)

    def stop(self) -> None:
        self._bar.stop()


@contextmanager
def watching() -> Iterator[Progress]:
    """The progress for this terminal, which also tells the warnings of what runs meanwhile; stopped at the end."""
    progress = for_terminal()
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_where, **_to: progress.message(f"warning: {message}")
        try:
            yield progress
        finally:
            progress.stop()


def for_terminal() -> Progress:
    """The live line where stderr is a terminal, else the quiet one."""
    return TerminalProgress() if sys.stderr.isatty() else QuietProgress()


def state_line(*, step: int, time: float, dt: float, rate: float, energy_error: float, eta: float) -> str:
    """One line on where a run stands."""
    return (
        f"step {step}  t {time:.4g} s  dt {dt:.3g} s  {rate / 1e6:.3g} M point-steps/s  "
        f"energy error {energy_error:.1e}  {clock(eta)} left"
    )


def clock(seconds: float) -> str:
    """A wall-clock time for a person: "8.3 s", "2 min 05 s", "3 h 20 min"."""
    if not seconds >= 0 or seconds == float("inf"):
        return "?"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
