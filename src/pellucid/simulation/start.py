"""Initial positions of bodies, loading of the state of an earlier run into bodies that continue from it, and overlaps of
surfaces at the start, which exert no force until they have opened once."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.errors import CaseError, Problem
from pellucid.grid.lattice import Grid
from pellucid.parts.body import Body, in_metres
from pellucid.parts.start_of_body import Standing
from pellucid.simulation.assembly import Built

if TYPE_CHECKING:
    from pellucid.case import Case

REPORTED = 1e-3  # cells: depth from which an overlap is reported


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


class OverlappingStart(NamedTuple):
    """An overlap at the start of a run between two bodies, a body and a wall, or parts of one body: names, depth and
    contact distance [m], and the message for the user."""

    between: tuple[str, ...]
    """Names of both, each with its kind ("body", "wall"); a single name for parts of one body."""
    depth: float
    """Largest depth of the overlap [m]."""
    distance: float
    """Distance between the given surfaces at which contact acts: the sum of both contact offsets [m]."""

    @property
    def text(self) -> str:
        """Message about the overlap for the user."""
        depth = f"{self.depth:.4g} m"
        if len(self.between) == 1:
            return (
                f"parts of {self.between[0]} start up to {depth} closer to each other than twice the contact offset, "
                f"{self.distance:.4g} m (`contact_offset`, default: half of the thickness): this overlap exerts no "
                "force on a point until the point has separated once. To have contact act from the start, move the parts "
                f"away from each other by {depth}, or set a smaller `contact_offset`."
            )
        one, other = self.between
        if self.distance > 0.0:
            limit = f"{self.distance:.4g} m (`contact_offset` of each membrane, default: half of the thickness)"
            where = f"start {depth} closer to each other than the contact distance of {limit}"
            remedy = f"move one of the two away by {depth}"
            if self.depth < self.distance:
                remedy += ", or set a smaller `contact_offset`"
        else:
            where, remedy = f"overlap by {depth} at the start", f"move one of the two away by {depth}"
        return (
            f"{one} and {other} {where}: this overlap exerts no force until they have separated once, so contact starts "
            f"{depth} late. To have contact act from the start, {remedy}."
        )

    def facts(self) -> dict[str, Any]:
        """Return the data of the overlap for the summary of the run, by name."""
        return {"between": list(self.between), "depth": self.depth, "distance": self.distance}


def find_start_overlaps(
    pairs: SurfacePairs, case: "Case", going_on: Mapping[str, Mapping[str, np.ndarray]]
) -> list[OverlappingStart]:
    """Return the overlaps between contact surfaces at the start of a run that are larger than rounding errors.

    pairs: contacts of surfaces; going_on: arrays of the bodies that start in the state of an earlier run, by body, see
    `SurfacePairs.go_on`.
    """
    pairs.go_on(going_on)
    if not len(pairs):
        return []
    found = [OverlappingStart(pair.between, depth, pair.distance) for pair, depth in pairs.find_start_overlaps()]
    return [overlap for overlap in found if overlap.depth > REPORTED * case.grid.cell]
