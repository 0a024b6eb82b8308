"""Read the variations of a study as given by its user: KEY=V1,V2, KEY=LOW:HIGH, or a table of values."""

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pellucid.case.settings import find, parse_value
from pellucid.errors import CaseError, UsageError

if TYPE_CHECKING:
    from pellucid.case import Case


DECADES = 10.0
"""Ratio of the ends of a positive range from which on the range is sampled on a logarithmic scale."""


class Range(NamedTuple):
    """Range of a parameter of a study from `low` to `high`, in SI units. A position in the range is a `share`: 0 at the
    lower and 1 at the upper end, on a logarithmic scale if the range spans a decade."""

    low: float
    high: float

    @property
    def is_logarithmic(self) -> bool:
        """True if the range is positive and spans a decade or more."""
        return self.low > 0.0 and self.high >= DECADES * self.low

    def at(self, share: float) -> float:
        """Return the value at a share of the range (0 to 1), rounded to seven digits so that equal values give equal runs."""
        value = self.beyond(share)
        size = max(abs(value), 1e-7 * (self.high - self.low))
        return min(max(round(value, 6 - math.floor(math.log10(size))), self.low), self.high)

    def beyond(self, share: float) -> float:
        """Return the value at a share that may be below 0 or above 1; unlike the result of `at`, this value is not rounded."""
        if self.is_logarithmic:
            return math.exp(math.log(self.low) + share * math.log(self.high / self.low))
        return self.low + share * (self.high - self.low)

    def share(self, value: float) -> float:
        """Return the share of a value: 0 at the lower and 1 at the upper end of the range."""
        if self.is_logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


def split_setting(option: str, text: str, example: str) -> tuple[str, str]:
    """Split a text KEY=VALUE of a command-line option into key and value. Raises UsageError, which shows `example`, for another
    form."""
    key, equals, value = text.partition("=")
    if not equals or not key.strip() or not value.strip():
        raise UsageError(f"{option} {text}: must have the form {example}")
    return key.strip(), value.strip()


def read_values(texts: Sequence[str]) -> dict[str, Any]:
    """Return the values by key from `--over`: a list, or the two ends (low, high) of a range as written. Raises UsageError
    for an invalid text."""
    found: dict[str, Any] = {}
    for text in texts:
        key, values = split_setting("--over", text, "KEY=V1,V2,... or KEY=LOW:HIGH, for example grid.cell=0.05,0.025")
        if key in found:
            raise UsageError(f"--over {text}: {key} is given twice.\n    Write all its values in one --over.")
        together = parse_value(f"[{values}]")
        if isinstance(together, list):
            found[key] = together
        elif ":" in values and "," not in values:
            found[key] = read_ends("--over", text, values)
        else:
            found[key] = [parse_value(item.strip()) for item in values.split(",")]
    return found


def read_ends(option: str, text: str, values: str) -> tuple[Any, Any]:
    """Return both ends of a range written as LOW:HIGH (`values`). option, text: the command-line option and its whole text, for
    the message of the UsageError for another form."""
    low, colon, high = values.partition(":")
    if not colon or not low.strip() or not high.strip() or ":" in high:
        example = "body.tissue.material.young_modulus=1kPa:50kPa"
        raise UsageError(f"{option} {text}: must have the form KEY=LOW:HIGH, for example {example}")
    return parse_value(low.strip()), parse_value(high.strip())


def range_of(case: "Case", key: str, low: Any, high: Any, option: str = "--over") -> Range:
    """Return the range of the number at a dotted key of the case, in SI units.

    low, high: ends as the user wrote them. option: command-line option, for messages. Raises UsageError if the ends are not
    numbers or not in ascending order.
    """
    ends = [at_key(case.with_settings({key: end}), key) for end in (low, high)]
    if not all(isinstance(end, (int, float)) and not isinstance(end, bool) for end in ends):
        text = f"{option} {key}={low}:{high}: {key} is not a number, so it cannot have a range"
        raise UsageError(f"{text}.\n    List its values: {key}=V1,V2")
    if not ends[0] < ends[1]:
        raise UsageError(f"{option} {key}={low}:{high}: the lower end must be less than the upper end")
    return Range(float(ends[0]), float(ends[1]))


def at_key(case: "Case", key: str) -> Any:
    """Return the value of a case at a dotted key, in SI units; None if there is none."""
    here: Any = case.to_data()
    try:
        for part in find(here, key):
            here = here[part]
    except (KeyError, TypeError):
        return None
    return here


def unit_at(case: "Case", key: str) -> str:
    """Return the SI unit of the value at a dotted key of a case; "" for pure numbers, texts and tables."""
    here: Any = case
    unit = ""
    for part in find(case.to_data(), key):
        if isinstance(here, (list, tuple)):
            here = here[part] if isinstance(part, int) and part < len(here) else None
            continue
        fields = getattr(type(here), "model_fields", {})
        name = next((name for name, field in fields.items() if part in (name, field.alias)), None)
        if name is None:
            return ""
        extra = fields[name].json_schema_extra
        unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
        here = getattr(here, name)
    return unit


def with_units(names: Sequence[str], units: Mapping[str, str]) -> list[str]:
    """Return column names with their units, such as "grid.cell [m]". units: SI units by column name."""
    return [f"{name} [{unit}]" if (unit := units.get(name, "")) and unit != "1" else name for name in names]


def read_rows(path: Path) -> list[dict[str, Any]]:
    """Read settings from a CSV file with a row of keys and one row per member. Raises UsageError with file and line."""
    with readable(path, "--from"), path.open(newline="", encoding="utf-8-sig") as file:
        lines = [(number, row) for number, row in enumerate(csv.reader(file), 1) if any(cell.strip() for cell in row)]
    if len(lines) < 2:
        raise UsageError(f"--from {path}: must contain a row of keys, such as grid.cell, and a row of values for each member")
    keys = [key.strip() for key in lines[0][1]]
    if "" in keys or len(set(keys)) < len(keys):
        raise UsageError(f"{path}:{lines[0][0]}: a key is empty or occurs twice in the first row: {', '.join(keys)}")
    for number, row in lines[1:]:
        if len(row) != len(keys) or not all(cell.strip() for cell in row):
            raise UsageError(
                f"{path}:{number}: the row has {sum(map(bool, row))} values for {len(keys)} keys; add the missing values"
            )
    return [dict(zip(keys, (parse_value(cell.strip()) for cell in row), strict=True)) for _, row in lines[1:]]


@contextmanager
def readable(path: Path, option: str) -> Iterator[None]:
    """Turn errors of reading a CSV file in the block into a UsageError. option: command-line option that names the file."""
    try:
        yield
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UsageError(f"{option} {path}: the file cannot be read as CSV: {reason}") from None


def named(settings: Mapping[str, Any]) -> str:
    """Return settings (values by key) as one line of text for messages."""
    return ", ".join(f"{key} = {value}" for key, value in settings.items())


def all_checked(case: "Case", rows: Sequence[Mapping[str, Any]]) -> "list[Case]":
    """Return the case with each row of settings (values by dotted key). Raises CaseError with all problems of all rows."""
    cases, problems = [], {}
    for row in rows:
        try:
            cases.append(case.with_settings(row))
        except CaseError as error:
            problems.update({(problem.key, problem.setting, problem.text): problem for problem in error.problems})
    if problems:
        raise CaseError(list(problems.values()), f"the {len(rows)} members; none was run")
    return cases


MOST = 100_000
"""Largest number of members of one sweep."""


def rows_of(
    case: "Case",
    over: Mapping[str, Any],
    samples: int | None = None,
    listed: Sequence[Mapping[str, Any]] = (),
    seed: int = 0,
) -> list[dict[str, Any]]:
    """Return the settings (values by dotted key) of each member of a sweep.

    `over`: a list of values or the ends (low, high) of a range, by key. Without `samples`, all values are combined with
    each other; otherwise this number of members is drawn as a Latin hypercube sample with the given seed. Each row of
    `listed` is combined with each of these settings. Raises UsageError, and CaseError for ends that are invalid for a
    field.
    """
    if not over and not listed:
        raise UsageError("No key varies.\n    Add --over KEY=V1,V2,... or --from TABLE.csv.")
    if both := set(over) & {key for row in listed for key in row}:
        raise UsageError(f"{min(both)} varies by --over and by --from.\n    Remove one of them.")
    choices = {key: range_of(case, key, *v) if isinstance(v, tuple) else list(v) for key, v in over.items()}
    if empty := [key for key, values in choices.items() if not isinstance(values, Range) and not values]:
        raise UsageError(f"{empty[0]} has no values")
    ranges = [key for key, values in choices.items() if isinstance(values, Range)]
    if samples is None and ranges:
        text = f"{ranges[0]} has a range, but the number of samples is missing"
        raise UsageError(f"{text}.\n    Add --samples N, or list its values.")
    if samples is not None and samples < 1:
        raise UsageError(f"--samples {samples}: must be at least 1")
    if samples is not None and not over:
        raise UsageError("--samples requires a range to draw from.\n    Add --over KEY=LOW:HIGH.")
    drawn = _combined(choices) if samples is None else _hypercube(choices, samples, seed)
    rows = [{**one, **other} for one in (listed or [{}]) for other in drawn]
    if len(rows) > MOST:
        raise UsageError(
            f"{len(rows)} members exceed the limit of {MOST}.\n    Use fewer values, or draw a sample with --samples N."
        )
    return rows


def _combined(choices: Mapping[str, Any]) -> list[dict[str, Any]]:
    count = 1
    for values in choices.values():
        count *= len(values)
    if count > MOST:
        raise UsageError(
            f"{count} members exceed the limit of {MOST}.\n    Use fewer values, or draw a sample with --samples N."
        )
    return [dict(zip(choices, values, strict=True)) for values in product(*choices.values())]


def _hypercube(choices: Mapping[str, Any], samples: int, seed: int) -> list[dict[str, Any]]:
    from scipy.stats import qmc

    shares = qmc.LatinHypercube(len(choices), rng=seed).random(samples)
    return [{key: _taken(values, share) for (key, values), share in zip(choices.items(), row, strict=True)} for row in shares]


def _taken(values: Any, share: float) -> Any:
    return values.at(share) if isinstance(values, Range) else values[int(share * len(values))]
