"""Initial positions of bodies, and loading of the state of an earlier run into bodies that continue from it."""

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from pellucid.errors import CaseError, Problem
from pellucid.grid.lattice import Grid
from pellucid.parts.body import Body, in_metres
from pellucid.parts.capabilities import GainsPoints
from pellucid.parts.start_of_body import Standing
from pellucid.simulation.assembly import Built


class Standings(Mapping[str, Standing]):
    """Mapping from body names to initial positions (`Standing`), each computed when requested."""

    def __init__(self, bodies: Sequence[Body], going_on: Collection[str]) -> None:
        """bodies: all bodies; going_on: names of the bodies that start in the state of an earlier run."""
        self._bodies, self._going_on = {body.name: body for body in bodies}, going_on

    def __getitem__(self, name: str) -> Standing:
        body = self._bodies[name]
        if body.is_surface:
            return Standing(body.places(), body.cells().surface())
        return Standing(body.stored_array("position"), volume=body.volumes() if name in self._going_on else None)

    def __contains__(self, name: object) -> bool:
        return name in self._bodies

    def __iter__(self) -> Iterator[str]:
        return iter(self._bodies)

    def __len__(self) -> int:
        return len(self._bodies)


def load_state(built: Built, start: Mapping[str, Mapping[str, np.ndarray]]) -> None:
    """Load the arrays of an earlier run into bodies that continue from this run, before conditions act on them. Raises
    `CaseError` if the arrays do not fit.

    built: all bodies, by name; start: arrays of the bodies that continue, by body name and array name.
    """
    for name, state in start.items():
        body, field = built[name]
        more = len(state["id"]) - body.n_points
        if more > 0 and isinstance(body, GainsPoints) and not np.all(state["mass"]):  # rows for points that enter
            body.make_room(more, body.stored_array("position").mean(axis=0))
        if len(state["id"]) != body.n_points:
            text = f"body {name} has {body.n_points} points, but {len(state['id'])} in the earlier run"
            remedy = "Define the body as in the earlier run, or remove it from start.body."
            raise CaseError(Problem(text, "start.path", remedy=remedy))
        if field is not None:
            _check_inside(name, state["position"], field.grid)
        _give(body, state)


def _give(body: Body, state: Mapping[str, np.ndarray]) -> None:
    try:
        body.load_state(state)
    except KeyError as missing:
        text = f"body {body.name} requires {missing.args[0]}, which is not stored in the earlier run"
        remedy = (
            "Remove start.time (checkpoints contain more than frames), or use the kind and the material of the earlier run."
        )
        raise CaseError(Problem(text, "start", remedy=remedy)) from None


def _check_inside(name: str, position: np.ndarray, grid: Grid) -> None:
    lower = np.array(grid.lattice.lower)
    upper = lower + np.array(grid.lattice.counts) * grid.lattice.cell
    walled = ~(np.array(grid.thin) | np.array(grid.periodic))
    outside = np.flatnonzero((((position < lower) | (position > upper)) & walled).any(axis=1))
    if len(outside):
        text = f"{len(outside)} points of body {name} are outside the grid, for example number {outside[0]} at"
        raise CaseError(
            Problem(
                f"{text} {in_metres(position[outside[0]])}", "start.path", remedy="Enlarge the grid to contain these points."
            )
        )
