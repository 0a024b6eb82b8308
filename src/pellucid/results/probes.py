"""Probes: a field of a body reduced to one number."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.state import COMPONENT_NAMES, FIELDS

if TYPE_CHECKING:
    from pellucid.case import Probe

Fetch = Callable[[str], np.ndarray]

REDUCTIONS: dict[str, Callable[[np.ndarray], Any]] = {"mean": np.mean, "max": np.max, "min": np.min, "sum": np.sum}


def evaluate(probes: "Sequence[Probe]", bodies: Sequence[Any]) -> list[float]:
    """The value of each probe now; only the arrays that are needed are fetched, each once.

    `bodies` have a `name` and a `field(name)`: points in any order that is the same in every run.
    """
    fetch = {body.name: cache(body.field) for body in bodies}
    return [reduce(probe, fetch[probe.body]) for probe in probes]


def reduce(probe: "Probe", field: Fetch) -> float:
    """The value of a probe on the fields that `field` gives by name.

    Without a component a vector counts with its length and a stress with von Mises' equivalent. "nearest" takes the
    point that is nearest to the place at the moment, not one that is followed.
    """
    values = scalar(field(probe.quantity), probe.component)
    if probe.reduce == "nearest":
        distance = ((field("position") - np.asarray(probe.at)) ** 2).sum(axis=1)
        return float(values[np.argmin(distance)])
    return float(REDUCTIONS[probe.reduce](values))


def scalar(values: np.ndarray, component: str | None = None) -> np.ndarray:
    """One number a point, shape (n,), from a field of shape (n,), (n, 3) or (n, 6)."""
    if values.ndim == 1:
        return values
    if component is not None:
        return np.ascontiguousarray(values[:, COMPONENT_NAMES[values.shape[1]].index(component)])
    if values.shape[1] == 3:
        return np.asarray(np.linalg.norm(values, axis=1))
    xx, yy, zz, yz, xz, xy = values.T
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (yz**2 + xz**2 + xy**2))


def units(probes: "Sequence[Probe]") -> dict[str, str]:
    """The unit of each probe's column."""
    return {probe.name: FIELDS[probe.quantity].unit for probe in probes}
