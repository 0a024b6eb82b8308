"""Bodies that start behind walls that are planes."""

from collections.abc import Set as AbstractSet

from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.errors import CaseError, Problem
from pellucid.parts.condition import is_driven
from pellucid.set_up.hard_bodies import hard_bodies
from pellucid.set_up.overlap import DEPTH

REMEDY = "move one of the two, turn `normal` to the side where bodies are, or name in `bodies` those that touch it"


def refuse_behind_walls(case: Case, going_on: AbstractSet[str] = frozenset()) -> None:
    """Raise CaseError where a body starts behind a wall that it touches.

    going_on: names of the bodies that begin in the state of an earlier run.
    """
    if case.grid_or_none is None:
        return
    parts, hard = parts_of(case), {body.name for body in hard_bodies(case)}
    for number, wall in enumerate(case.wall):
        plane, most = wall.plane(), DEPTH * case.grid.cell
        for body in wall.touching(case.body):
            if body.name in going_on or is_driven(body.name, parts):  # a motion leads it through
                continue
            places = body.with_others(case.body).touching_places(case.grid, body.name in hard)
            depth = -plane.height(places)
            if len(depth) and depth.max() > most:
                deepest = int(depth.argmax())
                place = ", ".join(f"{value:.4g}" for value in places[deepest])
                text = (
                    f"body {body.name} starts behind this wall, at ({place}) m by {depth[deepest]:.4g} m; at most a quarter of "
                    f"a cell, {most:.4g} m, is allowed"
                )
                raise CaseError(Problem(text, f"wall.{wall.name or number}.point", remedy=REMEDY))
