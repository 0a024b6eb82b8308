"""Number of steps of a run before it begins, and the step limit or the load steps that determine it."""

from collections.abc import Iterator
from math import ceil, hypot, inf, isfinite, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.case.steady import deforming_bodies, sought_bodies, why_not_factored
from pellucid.conditions.prescribed_motion import Motion
from pellucid.contact.overlap import RESOLVED, swing_of
from pellucid.parts.body_model import is_alone
from pellucid.parts.condition import Condition, conditions_in_case, is_driven
from pellucid.progress import clock
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


class Foretold(NamedTuple):
    """Forecast of the remaining steps of a run if the time step does not change: time step, number of steps, and a text
    with the reason for the time step or for a missing forecast (`why`)."""

    step: float
    """Time step [s]; nan if unknown."""
    number: float
    """Number of steps until the end; nan if unknown."""
    why: str
    """Description of the step limit, as a clause, or the reason why the step is unknown."""


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
    if steady.control == "arc-length":
        text = (
            f"up to {number} equilibria along a path, with a factored stiffness of {_factors(case, 2)} in each iteration; the "
            "number of iterations is not known in advance"
        )
        return Foretold(UNKNOWN, UNKNOWN, text)
    if steady.is_factored(parts_of(case)):
        text = (
            f"{number} steady state{'s' * (number != 1)} with a factored stiffness of {_factors(case)}; the number of "
            "iterations is not known in advance"
        )
        for name, axes in sought_bodies(parts_of(case)).items():
            text += f". The loads on the rigid body {name} move it along {axes} until contact balances them"
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


def _factors(case: "Case", copies: int = 1) -> str:
    """Return a text on the size of the factored stiffness of a case and the time of a factorisation; copies: 2 if both factors
    of the matrix are computed and stored, as for a matrix that is not definite."""
    sizes = [size for body in deforming_bodies(parts_of(case)) if (size := body.stiffness_size()) is not None]
    unknowns = sum(size.unknowns for size in sizes)
    memory = copies * sum((4e-6 if size.is_approximate else 8e-6) * size.numbers for size in sizes)
    seconds = copies * sum(size.operations / OPERATIONS + size.numbers / NUMBERS for size in sizes)
    known = f"about {clock(seconds)}" if seconds >= 0.1 else "less than 0.1 s"
    needed = f"{memory:.3g} MB" if memory < 1e3 else f"{1e-3 * memory:.2g} GB"
    text = f"{unknowns} unknowns: {needed} and {known} for each factorisation"
    if not any(size.is_approximate for size in sizes):
        return text
    return (
        f"{text} (factors of the linear tetrahedra of the mesh, an approximation, since those of the solid are too large: "
        "stability and lowest frequencies are not computed)"
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
