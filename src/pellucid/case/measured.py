"""Measured curves: two columns of a CSV file, with their units in it."""

import csv
import re
from pathlib import Path

import numpy as np

from pellucid.model import InputFile, Model, parameter
from pellucid.units import UnitError, to_si

NAMED = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*")
"""A name of a column, perhaps with its unit: "force [mN]"."""
EXAMPLE = '"time [ms], force [mN]" in the first row, or a second row "#ms, mN"'


class CurveError(ValueError):
    """A file that has no such curve. Its text names the file, and line and column where they are known."""


class MeasuredCurve(Model):
    """Two columns of a CSV file with a row of names. The unit of each stands in brackets behind its name, or in a second row
    that begins with #, as in the history of a run; "1" is that of a pure number."""

    path: InputFile = parameter("", "the CSV file")
    x: str = parameter("", "name of the column along the abscissa; without it the first", "")
    y: str = parameter("", "name of the column with the values; without it the second", "")
    deviation: str = parameter("", "name of a column with the standard deviation of the values", "")
    label: str = parameter("", "what the curve is called in the legend; without it the name of the file", "")

    @property
    def title(self) -> str:
        """What it is called."""
        return self.label or Path(self.path).stem.replace("_", " ")

    def read(self, x_unit: str, y_unit: str) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Abscissae, values and their deviations, where there are any, in these SI units, each of shape (n,); the abscissae
        ascend. Raises CurveError."""
        table = read_table(Path(self.path))
        names = list(table)
        if len(names) < 2:
            raise CurveError(f"{self.path} has one column alone; a curve has two")
        x, y = self._column(table, self.x or names[0], x_unit), self._column(table, self.y or names[1], y_unit)
        spread = self._column(table, self.deviation, y_unit) if self.deviation else None
        order = np.argsort(x, kind="stable")
        return x[order], y[order], None if spread is None else spread[order]

    def _column(self, table: "dict[str, tuple[str, np.ndarray]]", name: str, wanted: str) -> np.ndarray:
        if name not in table:
            raise CurveError(f"{self.path} has no column {name}; it has {', '.join(table)}")
        unit, values = table[name]
        if not unit:
            raise CurveError(f"{self.path} names no unit of the column {name}: write {EXAMPLE}; a pure number has 1")
        try:
            return values if unit == "1" and not wanted else values * to_si(f"1 {unit}", wanted)
        except UnitError as error:
            raise CurveError(f"{self.path}, column {name}: {error}") from None


def read_table(path: Path) -> "dict[str, tuple[str, np.ndarray]]":
    """The columns of a CSV file by name, each with its unit, "" where none is said, and its numbers, shape (n,).

    Raises CurveError for a file that is not there or holds something else.
    """
    try:
        lines = [(number, row) for number, row in enumerate(csv.reader(path.read_text("utf-8-sig").splitlines()), 1) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise CurveError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from None
    if not lines:
        raise CurveError(f"{path} is empty")
    heads = [NAMED.fullmatch(cell) for cell in lines[0][1]]
    names = [head["name"] if head else cell.strip() for head, cell in zip(heads, lines[0][1], strict=True)]
    units = [head["unit"] or "" if head else "" for head in heads]
    if repeated := sorted({name for name in names if names.count(name) > 1}):
        raise CurveError(f"{path} has two columns {repeated[0]}")
    rows = lines[1:]
    if rows and rows[0][1][0].lstrip().startswith("#"):
        said = [cell.strip().lstrip("#").strip() for cell in rows[0][1]]
        units = [unit or other for unit, other in zip(units, [*said, *[""] * len(units)], strict=False)]
        rows = rows[1:]
    if not rows:
        raise CurveError(f"{path} has no row of numbers")
    return {name: (unit, _numbers(path, rows, k, name)) for k, (name, unit) in enumerate(zip(names, units, strict=True))}


def _numbers(path: Path, rows: list[tuple[int, list[str]]], column: int, name: str) -> np.ndarray:
    values = []
    for line, row in rows:
        try:
            values.append(float(row[column]))
        except (IndexError, ValueError):
            told = f'"{row[column].strip()}"' if column < len(row) else "nothing"
            raise CurveError(f"{path}, line {line}, column {name}: {told} is no number") from None
        if not np.isfinite(values[-1]):
            raise CurveError(f"{path}, line {line}, column {name}: {row[column].strip()} is not finite")
    return np.array(values)
