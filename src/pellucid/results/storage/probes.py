"""Probes: a field of a body reduced to one number, or the mean force or torque of a support or motion."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from math import nan
from typing import Any

import numpy as np

from pellucid.case.probe import TRIANGLES, Fetch, Probe
from pellucid.errors import CaseError, Problem, RunStopped
from pellucid.findings import absent
from pellucid.model import Vector
from pellucid.state import COMPONENT_NAMES, FIELDS
from pellucid.users.users_code import read_only

NOT_PERIODIC = (0.0, 0.0, 0.0)
NOTHING_TURNED: Mapping[str, np.ndarray] = {}


class ProbeReader:
    """Evaluates the probes of a case for each row of the history, for the `Recorder`. Stores the points that probes follow,
    the initial values that probes subtract, and the impulses at the previous row of the history.

    data: the state from a checkpoint, or None. periods: periods of the grid [m], see `GridCase.periods`. Functions of users
    receive fields in the order of the point numbers; functions of the package receive fields in storage order, because
    their sums need no sorting.
    """

    def __init__(self, probes: Sequence[Probe], data: Mapping[str, Any] | None = None, periods: Vector = NOT_PERIODIC) -> None:
        self._probes, self._periods = probes, periods
        kept = data or {"followed": {}, "initial": {}, "impulses": {}, "turning": {}, "time": 0.0}
        self._followed: dict[str, int] = dict(kept["followed"])  # number of the followed point, by name of the probe
        self._initial: dict[str, float] = dict(kept["initial"])  # value that is subtracted, by name of the probe
        self._impulses: dict[str, list[float]] = dict(kept["impulses"])  # impulses up to the previous row [N s]
        self._turning: dict[str, list[float]] = dict(kept["turning"])  # angular impulses up to the previous row [N m s]
        self._time: float = kept["time"]  # time of the previous row [s]

    def start(self, bodies: Sequence[Any]) -> None:
        """Store data of the initial state that probes need later: the number of the point that a probe follows, and the
        initial value that a probe subtracts."""
        fetch = _fetches(bodies)
        for probe in self._probes:
            if probe.body is None:
                continue
            field = fetch(probe)
            if probe.reduce == "point":
                self._followed[probe.name] = int(field("id")[_nearest(field, probe.at, self._periods)])
            if probe.change:
                self._initial[probe.name] = self._value(probe, field)
            elif probe.carried:
                begun = float(scalar(np.array([probe.at]), probe.component)[0])
                self._initial[probe.name] = self._value(probe, field) - begun

    def read(
        self,
        bodies: Sequence[Any],
        impulses: Mapping[str, np.ndarray],
        time: float,
        turning: Mapping[str, np.ndarray] = NOTHING_TURNED,
    ) -> list[float]:
        """Return the value of each probe at a time [s].

        impulses: total impulse of each support and motion since the start [N s], by name, shape (3,); turning: total angular
        impulse [N m s]. A reaction or torque is the mean since the previous row, zero in the first row. Each field is computed
        at most once.
        """
        fetch = _fetches(bodies)
        values = []
        for probe in self._probes:
            if probe.body is None:
                of, before = (turning, self._turning) if probe.quantity == "torque" else (impulses, self._impulses)
                values.append(self._reaction(probe, of, before, time))
            elif probe.carried and probe.at is not None and (arrays := _rigid_arrays(bodies, probe.body)) is not None:
                begun = np.array(probe.at)
                place = carried_by(arrays["start"], arrays["position"], begun)
                moved = place - begun if probe.change else place
                values.append(float(scalar(moved[None], probe.component)[0]))
            else:
                values.append(self._value(probe, fetch(probe)) - self._initial.get(probe.name, 0.0))
        self.count_from(impulses, time, turning)
        return values

    def count_from(
        self, impulses: Mapping[str, np.ndarray], time: float, turning: Mapping[str, np.ndarray] = NOTHING_TURNED
    ) -> None:
        """Start the averages of reactions and torques at `time` [s].

        impulses, turning: total impulse [N s] and total angular impulse [N m s] of each support and motion from the start
        of the run to this time, by name, shape (3,).
        """
        self._impulses = {name: list(map(float, impulse)) for name, impulse in impulses.items()}
        self._turning = {name: list(map(float, impulse)) for name, impulse in turning.items()}
        self._time = time

    def units(self) -> dict[str, str]:
        """Return the SI unit of the history column of each probe, by name of the probe; "" for a pure number."""
        return {probe.name: probe.unit for probe in self._probes}

    def to_data(self) -> dict[str, Any]:
        """Return the state of the probe reader for a checkpoint: followed points, initial values, and impulses at the
        previous row."""
        sums = {"impulses": self._impulses, "turning": self._turning}
        return {"followed": self._followed, "initial": self._initial, **sums, "time": self._time}

    def _value(self, probe: Probe, field: Fetch) -> float:
        if probe.reduce != "point":
            return reduce(probe, field, self._periods)
        here = np.flatnonzero(field("id") == self._followed[probe.name])
        return (
            float(scalar(probe.values(field), probe.component, probe.field().names)[here[0]]) if len(here) else nan
        )  # it left the grid

    def _reaction(
        self, probe: Probe, impulses: Mapping[str, np.ndarray], known: Mapping[str, list[float]], time: float
    ) -> float:
        name = probe.condition or ""
        if name not in impulses or time <= self._time:
            return 0.0
        before = np.array(known.get(name, (0.0, 0.0, 0.0)))
        force = (impulses[name] - before) / (time - self._time)
        return float(scalar(force[None, :], probe.component)[0])


def _rigid_arrays(bodies: Sequence[Any], name: str) -> Mapping[str, np.ndarray] | None:
    """Return the state arrays of the body named `name` if this body is rigid; otherwise None."""
    arrays: Mapping[str, np.ndarray] = next((getattr(body, "arrays", {}) for body in bodies if body.name == name), {})
    return arrays if {"start", "angle"} <= arrays.keys() else None


def carried_by(start: np.ndarray, now: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the position [m], shape (3,), of a material place after the rigid motion that best fits the motion of points.

    start, now: positions of the points before and after the motion [m], shape (n, 3). place: position of the material place
    before the motion [m]. The rotation is the least-squares fit (Kabsch 1976, Acta Cryst. A 32, 922).
    """
    middle, arm = start.mean(axis=0), start - start.mean(axis=0)
    left, _, right = np.linalg.svd(np.einsum("pi,pj->ij", now - now.mean(axis=0), arm))
    signs = np.array([1.0, 1.0, np.linalg.det(left) * np.linalg.det(right)])
    return np.asarray(now.mean(axis=0) + (left * signs) @ right @ (place - middle))


def check_probes(probes: Sequence[Probe], bodies: Sequence[Any], periods: Vector = NOT_PERIODIC) -> None:
    """Evaluate every probe once in the initial state, before any output is written. Raises CaseError if a probe cannot be
    evaluated. periods: periods of the grid [m]."""
    problems = []
    for probe in probes:
        reader = ProbeReader([probe], periods=periods)
        try:
            reader.start(bodies)
            reader.read(bodies, {}, 0.0)
        except RunStopped as error:
            problems.append(Problem(str(error), f"probe.{probe.name}"))
    if problems:
        raise CaseError(problems)


def _fetches(bodies: Sequence[Any]) -> Callable[[Probe], Fetch]:
    """Return a function that maps a probe to a function `fetch`; `fetch(name)` returns the field with this name of the body
    of the probe, for `reduce`. Each field is computed once for all probes that need the points in the same order."""
    named = {body.name: body for body in bodies}

    @cache
    def of(name: str, in_order: bool) -> Fetch:
        return _fields_of(named[name], named[name].field if in_order else named[name].stored_field)

    return lambda probe: of(probe.body or "", probe.runs_users_code or probe.of_surface)


def _fields_of(body: Any, field: Fetch) -> Fetch:
    """Return a function that returns a field of a body by name, read from `field`. Each field is computed once; arrays are
    read-only because they may be the body's own."""

    def fetch(name: str) -> np.ndarray:
        if name == TRIANGLES:
            return body.cells().surface()
        try:
            return read_only(field(name))
        except KeyError:
            raise ValueError(absent(f"body {body.name} has no field", name, body.field_names)) from None

    return cache(fetch)


def reduce(probe: Probe, field: Fetch, periods: Vector = NOT_PERIODIC) -> float:
    """Return the value of a probe.

    field: function that returns a field of the body by name. periods: periods of the grid [m]. Without a component, a vector is
    reduced to its length and a stress to von Mises' equivalent stress. "nearest" selects the point that is currently nearest to
    the position; the point is not followed. If all points have left the grid, counts and sums are zero and other values are
    NaN.
    """
    values = scalar(probe.values(field), probe.component, probe.field().names)
    if not len(values):
        return 0.0 if probe.reduce in ("count", "sum") else nan
    if probe.reduce == "nearest":
        return float(values[_nearest(field, probe.at, periods)])
    if probe.reduce == "count":
        return float(np.count_nonzero(values > probe.above))
    return probe.reduced(values)


def scalar(values: np.ndarray, component: str | None = None, names: Sequence[str] = ()) -> np.ndarray:
    """Reduce a field of shape (n,) or (n, components) to one number per point, shape (n,).

    With `component`, this component is returned; `names` are the names of the components (default: the axes in space).
    Without it, the length of a vector or von Mises' stress of a tensor is returned.
    """
    if values.ndim == 1:
        return values
    if component is not None:
        return np.ascontiguousarray(values[:, (names or COMPONENT_NAMES[values.shape[1]]).index(component)])
    if names == FIELDS["plane_stress"].names:
        s11, s22, s12 = values.T
        return np.sqrt(s11**2 - s11 * s22 + s22**2 + 3.0 * s12**2)
    if values.shape[1] == 3:
        return np.asarray(np.linalg.norm(values, axis=1))
    xx, yy, zz, yz, xz, xy = values.T
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (yz**2 + xz**2 + xy**2))


def _nearest(field: Fetch, at: Any, periods: Vector) -> int:
    """Return the index of the point nearest to a position `at` [m], or to its periodic images.

    If several points are equally near, the point with the lowest number is returned, independent of the storage order.
    Points whose position is not finite, e.g. after an error stop, are ignored.
    """
    way = field("position") - np.asarray(at)
    for axis, period in enumerate(periods):
        if period > 0.0:
            way[:, axis] -= period * np.rint(way[:, axis] / period)
    distance = (way**2).sum(axis=1)
    distance[np.isnan(distance)] = np.inf
    near = np.flatnonzero(distance <= distance.min() * (1.0 + 1e-9))
    return int(near[np.argmin(field("id")[near])])
