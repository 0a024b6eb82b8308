"""Metrics: what a run found beside what it should have found, and how far apart the two may be."""

import math
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pellucid.results.run import Run


@dataclass(frozen=True)
class Metric:
    """A number of a run beside its reference."""

    value: float
    reference: float
    error: float
    """How far the value is from the reference, in the measure that `meaning` states; not negative."""
    tolerance: float
    unit: str = ""
    """Unit of value and reference; empty for a pure number."""
    meaning: str = ""

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance; an error that is not a number never is."""
        return bool(self.error <= self.tolerance)

    def to_data(self) -> dict[str, Any]:
        """The metric as `summary.json` holds it; a number that JSON does not know becomes null."""
        return {
            "value": finite(self.value),
            "reference": finite(self.reference),
            "error": finite(self.error),
            "tolerance": finite(self.tolerance),
            "pass": self.passed,
        }


def finite(number: float) -> float | None:
    """The number, or None for one that is not finite."""
    return float(number) if math.isfinite(number) else None


def evaluate(run: "Run") -> dict[str, Metric]:
    """The metrics of a finished run by name, from the module of its gallery case.

    Empty for a case of the user's own and for a run stopped early. Empty with a warning where the module cannot judge
    the run: settings may have made of the case what its reference does not cover.
    """
    from pellucid import gallery

    module = gallery.module(run.case.id)
    if module is None or not run.finished:
        return {}
    try:
        return dict(module.metrics(run))
    except Exception as error:  # the run is done and its results are whole, whatever the module makes of them
        warnings.warn(f"the metrics of {run.case.id} do not apply to this run: {error}", stacklevel=2)
        return {}
