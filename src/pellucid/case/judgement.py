"""Checks of a case: comparison of a number of the history with a reference, or of a column with a measured curve."""

from collections.abc import Iterator
from typing import ClassVar, Literal

from pellucid.case.measured import CurveError, MeasuredCurve
from pellucid.case.probe import beyond_end, unit_of, unknown_column
from pellucid.findings import Finding, Path
from pellucid.model import Model, check, name_parameter, parameter
from pellucid.parts.part import Part, Parts
from pellucid.units import UnitError, to_si

Quantity = float | str
"""A number in SI units, or a text with its unit. The unit of the column is known when the whole case has been read."""


def in_si(value: Quantity, unit: str) -> float:
    """Convert a value of a case to a number in the SI unit `unit`; a number is already in SI units, a text contains its unit.
    Raises UnitError."""
    return to_si(value, unit) if isinstance(value, str) else value


class Passing(Model):
    """Event at which a column of the history first reaches a value, from either side. It allows checks at such an event
    instead of at a given time."""

    column: str = parameter("", "name of a probe or of another column of the history")
    reaches: Quantity = parameter("", "value, in SI units or as text with a unit")


class Check(Part):
    """Metric of a run, for the report and for `pellucid verify` and `pellucid converge`."""

    unique_name: ClassVar[bool] = True

    name: str = name_parameter("name of the metric")
    column: str = parameter("", "name of a probe or of another column of the history")
    take: Literal["last", "largest", "smallest", "mean", "largest-size", "time-of-largest", "time-of-smallest"] = parameter(
        "",
        "reduction of the column to one number; largest-size: largest absolute value; time-of-largest, time-of-smallest: "
        "first time of the largest or smallest value",
        "last",
    )
    at: float | None = parameter("s", "time at which the column is read (instead of `take`)", None, ge=0)
    when: Passing | None = parameter(
        "", "event at which the column is read: another column reaches a value (instead of `at` or `take`)", None
    )
    reference: Quantity | None = parameter("", "reference value, in SI units or as text with a unit", None)
    curve: MeasuredCurve | None = parameter(
        "", "reference values against time; the error is the root mean square of the differences at its points", None
    )
    tolerance: Quantity | None = parameter("", "largest allowed error, in SI units or as text with a unit", None)
    relative_tolerance: float | None = parameter(
        "", "largest allowed error divided by the reference, or by the largest absolute value of the curve", None, gt=0
    )
    source: str = parameter("", "source of the reference")
    meaning: str = parameter("", "description of the comparison, for the report", "")

    @check
    def _is_complete(self) -> None:
        if (self.reference is None) == (self.curve is None):
            raise ValueError("a check requires either a `reference` or a `curve`; set one of the two")
        if (self.tolerance is None) == (self.relative_tolerance is None):
            raise ValueError("a check requires either a `tolerance` or a `relative_tolerance`; set one of the two")
        if self.at is not None and self.when is not None:
            raise ValueError("`at` and `when` both set the time at which the column is read; remove one of the two")
        if (self.at is not None or self.when is not None) and self.take != "last":
            raise ValueError(
                f"`{'at' if self.when is None else 'when'}` sets one time at which the column is read; remove `take`"
            )
        if self.curve is not None and (self.at is not None or self.when is not None or self.take != "last"):
            raise ValueError("a `curve` is compared at all its points; remove `at`, `when` and `take`")
        if self.reference == 0 and self.relative_tolerance is not None:
            raise ValueError("`relative_tolerance` has no meaning for a `reference` of 0; set `tolerance` instead")

    @property
    def takes_time(self) -> bool:
        """True if the compared value is a time."""
        return self.take.startswith("time-of")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for an unknown column, a value with a unit of another dimension, a time after the end of the run,
        and a file without the curve.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        yield from unknown_column(self.column, (*path, "column"), parts)
        if self.at is not None:
            yield from beyond_end(self.at, (*path, "at"), parts)
        if self.when is not None:
            yield from self._of_passing(self.when, (*path, "when"), parts)
        unit = "s" if self.takes_time else unit_of(self.column, parts)
        if unit is None:
            return
        for key in ("reference", "tolerance"):
            try:
                value = in_si(getattr(self, key) or 0.0, unit)
            except UnitError as error:
                yield Finding((*path, key), str(error))
                continue
            if key == "tolerance" and self.tolerance is not None and value <= 0.0:
                yield Finding((*path, key), f"must be greater than 0, but is {value:g}")
        if self.curve is not None:
            try:
                times, _, _ = self.curve.read("s", unit)
            except CurveError as error:
                yield Finding((*path, "curve"), str(error))
                return
            yield from beyond_end(float(times[0]), (*path, "curve"), parts)

    @staticmethod
    def _of_passing(passing: Passing, path: Path, parts: Parts) -> Iterator[Finding]:
        yield from unknown_column(passing.column, (*path, "column"), parts)
        if (unit := unit_of(passing.column, parts)) is not None:
            try:
                in_si(passing.reaches, unit)
            except UnitError as error:
                yield Finding((*path, "reaches"), str(error))
