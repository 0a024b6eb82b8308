"""How long steps take on this machine, learned from the runs that were done on it.

Each run leaves its time of a step and how many points of each kind its bodies have. The time of a step of another case is
fitted to these, as a time for each step, for each body, and for each point of a kind; then it is scaled by what runs that need
the same kernels took.
"""

import json
import os
from contextlib import suppress
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.jit import cache_folder
from pellucid.simulation.kernel_key import kernel_key

if TYPE_CHECKING:
    from pellucid.case import Case

FEWEST_STEPS, LEAST_SECONDS = 20, 0.2
"""Of a run that teaches something."""
KEPT = 6
"""Runs of the same kernels that are remembered, the last ones."""
REACH = 10.0
"""Times as many points as a run had, of which its time tells something."""
STEP, BODY = "step", "body"


class Sample(NamedTuple):
    """What a step of a run took [s], and how many there are in its case of what takes time."""

    seconds: float
    counts: dict[str, float]


class Paces:
    """What this machine has learned, in a folder beside the compiled kernels."""

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder or cache_folder().parent / "paces"

    def learn(self, case: "Case", steps: int, seconds: float) -> None:
        """Remember a run. Silent where the folder cannot be written."""
        if steps < FEWEST_STEPS or seconds < LEAST_SECONDS:
            return
        key = kernel_key(case)
        samples = [*self._read(self.folder / f"{key}.json"), Sample(seconds / steps, counts_of(case))][-KEPT:]
        with suppress(OSError):
            self.folder.mkdir(parents=True, exist_ok=True)
            part = self.folder / f"{key}.{os.getpid()}.part"
            part.write_text(json.dumps(samples), encoding="utf-8")
            part.replace(self.folder / f"{key}.json")

    def seconds_of_a_step(self, case: "Case") -> float | None:
        """About how long a step of a case takes [s]; None where no run had bodies of its kinds and not far fewer points."""
        key, counts = kernel_key(case), counts_of(case)
        with suppress(OSError):
            known = {path.stem: self._read(path) for path in sorted(self.folder.glob("*.json"))}
            samples = [sample for of_key in known.values() for sample in of_key]
            largest = {name: max(sample.counts.get(name, 0.0) for sample in samples) for name in counts} if samples else {}
            if samples and all(count <= REACH * largest[name] for name, count in counts.items()):
                cost = _fitted(samples, sum(counts.values()))
                same = [sample.seconds / _time(cost, sample.counts) for sample in known.get(key, ())]
                return _time(cost, counts) * (median(same) if same else 1.0)
        return None

    @staticmethod
    def _read(path: Path) -> list[Sample]:
        """What a file remembers; nothing of one that is not there or is damaged."""
        with suppress(OSError, ValueError, TypeError, AttributeError):
            found = [Sample(float(seconds), dict(counts)) for seconds, counts in json.loads(path.read_text(encoding="utf-8"))]
            if all(sample.seconds > 0.0 and min(sample.counts.values()) >= 0.0 for sample in found):
                return found
        return []


def counts_of(case: "Case") -> dict[str, float]:
    """How many there are of what takes time: one step, bodies, and points by their kind, law and shape functions."""
    counts = {STEP: 1.0, BODY: float(len(case.body))}
    functions = f"{case.grid.functions} {3 - sum(case.thin)}-D" if case.grid_or_none is not None else "no grid"
    for model in case.body:
        own = getattr(model, "approximant", None)
        name = " ".join((model.kind, model.material.kind, own.kind if own is not None else functions))
        counts[name] = counts.get(name, 0.0) + float(model.with_others(case.body).n_points(case.grid_or_none))
    return counts


def _fitted(samples: list[Sample], size: float) -> dict[str, float]:
    """The times [s] of one of each that come nearest to those of the samples, relative to these; none is negative.

    Samples count less that are larger or smaller than a size: where there are few points, other things take the time.
    """
    names = sorted({name for sample in samples for name in sample.counts})
    ratio = np.array([sum(sample.counts.values()) / size for sample in samples])
    weight = np.sqrt(np.minimum(ratio, 1.0 / ratio))
    rows = np.array([[sample.counts.get(name, 0.0) / sample.seconds for name in names] for sample in samples])
    rows *= weight[:, None]
    scale = np.where(rows.any(axis=0), np.linalg.norm(rows, axis=0), 1.0)
    cost, takes = np.zeros(len(names)), np.ones(len(names), bool)
    while takes.any():
        cost[:] = 0.0
        cost[takes] = np.linalg.lstsq(rows[:, takes] / scale[takes], weight, rcond=1e-9)[0] / scale[takes]
        if cost.min() >= 0.0:
            break
        takes &= cost > 0.0
    return dict(zip(names, cost.tolist(), strict=True))


def _time(cost: dict[str, float], counts: dict[str, float]) -> float:
    return sum(cost[name] * count for name, count in counts.items()) or float("nan")
