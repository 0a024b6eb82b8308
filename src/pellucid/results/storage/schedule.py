"""When something is due that has a fixed interval in simulated time."""

import math
from dataclasses import dataclass

CLOSE = 1e-9
"""Share of the interval within which an instant counts as reached: sums of steps do not hit multiples exactly."""


@dataclass
class Schedule:
    """Instants 0, `interval`, 2 `interval`, ...; `next` counts them, `done` counts what was written."""

    interval: float
    next: int = 0
    done: int = 0
    last_step: int = -1

    def due(self, time: float) -> bool:
        """Whether the next instant [s] is reached."""
        return time >= (self.next - CLOSE) * self.interval

    def mark(self, time: float, step: int) -> None:
        """Something was written at `time`: instants that one step passed together are served together."""
        self.next = math.floor(time / self.interval + CLOSE) + 1
        self.done += 1
        self.last_step = step

    def to_data(self) -> dict[str, int]:
        """What a checkpoint keeps."""
        return {"next": self.next, "done": self.done, "last_step": self.last_step}


def capacity(end: float, interval: float) -> int:
    """How many instants a run to `end` [s] can write, with its start, its end and one early stop."""
    return math.floor(end / interval + CLOSE) + 3
