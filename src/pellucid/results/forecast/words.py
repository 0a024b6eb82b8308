"""What `validate` and the first lines of a run say of the steps ahead."""

from math import isnan
from typing import TYPE_CHECKING

from pellucid.progress import clock
from pellucid.results.forecast.pace import Paces
from pellucid.results.forecast.steps import Foretold, of_case

if TYPE_CHECKING:
    from pellucid.case import Case


def foretell_case(case: "Case") -> list[str]:
    """What bounds the step and how many that makes; how long they take here. Raises CaseError as the set-up of the case."""
    return lines(case, of_case(case), pace_of(case))


def pace_of(case: "Case") -> float | None:
    """The time of a step on this machine [s], if it is known."""
    return Paces().seconds_of_a_step(case)


def lines(case: "Case", foretold: Foretold, each: float | None, runs: bool = False) -> list[str]:
    """Two lines; each: the time of a step [s], if it is known; runs: whether these are of a run that begins."""
    settling = "some to settle, then " if case.settle is not None else ""
    if isnan(foretold.number):
        steps = f"steps: {settling}{foretold.why}"
    else:
        about = "" if case.time.step is not None else "about "
        steps = f"steps: {settling}{about}{foretold.number:.0f} of {foretold.step:.3g} s, bounded by {foretold.why}"
    if each is None:
        later = "it is told after a second of steps" if runs else "one tells after its first second"
        return [steps, f"time: no run like it on this machine tells; {later}"]
    if isnan(foretold.number):
        return [steps, f"time: about {1e3 * each:.2g} ms a step on this machine"]
    return [steps, f"time: about {clock(each * foretold.number)} on this machine, beside set-up, compilation and report"]
