"""Active inflows: points that enter the grid through openings during a run."""

from collections.abc import Mapping, Sequence
from math import ceil, exp
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.conditions.open_faces.columns import OpenFace, opening_of
from pellucid.conditions.open_faces.strip import LedStrip, Passage, PushedStrip, work_of_strip
from pellucid.energy import INFLOW_WORK, Passed, StepWork
from pellucid.errors import CaseError, Problem, RunStopped
from pellucid.grid.model import GridCase
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.parts.capabilities import GainsPoints
from pellucid.step.limit import StepLimit
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.open_faces.inflow import Inflow

LAYERS = 8
"""Number of layers of points for which an opening reserves array rows, in addition to the points that fill the grid."""
LAYERS_OF_MEAN = 2
"""Number of layers of cells behind the strip over whose points the pressure is averaged."""
MARGIN = 0.25
"""Distance from the face at which a point enters under a given pressure, as a fraction of the point spacing; the flow may
move back by this distance."""
DENSER = 1.1
"""Largest total volume of a body relative to the volume of the grid, for which array rows are reserved."""


def entering(inflows: "Sequence[Inflow]", assembly: Assembly) -> list["Entering"]:
    """Build the active inflows, and reserve array rows in the bodies for the points that will enter."""
    found = [Entering(inflow, assembly, f"inflow.{inflow.name or number}") for number, inflow in enumerate(inflows)]
    for name in dict.fromkeys(inflow.body for inflow in inflows):
        _make_room(assembly.bodies[name], [one for one in found if one.body_name == name])
    return found


def _make_room(member: AssembledBody, inflows: "Sequence[Entering]") -> None:
    """Reserve array rows of a body for the points that fill the grid at their initial density, and for further layers of
    points at the openings of its inflows."""
    body = member.body
    volume = body.volumes()
    whole = inflows[0].grid_volume
    lacking = max(whole * DENSER - float(volume.sum()), 0.0) / float(volume.mean())
    rows = ceil(lacking) + LAYERS * sum(one.opening.n for one in inflows)
    member.offers(GainsPoints).make_room(rows, inflows[0].middle)


class Entering(StepPart):
    """Inflow in a run. Its state between steps: the distance by which the inflow has moved with its mean velocity so far
    [m], the largest value of this distance, its value when the pressure of new points was last computed [m], and the mean
    pressure drop behind the strip of cells at the opening [Pa]."""

    def __init__(self, inflow: "Inflow", assembly: Assembly, path: str) -> None:
        member = assembly.bodies[inflow.body]
        if member.actions is None:
            raise ValueError(f"body {inflow.body} has no points on the grid")
        self._path = path
        self._inflow, self._layout, self._grid = inflow, assembly.layout, member.actions.field.grid
        self._body, self.body_name = member.offers(GainsPoints), inflow.body
        case = self._grid.case
        self._face = OpenFace.of(inflow.where, case)
        self.opening, shape = opening_of(inflow.through, self._face, member.model, case)
        if not self.opening.n:
            text = f"no point of body {inflow.body} could enter through the face {inflow.where}: other bodies fill it"
            remedy = f"move the bodies in `body.{inflow.body}.outside` away from the face, or enlarge the opening (`through`)"
            raise CaseError(Problem(text, f"{path}.where", remedy=remedy))
        passage = Passage(self._face, self.opening, shape, case, member, self._face.inward, path)
        self.strip: LedStrip | PushedStrip
        self._margin = 0.0
        if inflow.pressure is None:
            self.strip = LedStrip(inflow, passage)
        else:
            column = assembly.load_column(inflow.body, INFLOW_WORK.name)
            self.strip = PushedStrip(inflow, passage, inflow.pressure, column)
            self._margin = MARGIN * self.opening.spacing
        self.grid_volume = self._grid.volume
        self.middle = self.opening.place.mean(axis=0)
        self.middle[self._face.axis] = self._face.level
        self._travel = self._furthest = self._seen = self._time = 0.0
        self._fall = 0.0
        self._work, self._impulse = 0.0, np.zeros(3)

    def try_out(self) -> None:
        """Compute the velocity profile, which depends on the supports that are known now, and the state in which points
        enter."""
        self.strip.find_profile()
        self.strip.speed = self.strip.mean_at(0.0)
        self._state = self._body.state_at(self.opening.place, self.opening.area * self.opening.spacing)
        self._given_pressure = _mean_pressure(self._state["stress"], self._state["volume"]) or 0.0

    def begin(self, time: float, dt: float) -> None:
        self.strip.begin(time, dt)
        self._time = time

    def act_on_nodes(self, dt: float) -> None:
        """Give all nodes of the strip of cells at the opening one common flow velocity (inflow under a pressure), or compute
        the work of their prescribed motion, over a step dt [s]. Raises RunStopped if the inflow reverses."""
        self._work, self._impulse = self.strip.act(dt)
        self._travel += dt * self.strip.speed
        if self._travel < self._furthest and (self._reached() < self._layers() * self.opening.spacing).any():
            text = f"time {self._time:.6g} s: backflow at the inflow through {self._face.name} (body {self.body_name})"
            key = f"{self._path}.pressure"
            remedy = (
                f"keep the pressure at this face above that at the outlet at all times: raise `{key}` or the smallest share of "
                f"its `amplitude`, or reduce `rise`; {self._face.when_flow_reverses}"
            )
            raise RunStopped(f"{text}; {remedy}", time=self._time, body=self.body_name)

    def step_limit(self) -> StepLimit:
        return self.strip.step_limit()

    def _reached(self) -> np.ndarray:
        """Return the distances from the face that the first points of the columns would have reached by moving along the
        normal with the flow velocity of their column [m], shape (c,)."""
        return np.asarray(self._travel * self.strip.at_columns + self.opening.depth)

    def _layers(self) -> np.ndarray:
        """Return the number of points that have entered in each column, shape (c,)."""
        reached = self._furthest * self.strip.at_columns + self.opening.depth - self._margin
        return np.maximum(np.floor(reached / self.opening.spacing), 0.0).astype(np.int64)

    def enter(self, n_steps: int, time: float) -> Sequence[Passed]:
        """Add a point to a column each time the column has advanced by one spacing, one spacing behind the previous point;
        return number, mass, momentum and energy of the new points. n_steps, time: number of the step and its end [s]."""
        before = self._layers()
        self._furthest = max(self._furthest, self._travel)
        number = self._layers() - before
        if not number.any():
            return ()
        column = np.repeat(np.arange(len(number)), number)
        layer = np.repeat(before, number) + np.arange(len(column)) - np.repeat(np.cumsum(number) - number, number)
        depth = self._reached()[column] - (layer + 1) * self.opening.spacing
        arrays = {name: array[column] for name, array in self._state.items()}
        arrays["position"][:, self._face.axis] = self._face.level + self._face.inward * np.maximum(depth, 0.0)
        arrays["velocity"][...] = (self.strip.speed * self.strip.at_columns)[column, None] * self.strip.normal
        return [self._body.let_in(self._pressed(arrays), n_steps, time)]

    def _pressed(self, arrays: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
        """Return the arrays of new points (by name, one row per point); in a liquid their pressure is set to the pressure at
        the inner end of the strip of cells at the opening.

        The pressure is the mean of the first layers behind the strip, plus half of the pressure drop from these to the
        next layers, for a flow with linear pressure. Points with any other pressure are compressed there within a cell,
        and their velocities change by oscillations from node to node: such pressure oscillations cause no restoring
        force. Half of the drop would amplify acoustic oscillations; therefore the drop is averaged over the points that
        enter while the flow passes these layers.
        """
        first, second = (_mean_pressure(*stresses) for stresses in self._body.stresses_of(self._behind))
        if first is None:
            return arrays
        moved, self._seen = self._furthest - self._seen, self._furthest
        share = 1.0 - exp(-moved / (LAYERS_OF_MEAN * self._grid.case.cell))
        self._fall += share * ((0.0 if second is None else first - second) - self._fall)
        return self._body.pressed(arrays, first + 0.5 * self._fall - self._given_pressure)

    def _behind(self, position: np.ndarray) -> Sequence[np.ndarray]:
        """Return the indices of the points in the first LAYERS_OF_MEAN layers of cells behind the strip, and of the points
        in the next LAYERS_OF_MEAN layers; position: positions of all points [m], shape (n, 3).

        The average over LAYERS_OF_MEAN layers removes pressures that oscillate from cell to cell.
        """
        case, place = self._grid.case, self.opening.place
        across = np.delete(np.arange(3), self._face.axis)
        low, high = (end[across] for end in (place.min(axis=0) - 0.5 * case.cell, place.max(axis=0) + 0.5 * case.cell))
        depth, beside = self._face.depth(position), _folded(position, case)[:, across]
        sets = np.floor((depth - self.strip.depth) / (LAYERS_OF_MEAN * case.cell))
        sets[((beside < low) | (beside > high)).any(axis=1)] = -1
        return [np.flatnonzero(sets == number) for number in range(2)]

    def work(self) -> StepWork:
        return work_of_strip(self._layout, INFLOW_WORK, self._work, self._impulse, self._inflow.name)

    def state_numbers(self) -> dict[str, Any]:
        passed = {"travel": self._travel, "furthest": self._furthest, "seen": self._seen, "fall": self._fall}
        return passed | {"speed": self.strip.speed}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._travel, self._furthest, self._seen, self._fall, self.strip.speed = (
            float(numbers[key]) for key in ("travel", "furthest", "seen", "fall", "speed")
        )


def _folded(position: np.ndarray, case: GridCase) -> np.ndarray:
    """Return positions [m], shape (n, 3), moved by whole periods into the grid."""
    folded = position.copy()
    for axis, period in enumerate(case.periods()):
        if period > 0.0:
            folded[:, axis] = case.lower[axis] + (position[:, axis] - case.lower[axis]) % period
    return folded


def _mean_pressure(stress: np.ndarray, volume: np.ndarray) -> float | None:
    """Return the mean pressure [Pa], weighted with the volumes [m³], shape (n,), of points with Cauchy stresses [Pa], shape
    (n, 6); None without points."""
    return float(np.average(-stress[:, :3].mean(axis=1), weights=volume)) if len(volume) else None
