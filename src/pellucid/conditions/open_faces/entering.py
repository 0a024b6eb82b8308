"""Points that enter the grid through openings during a run, and inflows with a prescribed flow."""

from collections.abc import Mapping, Sequence
from math import ceil, exp
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.conditions.open_faces.columns import Columns, OpenFace, opening_of
from pellucid.conditions.open_faces.strip import LedStrip, Passage, work_of_strip
from pellucid.energy import INFLOW_WORK, Passed, StepWork
from pellucid.errors import CaseError, Problem
from pellucid.grid.model import GridCase
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.parts.capabilities import GainsPoints, LosesPoints
from pellucid.step.limit import StepLimit
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.open_faces.inflow import Inflow

LAYERS = 8
"""Number of layers of points for which an opening reserves array rows, in addition to the points that fill the grid."""
LAYERS_OF_MEAN = 2
"""Number of layers of cells behind the strip over whose points the pressure is averaged."""
DENSER = 1.1
"""Largest total volume of a body relative to the volume of the grid, for which array rows are reserved."""


class EnteringColumns:
    """Columns in which points of a body enter through an opening.

    A point enters when a column has room for it: when the length between the face and the first point of the column reaches the
    spacing of the points, plus `margin`.

    Attributes
    ----------
    room : ndarray, shape (c,)
        Length between the face and the first point in each column [m]. The flow into the grid increases it, and so does a
        point that leaves through the column; the flow out of the grid and a point that enters decrease it.
    """

    def __init__(self, member: AssembledBody, face: OpenFace, opening: Columns, margin: float = 0.0) -> None:
        """member: the body; face: face with the opening; opening: its columns; margin: see above [m]."""
        if member.velocity_field is None:
            raise ValueError(f"body {member.body.name} has no points on the grid")
        self.body, self.name, self.opening = member.offers(GainsPoints), member.body.name, opening
        self._face, self._case, self._margin = face, member.velocity_field.grid.case, margin
        self.room = opening.depth.copy()
        self._reserve(member, member.velocity_field.grid.volume)

    def _reserve(self, member: AssembledBody, whole: float) -> None:
        """Reserve array rows of the body for the points that fill the grid, whose volume is `whole` [m³], at their initial
        density, and for further layers of points at the opening."""
        volume = member.body.volumes()
        mean = float(np.mean(volume[volume > 0.0]))
        lacking = max(whole * DENSER / mean - len(volume), 0.0)
        middle = self.opening.place.mean(axis=0)
        middle[self._face.axis] = self._face.level
        self.body.make_room(ceil(lacking) + LAYERS * self.opening.n, middle)

    def find_state(self) -> None:
        """Compute the state in which points enter, which is that of the body at the start."""
        self._state = self.body.state_at(self.opening.place, self.opening.area * self.opening.spacing)
        self._own_pressure = mean_pressure(self._state["stress"], self._state["volume"]) or 0.0

    def is_due(self) -> bool:
        """Return True if a column has room for another point."""
        return bool((self.room >= self.opening.spacing + self._margin).any())

    def give_way(self, position: np.ndarray, volume: np.ndarray) -> None:
        """Add the room of points that left, each to the nearest column; position: their positions [m], shape (n, 3); volume:
        their volumes [m³], shape (n,)."""
        if len(volume):
            offset = np.delete(position[:, None] - self.opening.place, self._face.axis, axis=2)
            column = np.argmin(np.einsum("pcd,pcd->pc", offset, offset), axis=1)
            self.room += np.bincount(column, volume / self.opening.area[column], self.opening.n)

    def limit_room(self, where: np.ndarray) -> None:
        """Limit the room of the columns `where`, shape (c,), to that for one point, so that errors of the room cannot add
        up in a long flow out of the grid."""
        most = self.opening.spacing + self._margin
        self.room[where] = np.clip(self.room[where], -most, np.nextafter(most, 0.0))

    def enter(self, velocity: np.ndarray, pressure: float | None, n_steps: int, time: float) -> Sequence[Passed]:
        """Add points where the columns have room; return number, mass, momentum and energy of the new points.

        velocity: velocity of the new points into the grid in each column [m/s], shape (c,); pressure: mean pressure of the new
        points of a liquid [Pa], None for that of the start; n_steps, time: number of the step and its end [s].
        """
        spacing = self.opening.spacing
        number = np.maximum(np.floor((self.room - self._margin) / spacing), 0.0).astype(np.int64)
        if not number.any():
            return ()
        column = np.repeat(np.arange(len(number)), number)
        layer = np.arange(len(column)) - np.repeat(np.cumsum(number) - number, number)
        depth = self.room[column] - (layer + 1) * spacing
        self.room -= number * spacing
        arrays: Mapping[str, np.ndarray] = {name: array[column] for name, array in self._state.items()}
        arrays["position"][:, self._face.axis] = self._face.level + self._face.inward * np.maximum(depth, 0.0)
        arrays["velocity"][...] = 0.0
        arrays["velocity"][:, self._face.axis] = self._face.inward * velocity[column]
        if pressure is not None:
            arrays = self.body.pressed(arrays, pressure - self._own_pressure)
        return [self.body.let_in(arrays, n_steps, time)]

    def pressures_behind(self, depth: float) -> list[float | None]:
        """Return the mean pressures [Pa] of the points in the first LAYERS_OF_MEAN layers of cells deeper than `depth` [m]
        below the opening, and in the next LAYERS_OF_MEAN layers; None without points.

        The average over LAYERS_OF_MEAN layers removes pressures that oscillate from cell to cell.
        """

        def behind(position: np.ndarray) -> Sequence[np.ndarray]:
            case, place = self._case, self.opening.place
            across = np.delete(np.arange(3), self._face.axis)
            low, high = (end[across] for end in (place.min(axis=0) - 0.5 * case.cell, place.max(axis=0) + 0.5 * case.cell))
            deep, beside = self._face.depth(position), _folded(position, case)[:, across]
            sets = np.floor((deep - depth) / (LAYERS_OF_MEAN * case.cell))
            sets[((beside < low) | (beside > high)).any(axis=1)] = -1
            return [np.flatnonzero(sets == number) for number in range(2)]

        return [mean_pressure(*stresses) for stresses in self.body.stresses_of(behind)]


class PrescribedInflow(StepPart):
    """Inflow with a prescribed flow in a run. Its state between steps: the room in its columns [m], the distance that the flow
    has moved since the pressure of new points was last computed [m], and the mean pressure drop behind the strip of cells at
    the opening [Pa]."""

    def __init__(self, inflow: "Inflow", assembly: Assembly, path: str) -> None:
        member = assembly.bodies[inflow.body]
        face, opening, passage = inflow_opening(inflow, member, path)
        self._columns = EnteringColumns(member, face, opening)
        self._strip, self._cell = LedStrip(inflow, passage), passage.case.cell
        self._layout, self._name = assembly.layout, inflow.name
        self._travel = self._fall = 0.0
        self._work, self._impulse = 0.0, np.zeros(3)

    def try_out(self) -> None:
        """Compute the velocity profile, which depends on the supports that are known now, and the state in which points
        enter."""
        self._strip.find_profile()
        self._strip.speed = self._strip.mean_at(0.0)
        self._columns.find_state()

    def begin(self, time: float, dt: float) -> None:
        self._strip.begin(time, dt)

    def act_on_nodes(self, dt: float) -> None:
        """Compute the work of the prescribed motion of the nodes in the strip over a step dt [s]."""
        self._work, self._impulse = self._strip.act(dt)
        moved = dt * self._strip.speed
        self._travel += moved
        self._columns.room += moved * self._strip.at_columns

    def step_limit(self) -> StepLimit:
        return self._strip.step_limit()

    def enter(self, n_steps: int, time: float) -> Sequence[Passed]:
        """Add a point to a column each time the column has advanced by one spacing; in a liquid its pressure is set to the
        pressure at the inner end of the strip of cells at the opening.

        The pressure is the mean of the first layers behind the strip, plus half of the pressure drop from these to the
        next layers, for a flow with linear pressure. Points with any other pressure are compressed there within a cell,
        and their velocities change by oscillations from node to node: such pressure oscillations cause no restoring
        force. Half of the drop would amplify acoustic oscillations; therefore the drop is averaged over the points that
        enter while the flow passes these layers.
        """
        if not self._columns.is_due():
            return ()
        first, second = self._columns.pressures_behind(self._strip.depth)
        pressure = None
        if first is not None:
            share = 1.0 - exp(-self._travel / (LAYERS_OF_MEAN * self._cell))
            self._fall += share * ((0.0 if second is None else first - second) - self._fall)
            self._travel, pressure = 0.0, first + 0.5 * self._fall
        return self._columns.enter(self._strip.speed * self._strip.at_columns, pressure, n_steps, time)

    def work(self) -> StepWork:
        return work_of_strip(self._layout, INFLOW_WORK, self._work, self._impulse, self._name)

    def state_numbers(self) -> dict[str, Any]:
        return {"travel": self._travel, "fall": self._fall, "speed": self._strip.speed}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._travel, self._fall, self._strip.speed = (float(numbers[key]) for key in ("travel", "fall", "speed"))

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {"room": self._columns.room}

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        self._columns.room[:] = arrays["room"]


class LeavingPoints(StepPart):
    """Removes points that crossed open faces of the grid in a step from bodies."""

    def __init__(self, bodies: Sequence[LosesPoints]) -> None:
        self._bodies = bodies

    def leave(self) -> list[Passed]:
        return [left for body in self._bodies if (left := body.let_leave()) is not None]


def inflow_opening(inflow: "Inflow", member: AssembledBody, path: str) -> tuple[OpenFace, Columns, Passage]:
    """Return the face of an inflow, the columns of points of its opening, and the opening as a passage.

    member: the body that enters; path: path of the inflow in the case, for messages. Raises CaseError if no point of the body
    can enter.
    """
    if member.velocity_field is None:
        raise ValueError(f"body {inflow.body} has no points on the grid")
    case = member.velocity_field.grid.case
    face = OpenFace.of(inflow.where, case)
    opening, shape = opening_of(inflow.through, face, member.model, case)
    if not opening.n:
        text = f"no point of body {inflow.body} could enter through the face {inflow.where}: other bodies fill it"
        remedy = f"move the bodies in `body.{inflow.body}.outside` away from the face, or enlarge the opening (`through`)"
        raise CaseError(Problem(text, f"{path}.where", remedy=remedy))
    return face, opening, Passage(face, opening, shape, case, member, face.inward, path)


def _folded(position: np.ndarray, case: GridCase) -> np.ndarray:
    """Return positions [m], shape (n, 3), moved by whole periods into the grid."""
    folded = position.copy()
    for axis, period in enumerate(case.periods()):
        if period > 0.0:
            folded[:, axis] = case.lower[axis] + (position[:, axis] - case.lower[axis]) % period
    return folded


def mean_pressure(stress: np.ndarray, volume: np.ndarray) -> float | None:
    """Return the mean pressure [Pa], weighted with the volumes [m³], shape (n,), of points with Cauchy stresses [Pa], shape
    (n, 6); None without points."""
    return float(np.average(-stress[:, :3].mean(axis=1), weights=volume)) if len(volume) else None
