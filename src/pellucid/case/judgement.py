"""Checks of a case: a number of the history, or its distance from a measured curve, beside a reference."""

from collections.abc import Iterator
from typing import ClassVar, Literal

from pellucid.case.columns import beyond_end, unit_of, unknown_column
from pellucid.case.measured import CurveError, MeasuredCurve
from pellucid.findings import Finding, Path
from pellucid.model import Model, check, name_parameter, parameter
from pellucid.parts.part import Part, Parts
from pellucid.units import UnitError, to_si

Quantity = float | str
"""A number in SI units, or a text with its unit: that of the column is known when all of the case is."""


def in_si(value: Quantity, unit: str) -> float:
    """The number in an SI unit. Raises UnitError."""
    return to_si(value, unit) if isinstance(value, str) else value


class Passing(Model):
    """The instant at which a column first has a value, coming from either side: for curves along another quantity than time."""

    column: str = parameter("", "probe, or another column of the history")
    reaches: Quantity = parameter("", "the value, in SI units or a text with its unit")


class Check(Part):
    """A metric of the run: it stands in the report, and `pellucid verify` and `converge` take it."""

    unique_name: ClassVar[bool] = True

    name: str = name_parameter("name of the metric")
    column: str = parameter("", "probe, or another column of the history")
    take: Literal["last", "largest", "smallest", "mean", "largest-size", "time-of-largest", "time-of-smallest"] = parameter(
        "",
        "how the column becomes one number; the largest size is that of either sign, a time the first at which the column "
        "is so large or small",
        "last",
    )
    at: float | None = parameter("s", "time at which the column is read, instead of `take`", None, ge=0)
    when: Passing | None = parameter(
        "", "instead of `at` or `take`: the column is read when another one comes to a value", None
    )
    reference: Quantity | None = parameter("", "the right value, in SI units or a text with its unit", None)
    curve: MeasuredCurve | None = parameter(
        "", "the right values against time: the error is the root mean square of the differences at its points", None
    )
    tolerance: Quantity | None = parameter("", "largest error, in SI units or a text with its unit", None)
    relative_tolerance: float | None = parameter(
        "", "largest error as a part of the reference, or of the curve's largest size", None, gt=0
    )
    source: str = parameter("", "where the reference comes from")
    meaning: str = parameter("", "what is compared, for the reader of the report", "")

    @check
    def _is_complete(self) -> None:
        if (self.reference is None) == (self.curve is None):
            raise ValueError("a check needs a `reference` or a `curve`, and not both")
        if (self.tolerance is None) == (self.relative_tolerance is None):
            raise ValueError("a check needs a `tolerance` or a `relative_tolerance`, and not both")
        if self.at is not None and self.when is not None:
            raise ValueError("`at` and `when` both say at which time the column is read: give one of the two")
        if (self.at is not None or self.when is not None) and self.take != "last":
            raise ValueError(f"`{'at' if self.when is None else 'when'}` reads the column at one time: leave `take` out")
        if self.curve is not None and (self.at is not None or self.when is not None or self.take != "last"):
            raise ValueError("a `curve` is compared at all its points: leave `at`, `when` and `take` out")
        if self.reference == 0 and self.relative_tolerance is not None:
            raise ValueError("no part of a `reference` of 0 is an error: give a `tolerance`")

    @property
    def takes_time(self) -> bool:
        """True if a time is compared."""
        return self.take.startswith("time-of")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Report unknown columns, quantities of another dimension, and files without such a curve."""
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
                yield Finding((*path, key), f"must be above 0, is {value:g}")
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
