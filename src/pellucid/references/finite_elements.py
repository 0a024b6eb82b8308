"""Reference curves of gallery cases computed by our own finite elements, stored as tables that the scripts in `validation/`
write."""

import csv
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pellucid.references import Array, Case


def read(table: str) -> dict[str, Array]:
    """Return the columns of a table, including `time` [s], by name; table: "net_impact" or "membrane_expansion", for
    example."""
    text = files("pellucid.references").joinpath(f"{table}.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def largest_deviation(times: ArrayLike, values: ArrayLike, reference_times: Array, reference: Array) -> float:
    """Return the largest deviation of a curve (times, values) from a reference curve, divided by the largest change of the
    reference from its start (no unit).

    Both curves have the same units. They are compared at the times of the reference, up to the end of the curve.
    """
    times = np.asarray(times, dtype=float)
    reached = reference_times <= times[-1] * (1.0 + 1e-9)
    apart = np.interp(reference_times[reached], times, np.asarray(values, dtype=float)) - reference[reached]
    return float(np.abs(apart).max() / np.abs(reference - reference[0]).max())


def same_problem(case: Case, other: Case) -> bool:
    """Return True if two cases describe the same problem for the same bodies, so that a reference for one is valid for the
    other.

    Grid, points, step, length and output may differ, and so may the kind of a membrane: points or elements.
    """
    if len(case.body) != len(other.body) or case.gravity != other.gravity:
        return False

    def stated(body: Any) -> tuple[Any, ...]:
        return body.kind.partition("-")[0], body.field, body.material, body.velocity, getattr(body, "thickness", None)

    return all(
        stated(one) == stated(two) and np.allclose(one.bounds(), two.bounds(), rtol=0.0, atol=1e-9)
        for one, two in zip(case.body, other.body, strict=True)
    )
