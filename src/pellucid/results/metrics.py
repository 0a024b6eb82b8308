"""Metrics: computed values of a run, their reference values, errors and tolerances."""

import math
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Metric:
    """A computed value of a run (`value`) with its `reference`, the `error` and the `tolerance` of the error; `meaning`
    describes the comparison for the report."""

    value: float
    reference: float
    error: float
    """Error of the value relative to the reference, as defined in `meaning`; not negative."""
    tolerance: float
    unit: str = ""
    """Unit of value and reference; empty for a pure number."""
    meaning: str = ""

    @property
    def passed(self) -> bool:
        """True if the error is within the tolerance; False if it is not a number."""
        return bool(self.error <= self.tolerance)

    def to_data(self) -> dict[str, Any]:
        """Return the value, reference, error and tolerance of the metric and the flag `pass` by name, for `summary.json`;
        numbers that are not finite become null."""
        return {
            "value": finite(self.value),
            "reference": finite(self.reference),
            "error": finite(self.error),
            "tolerance": finite(self.tolerance),
            "pass": self.passed,
        }


def finite(number: float) -> float | None:
    """Return the number; None if it is NaN or infinite, because JSON has no such numbers."""
    return float(number) if math.isfinite(number) else None
