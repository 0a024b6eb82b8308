"""Measured curves: two columns of a CSV file that also contains their units."""

import csv
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pellucid.errors import UsageError
from pellucid.model import InputFile, Model, parameter
from pellucid.units import UnitError, to_si

NAMED = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*")
"""Pattern of a column name, optionally with a unit: "force [mN]"."""
EXAMPLE = 'such as "time [ms], force [mN]", or a second row such as "ms, mN"; use 1 for a pure number'


class CurveError(UsageError):
    """Error in the file of a measured curve. The message gives the file, and the line and column if they are known."""


class Table(NamedTuple):
    """Columns of a CSV file that `MeasuredCurve` reads, by name, with their units."""

    path: Path
    units: dict[str, str]
    """Unit of each column as written in the file, "" if the file has none."""
    values: dict[str, np.ndarray]
    """Columns by name, shape (n,) each."""
    lines: list[int]
    """Line number in the file of each row of the table."""

    def column(self, name: str, unit: str) -> np.ndarray:
        """Return the column `name` converted to the SI unit `unit` ("" for dimensionless numbers), shape (n,). Raises
        CurveError if the column does not exist or has another dimension."""
        if name not in self.values:
            raise CurveError(f"{self.path}:1: no column is named {name}; available: {', '.join(self.values)}")
        said, wanted = self.units[name].strip("-"), "" if unit == "1" else unit
        if said in ("", "1") and not wanted:
            return self.values[name]
        if not said:
            raise CurveError(f"{self.path}:1: the column {name} has no unit; add one, {EXAMPLE}")
        try:
            return self.values[name] * to_si(f"1 {said}", wanted)
        except UnitError as error:
            raise CurveError(f"{self.path}: the unit of the column {name}: {error}") from None


class MeasuredCurve(Model):
    """Two columns of a CSV file. A row of names comes first, after optional comment lines that start with #. The units are
    in brackets behind the names, or in a second row, with or without # before it, as in the history of a run; "1" is the
    unit of a dimensionless number."""

    path: InputFile = parameter("", "CSV file")
    x: str = parameter("", "name of the column of x values (default: first column)", "")
    y: str = parameter("", "name of the column of y values (default: second column)", "")
    deviation: str = parameter("", "name of the column of standard deviations of the values", "")
    label: str = parameter("", "name of the curve in the legend (default: name of the file)", "")
    line: bool = parameter("", "True: draw a line (for theory) instead of points", False)

    @property
    def title(self) -> str:
        """Name of the curve in the legend of a plot: `label`, otherwise the name of the file."""
        return self.label or Path(self.path).stem.replace("_", " ")

    def read(self, x_unit: str, y_unit: str) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return x values in ascending order, y values, and standard deviations (or None) in the SI units `x_unit` and
        `y_unit`, each of shape (n,). Raises CurveError."""
        table = read_table(Path(self.path))
        names = list(table.values)
        if len(names) < 2:
            raise CurveError(f"{self.path}:1: the file has only one column, {names[0]}; a curve requires two")
        x, y = table.column(self.x or names[0], x_unit), table.column(self.y or names[1], y_unit)
        spread = table.column(self.deviation, y_unit) if self.deviation else None
        order = np.argsort(x, kind="stable")
        return x[order], y[order], None if spread is None else spread[order]


def read_table(path: Path) -> Table:
    """Read the columns of a CSV file. Raises CurveError for a missing or invalid file."""
    try:
        rows = list(enumerate(csv.reader(path.read_text("utf-8-sig").splitlines()), 1))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise CurveError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from None
    lines = [(number, [cell.strip() for cell in row]) for number, row in rows if any(map(str.strip, row))]
    if not lines:
        raise CurveError(f"{path} is empty; write a row of names with units, {EXAMPLE}")
    remarks = next((n for n, (_, row) in enumerate(lines) if not row[0].startswith("#")), 0)
    if _number(lines[remarks][1][0]) is None:  # otherwise the row of names itself starts with a comment sign
        del lines[:remarks]
    if len(lines[0][1]) == 1 and (other := next((mark for mark in ";\t" if mark in lines[0][1][0]), "")):
        name = {";": "semicolons", "\t": "tabs"}[other]
        raise CurveError(
            f"{path}:{lines[0][0]}: columns are separated by {name}; separate them by commas, and write 0.5 instead of 0,5"
        )
    heads = [NAMED.fullmatch(cell) for cell in lines[0][1]]
    names = [head["name"] if head else cell for head, cell in zip(heads, lines[0][1], strict=True)]
    if repeated := sorted({name for name in names if names.count(name) > 1}):
        raise CurveError(f"{path}:{lines[0][0]}: two columns are named {repeated[0]}")
    units = [head["unit"] or "" if head else "" for head in heads]
    del lines[0]
    if lines and _number(lines[0][1][0]) is None:
        said = [cell.lstrip("#").strip() for cell in lines.pop(0)[1]]
        units = [unit or other for unit, other in zip(units, [*said, *[""] * len(units)], strict=False)]
    if not lines:
        raise CurveError(f"{path} contains no row of numbers; add one below the names")
    values = {name: _numbers(path, lines, k, names) for k, name in enumerate(names)}
    return Table(path, dict(zip(names, units, strict=True)), values, [number for number, _ in lines])


def _numbers(path: Path, lines: list[tuple[int, list[str]]], column: int, names: list[str]) -> np.ndarray:
    values = []
    for line, row in lines:
        if len(row) != len(names):
            raise CurveError(
                f"{path}:{line}: the row has {len(row)} cells, but there are {len(names)} columns: {', '.join(names)}"
            )
        found = _number(row[column])
        if found is None:
            raise CurveError(f'{path}:{line}: {names[column]} = "{row[column]}" is not a finite number')
        values.append(found)
    return np.array(values)


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if np.isfinite(number) else None
