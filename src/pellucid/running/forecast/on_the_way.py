"""Run time reported after one second of a run, if it was unknown before."""

from time import monotonic

from pellucid.progress import Pace, Progress, clock

ENOUGH = 1.0
"""Duration of the measured steps after which the run time is reported [s]."""
RUNNING = "running"


class ToldOnTheWay(Progress):
    """Progress display that forwards all reports of a run to another display `progress`, and also shows the expected
    remaining run time once the time per step has been measured for a second. Used if no earlier run predicts the run time."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._pace = progress, Pace()
        self._phase, self._end, self._since, self._told = "", 0.0, 0.0, False

    def begin(self, phase: str, total: float | None = None) -> None:
        self._phase, self._end, self._pace = phase, total or 0.0, Pace()
        self._progress.begin(phase, total)

    def compiling(self, kernel: str, number: int, expected: int) -> None:
        self._since = monotonic()
        self._progress.compiling(kernel, number, expected)

    def compiled(self) -> None:
        """Exclude the time of the compilation from the time per step."""
        self._pace.leave_out(monotonic() - self._since)
        self._progress.compiled()

    def update(self, *, step: int, time: float, dt: float, points: int, energy_error: float) -> None:
        self._progress.update(step=step, time=time, dt=dt, points=points, energy_error=energy_error)
        if self._told or self._phase != RUNNING:
            return
        self._pace.add(monotonic(), step, time)
        if self._pace.seconds() >= ENOUGH:
            self._told = True
            left = clock(self._pace.time_left(self._end))
            self._progress.note(f"time: about {left} remaining, estimated from the first {step} steps")

    def count(self, done: int) -> None:
        self._progress.count(done)

    def message(self, text: str) -> None:
        self._progress.message(text)

    def note(self, text: str) -> None:
        self._progress.note(text)

    def stop(self) -> None:
        self._progress.stop()
