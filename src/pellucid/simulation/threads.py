"""Choice of the number of threads, by trials during the run.

Small bodies, and machines with other load, run faster with fewer threads. Results do not depend on the number, bit for bit.
"""

import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from statistics import median

FIRST = 5  # first steps of a run, which are not timed because some compile kernels
ROUNDS = 5  # rounds of a trial; each times a block of steps for every number of threads
BLOCK = 4e-3  # approximate duration of a block of steps [s]; a longer step is a block by itself
HELD = 30.0  # time to the next trial, in durations of the last one
LEAST_HELD = 2.0  # shortest time to the next trial [s]
GAIN = 0.95  # more threads are used if their time is below this fraction of the time with fewer threads


def numbers_up_to(most: int) -> list[int]:
    """Return the numbers of threads to try: powers of two below `most`, and `most`."""
    return [n for n in (2**k for k in range(most.bit_length())) if n < most] + [most]


class ThreadChoice:
    """Choice of the number of threads by timed trials during a run.

    numbers: numbers to choose from, ascending; first: upper limit of the initial number; use: function that makes the run
    use a number of threads; clock: function that returns the wall-clock time [s].
    """

    def __init__(
        self,
        numbers: Sequence[int],
        first: int,
        use: Callable[[int], object],
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._numbers, self._use, self._clock = list(numbers), use, clock
        self.chosen = max((n for n in numbers if n <= first), default=numbers[0])
        """Number of threads in use outside of trials."""
        use(self.chosen)
        self._left, self._next_trial = FIRST, 0.0
        self._trial: Trial | None = None
        self._began = 0.0

    def before_step(self) -> None:
        """Record the wall-clock time at which a step starts. Called before each step."""
        self._began = self._clock()

    def after_step(self) -> None:
        """Continue a trial of several numbers of threads, or start a trial if it is due. Called after each step."""
        if len(self._numbers) == 1:
            return
        now = self._clock()
        taken = now - self._began
        if self._left > 0:
            self._left -= 1
        elif self._trial is None and now >= self._next_trial:
            near = self._numbers.index(self.chosen)
            self._trial = Trial(self._numbers[max(0, near - 1) : near + 2], max(1, round(BLOCK / taken)), now)
            self._use(self._trial.number)
        elif self._trial is not None:
            self._trial.count(taken)
            if not self._trial.is_over:
                self._use(self._trial.number)
                return
            moved = self.chosen != self._trial.best
            self.chosen = self._trial.best
            self._use(self.chosen)
            self._next_trial = now if moved else now + max(LEAST_HELD, HELD * (now - self._trial.began))
            self._trial = None


class Trial:
    """Comparison of several numbers of threads by the wall-clock time of steps: in each round, every number is used for a
    block of `steps` steps. numbers: the numbers of threads, ascending; began: wall-clock time at the start [s]."""

    def __init__(self, numbers: list[int], steps: int, began: float) -> None:
        self._numbers, self._steps, self.began = numbers, steps, began
        self._times: dict[int, list[float]] = {number: [] for number in numbers}
        self._done, self._sum = 0, 0.0

    @property
    def number(self) -> int:
        """Number of threads for the coming step."""
        return self._numbers[self._done // self._steps % len(self._numbers)]

    @property
    def is_over(self) -> bool:
        """True if all rounds of the trial, in which numbers of threads are compared, are done."""
        return self._done == ROUNDS * self._steps * len(self._numbers)

    def count(self, taken: float) -> None:
        """Add the wall-clock time [s] of a step with the present number of threads."""
        number, self._sum = self.number, self._sum + taken
        self._done += 1
        if self._done % self._steps == 0:
            self._times[number].append(self._sum)
            self._sum = 0.0

    @property
    def best(self) -> int:
        """Number of threads with the shortest steps in the trial. A larger number replaces the next smaller number only if
        its steps are clearly shorter."""
        cost = {number: median(times) for number, times in self._times.items()}
        found = self._numbers[0]
        for fewer, more in pairwise(self._numbers):
            if found == fewer and cost[more] < GAIN * cost[fewer]:
                found = more
        return found
