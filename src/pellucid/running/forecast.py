"""Forecast of a run before it begins: its steps and its run time on this machine.

Each run stores its time per step and the size of its case, i.e. the memory of bodies and grid. The time of another run is
predicted from runs that need the same kernels, i.e. have the same kinds of bodies, laws, functions and conditions, if one of
them has about its size or if its size is between those of two of them.
"""

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from math import exp, inf, isfinite, isnan, log, sqrt
from operator import methodcaller
from pathlib import Path
from statistics import median
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

from pellucid.case import Case
from pellucid.case.memory import PROGRAM_BYTES, memory_estimate
from pellucid.case.sections import parts_of
from pellucid.compilation.reporting import kernel_key
from pellucid.errors import UsageError
from pellucid.jit import cache_folder
from pellucid.materials.contract import PointMaterial
from pellucid.progress import Pace, Progress, clock
from pellucid.running.step_number import Foretold, limit_of_model, of_case, of_simulation
from pellucid.set_up.even_densities import accepts, in_words, settings_for_even_densities
from pellucid.step.limit import (
    StepLimit,
)

if TYPE_CHECKING:
    from pellucid.results.storage.recorder import Recorder


class StepTime(NamedTuple):
    """Expected wall-clock time per step of a case: lower and upper bound [s], which are equal if earlier runs determine the
    time."""

    least: float
    most: float


def foretold(simulation: Any, until: float | None, progress: Progress) -> Progress:
    """Show the forecast (step limit, number of steps, run time) when a run begins or resumes. Returns the progress object
    for the run: `progress`, or an object that forwards to `progress` and also shows the run time after the first second, if
    the run time is unknown before.

    until: time at which the run ends [s]; default: end of the case.
    """
    each, ahead = pace_of(simulation.case), of_simulation(simulation, until)
    for line in lines(simulation.case, ahead, each):
        progress.note(line)
    known = each is not None and each.most <= WIDE * each.least
    return progress if known or simulation.case.steady is not None else ToldOnTheWay(progress)


@contextmanager
def pace_learned(simulation: Any, recorder: "Recorder") -> Iterator[None]:
    """Store the wall-clock time per step of the block for later forecasts, also if the block ends with an error. The block runs
    the simulation; `recorder` counts the time."""
    from numba import config

    steps, seconds = simulation.n_steps, recorder.wall_seconds()
    try:
        yield
    finally:
        settled = simulation.facts().get("settled", {}).get("steps", 0) if steps == 0 else 0
        if not config.DISABLE_JIT:
            with suppress(UsageError):  # there is no folder
                Paces().learn(simulation.case, simulation.n_steps - steps + settled, recorder.wall_seconds() - seconds)


WIDE = 2.0
"""Largest ratio of the bounds of the run time at which only their geometric mean is reported."""


def foretell_case(case: "Case") -> list[str]:
    """Return the lines of text about step limit, number of steps and run time of a case that `validate` shows. Raises the
    CaseError of a case that cannot be set up."""
    return lines(case, of_case(case), pace_of(case))


def foretell_simulation(simulation: Any) -> list[str]:
    """Return lines of text on step limit, remaining number of steps and run time of a simulation."""
    return lines(simulation.case, of_simulation(simulation), pace_of(simulation.case))


def pace_of(case: "Case") -> StepTime | None:
    """Return the expected wall-clock time per step of a case on this machine, from earlier runs; None if there are no
    similar runs, or no folder in which the times could be stored."""
    with suppress(UsageError):
        return Paces().seconds_of_a_step(case)
    return None


def lines(case: "Case", foretold: Foretold, each: StepTime | None) -> list[str]:
    """Return a line of text about the steps and a line about the run time, and a hint if implicit pressure or viscosity would
    allow much longer steps.

    foretold: forecast of the steps. each: wall-clock time per step from earlier runs, or None.
    """
    hint = implicit_hint(case)
    return [*_two_lines(case, foretold, each), *([] if hint is None else [hint])]


def _two_lines(case: "Case", foretold: Foretold, each: StepTime | None) -> list[str]:
    settling = "settling steps (number unknown), then " if case.settle is not None else ""
    if isnan(foretold.number):
        steps = f"steps: {settling}{foretold.why}"
    else:
        about = "" if case.time.step is not None else "about "
        steps = f"steps: {settling}{about}{foretold.number:.0f} of {foretold.step:.3g} s, {foretold.why}"
    if case.steady is not None and case.steady.is_factored(parts_of(case)):
        shown = "load step, iteration and estimated error"
        if case.steady.control == "arc-length":
            shown = "equilibrium, iteration and load factor"
        return [steps, f"time: not known in advance; the run shows {shown}"]
    if each is None:
        later = "an estimate follows after the first second of the run"
        return [steps, f"time: unknown, because no similar case has run on this machine yet; {later}"]
    if isnan(foretold.number):
        return [steps, f"time: about {1e3 * sqrt(each.least * each.most):.2g} ms per step on this machine"]
    least, most = each.least * foretold.number, each.most * foretold.number
    taken = f"about {clock(sqrt(least * most))}" if most <= WIDE * least else f"between {clock(least)} and {clock(most)}"
    return [steps, f"time: {taken} on this machine, excluding set-up, compilation and report"]


WORTHWHILE = 5.0
"""Smallest ratio of the time steps at which implicit viscosity is suggested: its steps cost two to four times as much."""
GAIN = 2.0
"""Smallest ratio of the run times at which implicit pressure is suggested."""
PASS_COST = 0.2
"""Cost of an iteration for implicit pressure, relative to an explicit step."""


def _implicit(case: "Case", change: Callable[[PointMaterial], PointMaterial | None]) -> tuple["Case", list[str]]:
    """Return the case with the materials that `change` returns, and the names of the bodies whose material it changes."""
    changed, names = [], []
    for body in case.body:
        material = getattr(body, "material", None)
        other = change(material) if isinstance(material, PointMaterial) else None
        names += [] if other is None else [body.name]
        changed.append(body if other is None else body.model_copy(update={"material": other}))
    return case.model_copy(update={"body": tuple(changed)}), names


def implicit_hint(case: "Case") -> str | None:
    """Return a text that suggests implicit pressure or viscosity if only sound or viscosity limits the time step of the case,
    else None."""
    if case.grid_or_none is None or case.steady is not None or case.time.scheme == "usf":
        return None
    limit = limit_of_model(case)
    if limit.cause in ("wave", "membrane", "viscous") and (hint := _pressure_hint(case, limit)) is not None:
        return hint
    if limit.cause != "viscous":
        return None
    other, names = _implicit(case, methodcaller("with_implicit_viscosity"))
    longer = limit_of_model(other).step / limit.step if names else 1.0
    if not isfinite(longer) or longer < WORTHWHILE:
        return None
    keys = " and ".join(f"body.{name}.material.implicit_viscosity" for name in names)
    return f"hint: {keys} = true would allow time steps {longer:.2g} times as long, at two to four times the cost per step"


def _pressure_hint(case: "Case", limit: StepLimit) -> str | None:
    """Return a text that suggests implicit pressure if it is possible in the case, with steps up to the interval of the
    history, and would take at most half of the run time; else None. limit: step limit of the case as it is."""
    other, names = _implicit(case, methodcaller("with_implicit_pressure"))
    courant = case.time.courant
    step = min(courant * limit_of_model(other).step, case.output.rows_every(case.time.end))
    longer = step / (courant * limit.step)
    cost = _cost_of_pressure(other, step)
    if longer < max(WORTHWHILE, GAIN * cost):
        return None
    keys = {f"body.{name}.material.implicit_pressure": True for name in names}
    settings = keys | {"time.scheme": "usl"}
    if not accepts(case, settings):
        return None
    text = f"would allow time steps up to {longer:.3g} times as long, at about {cost:.2g} times the cost per step"
    text = f'hint: {" and ".join(keys)} = true, with time.scheme = "usl", {text}'
    if also := settings_for_even_densities(case, names, settings):
        text += f"; in confined flow also set {in_words(also)}: otherwise volumes of single points may become negative"
    return text


def _cost_of_pressure(case: "Case", step: float) -> float:
    """Return the cost of a step [s] with implicit pressure, relative to an explicit one: about 5 √(1 + ρc²Δt/μ) iterations
    and three more passes over the points, see `docs/physics/fluids.md`."""
    stresses = [body.implicit_stress for body in case.body if body.implicit_stress is not None]
    ratio = max((stress.stiffness * step / stress.mu if stress.mu > 0.0 else inf for stress in stresses), default=0.0)
    return 1.0 + PASS_COST * (3.0 + 5.0 * sqrt(1.0 + ratio))


ENOUGH = 1.0
"""Duration of the measured steps after which the run time is reported [s], if these steps are enough for it
(`pellucid.progress.FEWEST_STEPS`)."""
RUNNING = "running"


class ToldOnTheWay(Progress):
    """Progress display that forwards all reports of a run to another display `progress`, and also shows the expected
    remaining run time once the time per step has been measured for a second and enough steps since the last compilation. Used
    if no earlier run predicts the run time."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._pace = progress, Pace()
        self._phase, self._end, self._told = "", 0.0, False

    def begin(self, phase: str, total: float | None = None) -> None:
        self._phase, self._end, self._pace = phase, total or 0.0, Pace()
        self._progress.begin(phase, total)

    def compiling(self, kernel: str, number: int, expected: int) -> None:
        self._progress.compiling(kernel, number, expected)

    def compiled(self) -> None:
        """Measure the time per step again from the next step on."""
        self._pace.start_again()
        self._progress.compiled()

    def update(self, *, step: int, time: float, dt: float, points: int, energy_error: float, search: str = "") -> None:
        self._progress.update(step=step, time=time, dt=dt, points=points, energy_error=energy_error, search=search)
        if self._told or self._phase != RUNNING:
            return
        self._pace.add(monotonic(), step, time)
        if self._pace.is_known and self._pace.seconds() >= ENOUGH:
            self._told = True
            left = clock(self._pace.typical_time_left(self._end))
            self._progress.note(f"time: about {left} remaining, estimated at step {step}")

    def count(self, done: int) -> None:
        self._progress.count(done)

    def message(self, text: str) -> None:
        self._progress.message(text)

    def note(self, text: str) -> None:
        self._progress.note(text)

    def stop(self) -> None:
        self._progress.stop()


FEWEST_STEPS, LEAST_SECONDS = 20, 0.2
"""Smallest number of steps and smallest duration [s] of a run whose time per step is stored."""
KEPT = 12
"""Number of runs with the same kernels whose times are stored; the latest are kept."""
SAME = 1.02
"""Largest ratio of the sizes of two cases that count as equal. The median of the last three such runs is used."""


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

    def seconds_of_a_step(self, case: "Case") -> StepTime | None:
        """Return the expected wall-clock time per step of a case; None if no similar case was run on this machine.

        For a case that is larger or smaller than all stored runs, the bounds allow for a time per step that is proportional
        to the size, as in large cases, or independent of the size, as in small cases.
        """
        samples, size = self._read(self._file(case)), size_of(case)
        same = [sample.seconds for sample in samples if size / SAME <= sample.size <= size * SAME]
        if same:
            return StepTime(median(same[-3:]), median(same[-3:]))
        below = max((sample for sample in samples if sample.size < size), default=None)
        above = min((sample for sample in samples if sample.size > size), default=None)
        if below and above:
            share = log(size / below.size) / log(above.size / below.size)
            between = exp((1.0 - share) * log(below.seconds) + share * log(above.seconds))
            return StepTime(between, between)
        near = below or above
        if near is None:
            return None
        with_size = near.seconds * size / near.size
        return StepTime(min(near.seconds, with_size), max(near.seconds, with_size))

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
