"""Metrics: what a run found beside what it should have found, and how far apart the two may be."""

import math
from dataclasses import dataclass
from typing import Any


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
        """True if the error is within the tolerance; False if it is not a number."""
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
