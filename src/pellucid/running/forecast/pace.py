"""Wall-clock time per step on this machine, learned from previous runs.

Each run stores its time per step and the size of its case, i.e. the memory of bodies and grid. The time of another run is
predicted from runs that need the same kernels, i.e. have the same kinds of bodies, laws, functions and conditions, if one of
them has about its size or if its size is between those of two of them.
"""

import json
import os
from contextlib import suppress
from math import exp, log
from pathlib import Path
from statistics import median
from typing import NamedTuple

from pellucid.case import Case
from pellucid.case.memory import PROGRAM_BYTES, memory_estimate
from pellucid.compilation.kernel_key import kernel_key
from pellucid.jit import cache_folder

FEWEST_STEPS, LEAST_SECONDS = 20, 0.2
"""Smallest number of steps and smallest duration [s] of a run whose time per step is stored."""
KEPT = 12
"""Number of runs with the same kernels whose times are stored; the latest are kept."""
SAME = 1.02
"""Largest ratio of the sizes of two cases that count as equal. The median of the last three such runs is used."""


class Pace(NamedTuple):
    """Expected wall-clock time per step of a case: lower and upper bound [s], which are equal if earlier runs determine the
    time."""

    least: float
    most: float


class Sample(NamedTuple):
    """Record of a previous run: size of its case, i.e. memory of bodies and grid [bytes], and its wall-clock time per step
    [s]."""

    size: float
    seconds: float


class Paces:
    """Store of the wall-clock times per step of previous runs on this machine, from which the time per step of a case is
    predicted. folder: folder of the files; default: next to the compiled kernels."""

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder or cache_folder().parent / "paces"

    def learn(self, case: "Case", steps: int, seconds: float) -> None:
        """Store the wall-clock time per step of a run (`seconds` for `steps` steps), unless the folder is not writable."""
        if steps < FEWEST_STEPS or seconds < LEAST_SECONDS:
            return
        file = self._file(case)
        samples = [*self._read(file), Sample(size_of(case), seconds / steps)][-KEPT:]
        with suppress(OSError):
            self.folder.mkdir(parents=True, exist_ok=True)
            part = file.with_suffix(f".{os.getpid()}.part")
            part.write_text(json.dumps(samples), encoding="utf-8")
            part.replace(file)

    def seconds_of_a_step(self, case: "Case") -> Pace | None:
        """Return the expected wall-clock time per step of a case; None if no similar case was run on this machine.

        For a case that is larger or smaller than all stored runs, the bounds allow for a time per step that is proportional
        to the size, as in large cases, or independent of the size, as in small cases.
        """
        samples, size = self._read(self._file(case)), size_of(case)
        same = [sample.seconds for sample in samples if size / SAME <= sample.size <= size * SAME]
        if same:
            return Pace(median(same[-3:]), median(same[-3:]))
        below = max((sample for sample in samples if sample.size < size), default=None)
        above = min((sample for sample in samples if sample.size > size), default=None)
        if below and above:
            share = log(size / below.size) / log(above.size / below.size)
            between = exp((1.0 - share) * log(below.seconds) + share * log(above.seconds))
            return Pace(between, between)
        near = below or above
        if near is None:
            return None
        with_size = near.seconds * size / near.size
        return Pace(min(near.seconds, with_size), max(near.seconds, with_size))

    def _file(self, case: "Case") -> Path:
        return self.folder / f"{kernel_key(case)}.json"

    @staticmethod
    def _read(file: Path) -> list[Sample]:
        """Return the samples in a file; an empty list if the file is missing or damaged."""
        with suppress(OSError, ValueError, TypeError):
            found = [Sample(float(size), float(seconds)) for size, seconds in json.loads(file.read_text(encoding="utf-8"))]
            if all(sample.size > 0.0 and sample.seconds > 0.0 for sample in found):
                return found
        return []


def size_of(case: "Case") -> float:
    """Return the memory of the bodies and the grid of a case [bytes], as a measure of the cost of a step."""
    return memory_estimate(case) - PROGRAM_BYTES
