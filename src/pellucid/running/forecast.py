"""Forecast of a run before it begins: step limit, number of steps, run time on this machine.

Each run stores its time per step and the size of its case, i.e. the memory of bodies and grid. The time of another run is
predicted from runs that need the same kernels, i.e. have the same kinds of bodies, laws, functions and conditions, if one of
them has about its size or if its size is between those of two of them.
"""

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from math import ceil, exp, hypot, inf, isfinite, isnan, log, sqrt
from operator import methodcaller
from pathlib import Path
from statistics import median
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

from pellucid.case import Case
from pellucid.case.memory import PROGRAM_BYTES, memory_estimate
from pellucid.case.sections import parts_of
from pellucid.case.steady import deforming_bodies, why_not_factored
from pellucid.compilation.reporting import kernel_key
from pellucid.conditions.prescribed_motion import Motion
from pellucid.contact.overlap import RESOLVED, swing_of
from pellucid.errors import UsageError
from pellucid.jit import cache_folder
from pellucid.materials.contract import PointMaterial
from pellucid.parts.body_model import is_alone
from pellucid.parts.condition import Condition, conditions_in_case, is_driven
from pellucid.progress import Pace, Progress, clock
from pellucid.set_up.even_densities import accepts, in_words, settings_for_even_densities
from pellucid.step.limit import (
    NO_LIMIT,
    StepLimit,
    fall_through_cells,
    motion_in_cells,
    swings,
    tightest,
    time_to_fall,
    with_consistent_mass,
)

if TYPE_CHECKING:
    from pellucid.case.steady import SteadyCase
    from pellucid.results.storage.recorder import Recorder


class StepTime(NamedTuple):
    """Expected wall-clock time per step of a case: lower and upper bound [s], which are equal if earlier runs determine the
    time."""

    least: float
    most: float


class Foretold(NamedTuple):
    """Forecast of the remaining steps of a run if the time step does not change: time step, number of steps, and a text
    with the reason for the time step or for a missing forecast (`why`)."""

    step: float
    """Time step [s]; nan if unknown."""
    number: float
    """Number of steps until the end; nan if unknown."""
    why: str
    """Description of the step limit, as a clause, or the reason why the step is unknown."""


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
        return [steps, "time: not known in advance; the run shows load step, iteration and estimated error"]
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


UNKNOWN = float("nan")
Limits = dict[tuple[str, str], StepLimit | None]
"""Step limits by the name of the body and an additional key (a motion or contact); None if a limit is unknown."""


def of_case(case: "Case") -> Foretold:
    """Return the forecast of time step and number of steps for the whole run of a case, computed without building its
    bodies; unknown if the step limit of a body is known only after the body is built."""
    if case.steady is not None:
        return _steady(case, case.steady)
    if case.time.method == "implicit":
        return _implicit_steps(case, 0.0)
    limits = dict(_limits(case))
    unknown = [key[0] for key, limit in limits.items() if limit is None]
    if unknown and case.time.step is None:
        text = f"limited by body `{unknown[0]}`; the time step is computed when the run starts"
        return Foretold(UNKNOWN, UNKNOWN, text)
    return _foretold(case, *_tightest(limits), 0.0)


def of_simulation(simulation: Any, until: float | None = None) -> Foretold:
    """Return the forecast of time step and number of steps of a simulation, from its present state to the end of its case
    or to an earlier time `until` [s]."""
    case = simulation.case
    if case.steady is not None:
        return _steady(case, case.steady)
    if case.time.method == "implicit":
        return _implicit_steps(case, simulation.time, until)
    limit, name = simulation.step_limit()
    if simulation.n_steps == 0:  # the state of bodies at rest does not show all limits yet
        limit, name = _tightest({(name, "now"): limit, **_limits(case)})
    return _foretold(case, limit, name, simulation.time, until)


def limit_of_model(case: "Case") -> StepLimit:
    """Return the smallest of the step limits at the start of a case. Only limits that are known before the bodies are built
    count."""
    return _tightest(_limits(case))[0]


def _tightest(limits: "Limits") -> tuple[StepLimit, str]:
    known = {key: limit for key, limit in limits.items() if limit is not None}
    first = min(known, key=lambda key: known[key].step, default=None)
    return (NO_LIMIT, "") if first is None else (known[first], first[0])


def _foretold(case: "Case", limit: StepLimit, name: str, now: float, until: float | None = None) -> Foretold:
    time = case.time
    left = (time.end if until is None else min(until, time.end)) - now
    rows = time.end / max(1, round(time.end / case.longest_step)) if isfinite(case.longest_step) else inf
    because = (f"body `{name}` ({limit.cause}): " if name else "") + limit.reason
    if time.step is not None:
        if not isfinite(limit.step):
            return _counted(left, time.step, "limited by time.step")
        by = f" of body `{name}`" if name else ""
        text = f"time.step is {time.step / limit.step:.2g} of the stable step{by}: {limit.reason}"
        return _counted(left, time.step, text)
    if rows <= time.courant * limit.step:
        own = any(body.has_own_step for body in case.body)
        more = "bodies with their own time steps subdivide these steps according to `accuracy`"
        text = more if own else "there are more steps if the motion becomes fast enough to limit them"
        return _counted(left, rows, f"limited by output.history; {text}")
    courant = "" if limit.cause == "contact" else f"; time.courant = {time.courant:g}"
    return _counted(left, time.courant * limit.step, f"limited by {because}{courant}")


def _counted(left: float, step: float, why: str) -> Foretold:
    step = min(step, left)
    return Foretold(step, ceil(left / step * (1.0 - 1e-9)) if step > 0.0 else 0, why)


OPERATIONS, NUMBERS = 5e10, 2e7
"""Operations and numbers of factors per second in a factorisation on one core, with the assembly of the matrix: the sum of both
times agrees with those measured for 400 to 16 000 unknowns within a factor of two."""


def _steady(case: "Case", steady: "SteadyCase") -> Foretold:
    number, most = len(steady.levels(case.time.end)) - 1, steady.most_steps
    if steady.is_factored(parts_of(case)):
        text = (
            f"{number} steady state{'s' * (number != 1)} with a factored stiffness of {_factors(case)}; the number of "
            "iterations is not known in advance"
        )
        return Foretold(UNKNOWN, UNKNOWN, text)
    text = (
        f"{number} steady state{'s' * (number != 1)}, each in at most {most} steps of the relaxation (`steady.most_steps`); "
        "their number is not known in advance"
    )
    if steady.method is None and (reason := why_not_factored(parts_of(case))) is not None:
        text += f". They are relaxed because {reason}"
    return Foretold(UNKNOWN, UNKNOWN, text)


def _implicit_steps(case: "Case", now: float, until: float | None = None) -> Foretold:
    """Return the forecast of implicit time steps from the time `now` to the end of the case, or to `until` [s]."""
    time = case.time
    left = (time.end if until is None else min(until, time.end)) - now
    text = f"time.step; implicit, with a factored stiffness of {_factors(case)}, which serves for many steps"
    return _counted(left, time.step or time.end, text)


def _factors(case: "Case") -> str:
    """Return a text on the size of the factored stiffness of a case and the time of a factorisation."""
    sizes = [size for body in deforming_bodies(parts_of(case)) if (size := body.stiffness_size()) is not None]
    unknowns = sum(size.unknowns for size in sizes)
    memory = sum((4e-6 if size.is_approximate else 8e-6) * size.numbers for size in sizes)
    seconds = sum(size.operations / OPERATIONS + size.numbers / NUMBERS for size in sizes)
    known = f"about {clock(seconds)}" if seconds >= 0.1 else "less than 0.1 s"
    text = f"{unknowns} unknowns: {memory:.2g} MB and {known} for each factorisation"
    if not any(size.is_approximate for size in sizes):
        return text
    return (
        f"{text} (approximate, that of the linear tetrahedra of the mesh, since its own factors are too large: stability and "
        "lowest frequencies are not computed)"
    )


def _limits(case: "Case") -> Limits:
    """Return the step limits at the start of a case: of bodies, prescribed motions, free fall and contacts of rigid bodies."""
    parts = parts_of(case)
    cell = case.grid.cell if case.grid_or_none is not None else None
    driven = {body.name for body in case.body if is_driven(body.name, parts)}
    found = Limits()
    for body in (model.with_others(case.body) for model in case.body):
        own = body.limit_in_motion(cell, body.name in driven)
        consistent = case.time.mass_matrix == "consistent" and not body.owns_nodes(is_alone(body, parts))
        found[body.name, ""] = with_consistent_mass(own) if consistent and own is not None else own
    for condition in conditions_in_case(parts):
        for body in case.body:
            if (own := found[body.name, ""]) is not None:
                found[body.name, ""] = _beside(own, condition, condition.swing_of(body, 1.0 / own.step, cell))
    if cell is None:
        return found
    for motion in case.motion:
        found[motion.body, motion.name] = motion_in_cells(cell, _top_speed(motion))
    pull = case.largest_gravity
    if pull > 0.0:
        found["", ""] = fall_through_cells(time_to_fall(cell, pull))
    for name, limit in _contacts_of_hard_bodies(case, driven, cell, pull):
        found[name, "contact"] = tightest([limit, *([known] if (known := found.get((name, "contact"))) else [])])
    return found


def _beside(own: StepLimit, condition: Condition, swing: float) -> StepLimit:
    """Return the step limit of a body that also oscillates at the rate `swing` [1/s] against the elastic force of a
    condition, such as a contact or spring. own: step limit of the body without the condition."""
    step = 1.0 / hypot(1.0 / own.step, swing) if swing > 0.0 else own.step
    if swing * own.step <= 1.0:
        return own._replace(step=step)
    return StepLimit(step, condition.swings_as.cause, f"{condition.swings_as.reason}, which limits the step to {step:.3g} s")


def _top_speed(motion: Motion) -> float:
    """Return an upper bound of the speed of a prescribed motion [m/s]."""
    signals = (getattr(motion.displacement, axis) for axis in ("x", "y", "z"))
    return sqrt(sum(signal.top_speed() ** 2 for signal in signals if signal is not None))


def _contacts_of_hard_bodies(case: "Case", driven: set[str], cell: float, pull: float) -> Iterator[tuple[str, StepLimit]]:
    """Yield (name of the body, step limit) for rigid and fully driven bodies in contact.

    The step must resolve the oscillation of these bodies on the contact springs to other bodies and walls, independently of
    `time.courant`. driven: names of bodies whose motion is fully prescribed. cell: cell size [m]. pull: acceleration of
    gravity [m/s²].
    """
    hard = (body for body in case.body if body.is_rigid or body.name in driven)
    speeds = {body.name: body.fastest_at_start(body.places_between_bounds()) for body in hard}
    rigid = [body for body in case.body if body.is_rigid]
    walled = {body.name for wall in case.wall for body in wall.touching(case.body)}

    def limit(speed: float) -> StepLimit:
        rate = swing_of(cell, pull, speed) / RESOLVED
        return swings(case.time.courant * rate, "contact")

    for body in rigid:
        if body.name in walled:
            yield body.name, limit(speeds[body.name])
        for other in case.body:
            if other.field != body.field and other.name in speeds:
                yield body.name, limit(speeds[body.name] + speeds[other.name])


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
