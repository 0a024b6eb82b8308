"""Schedule of output: decides when output at a fixed interval of simulated time is due."""

import math
from dataclasses import dataclass

CLOSE = 1e-9
"""Tolerance for output times, as a fraction of the interval: sums of time steps do not hit multiples exactly."""


@dataclass
class Schedule:
    """Schedule of output at the simulated times 0, `interval`, 2 `interval`, ... [s], for the rows of the history and the
    frames of the fields.

    `done`: number of outputs so far. `last_step`, `last_time`: step number and time [s] of the last output; -1 and 0 before
    the first output.
    """

    interval: float
    done: int = 0
    last_step: int = -1
    last_time: float = 0.0

    @property
    def next(self) -> int:
        """Index k of the next output; the output time is k times `interval`. If one step passes several output times, a
        single output is written for all of them."""
        return math.floor(self.last_time / self.interval + CLOSE) + 1 if self.done else 0

    def due(self, time: float) -> bool:
        """True if the next output time is reached at `time` [s]."""
        return time >= (self.next - CLOSE) * self.interval

    def mark(self, time: float, step: int) -> None:
        """Record that an output was written at `time` [s] in the step with the number `step`."""
        self.done += 1
        self.last_step, self.last_time = step, time

    def to_data(self) -> dict[str, float]:
        """Return the state for a checkpoint. A run may be resumed with another interval."""
        return {"done": self.done, "last_step": self.last_step, "last_time": self.last_time}


def capacity(end: float, interval: float) -> int:
    """Return the largest number of outputs of a run to `end` [s] with an output every `interval` [s], including the first
    output, the last output, and an output at an early stop."""
    return math.floor(end / interval + CLOSE) + 3
