"""Data models of plots: columns of the history against time or each other, with measured curves."""

from collections.abc import Iterator
from typing import Annotated

from pydantic import BeforeValidator, Field

from pellucid.case.measured import CurveError, MeasuredCurve
from pellucid.case.probe import unit_of, unknown_column
from pellucid.findings import Finding, Path
from pellucid.model import Model, check, name_parameter, one_or_several, parameter
from pellucid.parts.part import Part, Parts
from pellucid.units import UnitError, to_si

Names = Annotated[tuple[str, ...], BeforeValidator(one_or_several), Field(min_length=1)]


def unit_problems(unit: str, wanted: str | None, path: Path) -> Iterator[Finding]:
    """Yield a finding at `path` if the unit `unit` of a user cannot be converted to the SI unit `wanted` of the quantity."""
    if not unit or wanted is None:
        return
    try:
        to_si(f"1 {unit}", wanted)
    except UnitError as error:
        yield Finding(path, str(error))


RESERVED = "where_it_stopped", "energies", "momentum", "probes", "conditions", "profiles_of_points"
"""Names of figures that every report may have; names that start with "bodies" are also reserved."""


class Figure(Part):
    """A figure of the report, with a unique name."""

    name: str = name_parameter("name of the figure")
    title: str = parameter("", "caption in the report", "")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding if the name is already used or reserved.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        taken = self.name in RESERVED or self.name.startswith("bodies")
        if taken or sum(other.name == self.name for other in parts.of(Figure)) > 1:
            why = "this name is reserved for a figure of the report" if taken else "another figure has this name"
            yield Finding((*path, "name"), why, "Choose another name.")


class Panel(Model):
    """Axes of a plot: columns of the history against time or another column, and measured curves from files."""

    x: str = parameter("", "column of the history on the x axis", "time")
    y: Names = parameter("", "columns of the history on the y axis: probes, energies or momenta, all with the same unit")
    x_unit: str = parameter("", "unit of the x axis, such as ms (default: unit of the history)", "")
    y_unit: str = parameter("", "unit of the y axis (default: unit of the history)", "")
    x_label: str = parameter("", "label of the x axis (default: name and unit of the column)", "", max_length=60)
    y_label: str = parameter("", "label of the y axis (default: name and unit of the column)", "", max_length=60)
    y_limits: tuple[float, float] | None = parameter(
        "", "limits of the y axis in this unit (default: range of the values)", None
    )
    measured: tuple[MeasuredCurve, ...] = parameter("", "measured curves from files", ())
    difference: bool = parameter("", "True: draw the difference to the first measured curve below", False)

    @check
    def _is_complete(self) -> None:
        if self.y_limits is not None and self.y_limits[0] >= self.y_limits[1]:
            raise ValueError("the first value of `y_limits` must be less than the second")
        if self.difference and not self.measured:
            raise ValueError("`difference` requires a `measured` curve; add one, or remove `difference`")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for unknown columns, columns with different units, units of another dimension, and files without
        the curve.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        wrong = list(unknown_column(self.x, (*path, "x"), parts))
        for name in self.y:
            wrong += unknown_column(name, (*path, "y"), parts)
        yield from wrong
        x, units = unit_of(self.x, parts), {name: unit_of(name, parts) for name in self.y}
        if wrong or x is None or None in units.values():
            return
        if len(set(units.values())) > 1:
            told = ", ".join(f"{name} in {unit or '1'}" for name, unit in units.items())
            text = f"the columns of one y axis must have the same unit: {told}"
            yield Finding((*path, "y"), text, "Use one panel in `beside` for each unit.")
            return
        yield from unit_problems(self.x_unit, x, (*path, "x_unit"))
        yield from unit_problems(self.y_unit, units[self.y[0]], (*path, "y_unit"))
        for number, curve in enumerate(self.measured):
            try:
                curve.read(x, units[self.y[0]] or "")
            except CurveError as error:
                yield Finding((*path, "measured", number), str(error))


class Plot(Panel, Figure):
    """A figure of the report, `figures/NAME.png`: columns of the history against time or another column."""

    beside: tuple[Panel, ...] = parameter("", "additional panels of the figure", ())

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield the findings of the name (`Figure.problems`) and of each panel (`Panel.problems`)."""
        yield from Figure.problems(self, path, parts)
        yield from Panel.problems(self, path, parts)
        for number, panel in enumerate(self.beside):
            yield from panel.problems((*path, "beside", number), parts)
