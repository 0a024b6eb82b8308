"""Probes: a field of a body reduced to one number."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.state import FIELDS

if TYPE_CHECKING:
    from pellucid.case import Probe

COMPONENTS = {3: ("x", "y", "z"), 6: ("xx", "yy", "zz", "yz", "xz", "xy")}

REDUCTIONS: dict[str, Callable[[np.ndarray], Any]] = {"mean": np.mean, "max": np.max, "min": np.min, "sum": np.sum}


def evaluate(probes: "Sequence[Probe]", bodies: Sequence[Any]) -> list[float]:
    """The value of each probe now; a field that several probes want is fetched once.

    `bodies` have a `name` and a `frame()`. Points count in their original order, so that the sums do not depend on how
    they are sorted.
    """
    frames: dict[str, Mapping[str, np.ndarray]] = {}
    values = []
    for probe in probes:
        if probe.body not in frames:
            frames[probe.body] = next(body for body in bodies if body.name == probe.body).frame()
        values.append(reduce(probe, frames[probe.body]))
    return values


def reduce(probe: "Probe", frame: Mapping[str, np.ndarray]) -> float:
    """The value of a probe in a frame.

    Without a component a vector counts with its length and a stress with von Mises' equivalent. "nearest" takes the
    point that is nearest to the place at the moment, not one that is followed.
    """
    values = scalar(frame[probe.quantity], probe.component)
    if probe.reduce == "nearest":
        distance = ((frame["position"] - np.asarray(probe.at)) ** 2).sum(axis=1)
        return float(values[np.argmin(distance)])
    return float(REDUCTIONS[probe.reduce](values))


def scalar(values: np.ndarray, component: str | None = None) -> np.ndarray:
    """One number a point, shape (n,), from a field of shape (n,), (n, 3) or (n, 6)."""
    if values.ndim == 1:
        return values
    if component is not None:
        return np.ascontiguousarray(values[:, COMPONENTS[values.shape[1]].index(component)])
    if values.shape[1] == 3:
        return np.asarray(np.linalg.norm(values, axis=1))
    xx, yy, zz, yz, xz, xy = values.T
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (yz**2 + xz**2 + xy**2))


def units(probes: "Sequence[Probe]") -> dict[str, str]:
    """The unit of each probe's column."""
    return {probe.name: FIELDS[probe.quantity].unit for probe in probes}
