"""Text of the forecast in `validate` and in the first lines of a run."""

from contextlib import suppress
from math import isnan, sqrt
from typing import Any

from pellucid.case import Case
from pellucid.errors import UsageError
from pellucid.progress import clock
from pellucid.running.forecast.hints import implicit_viscosity
from pellucid.running.forecast.pace import Pace, Paces
from pellucid.running.forecast.steps import Foretold, of_case, of_simulation

WIDE = 2.0
"""Largest ratio of the bounds of the run time at which only their geometric mean is reported."""


def foretell_case(case: "Case") -> list[str]:
    """Return the lines of text about step limit, number of steps and run time of a case that `validate` shows. Raises the
    CaseError of a case that cannot be set up."""
    return lines(case, of_case(case), pace_of(case))


def foretell_simulation(simulation: Any) -> list[str]:
    """Return lines of text on step limit, remaining number of steps and run time of a simulation."""
    return lines(simulation.case, of_simulation(simulation), pace_of(simulation.case))


def pace_of(case: "Case") -> Pace | None:
    """Return the expected wall-clock time per step of a case on this machine, from earlier runs; None if there are no
    similar runs, or no folder in which the times could be stored."""
    with suppress(UsageError):
        return Paces().seconds_of_a_step(case)
    return None


def lines(case: "Case", foretold: Foretold, each: Pace | None) -> list[str]:
    """Return a line of text about the steps and a line about the run time, and a hint if implicit viscosity would allow
    much longer steps.

    foretold: forecast of the steps. each: wall-clock time per step from earlier runs, or None.
    """
    hint = implicit_viscosity(case)
    return [*_two_lines(case, foretold, each), *([] if hint is None else [hint])]


def _two_lines(case: "Case", foretold: Foretold, each: Pace | None) -> list[str]:
    settling = "settling steps (number unknown), then " if case.settle is not None else ""
    if isnan(foretold.number):
        steps = f"steps: {settling}{foretold.why}"
    else:
        about = "" if case.time.step is not None else "about "
        steps = f"steps: {settling}{about}{foretold.number:.0f} of {foretold.step:.3g} s, {foretold.why}"
    if each is None:
        later = "an estimate follows after the first second of the run"
        return [steps, f"time: unknown, because no similar case has run on this machine yet; {later}"]
    if isnan(foretold.number):
        return [steps, f"time: about {1e3 * sqrt(each.least * each.most):.2g} ms per step on this machine"]
    least, most = each.least * foretold.number, each.most * foretold.number
    taken = f"about {clock(sqrt(least * most))}" if most <= WIDE * least else f"between {clock(least)} and {clock(most)}"
    return [steps, f"time: {taken} on this machine, excluding set-up, compilation and report"]
