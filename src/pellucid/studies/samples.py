"""Create the members of a sweep as rows of settings: every combination of values, a Latin hypercube sample, or a given
list."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

from pellucid.errors import UsageError
from pellucid.studies.ranges import Range, range_of

if TYPE_CHECKING:
    from pellucid.case import Case

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
