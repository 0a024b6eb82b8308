"""Checks of a case before a run: errors and warnings."""

from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet

from pellucid.case import Case
from pellucid.findings import listed
from pellucid.parts.body_model import Standing
from pellucid.set_up.behind_walls import refuse_behind_walls
from pellucid.set_up.coarse_bodies import coarse_drops, coarse_indenters, coarse_sheets
from pellucid.set_up.floating import floating_bodies
from pellucid.set_up.flows import flow_warnings, slipped_past
from pellucid.set_up.gaps import narrow_gaps, narrow_slits
from pellucid.set_up.held_edges import held_edges
from pellucid.set_up.overlap import overlaps_within_fields, refuse_overlaps
from pellucid.set_up.supports import crossing_supports, free_turns, leading_out, passed_walls


def stand(case: Case) -> dict[str, Standing]:
    """Return the initial points of each body by name, without bodies that continue from an earlier run. Raises CaseError if
    a body cannot be placed."""
    names = {body.name for body in case.body}
    if case.start is not None:
        names -= set(case.start.body or names)
    if case.grid_or_none is None:
        return {}
    return {body.name: body.with_others(case.body).standing(case.grid) for body in case.body if body.name in names}


def look(case: Case) -> Iterator[str]:
    """Yield the warnings about a case that can be found quickly, without building its bodies. Raises CaseError if a run
    would refuse the case."""
    for body in case.body:
        body.check_set_up()
    standing = stand(case)
    going_on = {body.name for body in case.body} - standing.keys()
    refuse(case, standing, going_on)
    yield from warnings_of(case, standing, going_on)


def refuse(case: Case, standing: Mapping[str, Standing], going_on: AbstractSet[str] = frozenset()) -> None:
    """Raise CaseError if bodies start inside each other or behind walls.

    standing: initial points of the bodies, by name; going_on: names of the bodies that continue from an earlier run.
    """
    refuse_overlaps(case.body, standing, case.grid_or_none, going_on)
    refuse_behind_walls(case, going_on)


def warnings_of(case: Case, standing: Mapping[str, Standing], going_on: AbstractSet[str] = frozenset()) -> Iterator[str]:
    """Yield all warnings about a case before it runs: overlaps, supports, flows, floating bodies, narrow gaps and the like.

    standing: initial points of the bodies, by name. going_on: names of the bodies that continue from an earlier run.

    """
    yield from overlaps_within_fields(case.body, standing, case.grid_or_none, going_on)
    for model in case.body:
        yield from model.start_warnings()
    yield from free_turns(case)
    yield from passed_walls(case)
    yield from late_pictures(case)
    yield from gravity_across(case)
    yield from flow_warnings(case)
    yield from slipped_past(case)
    yield from crossing_supports(case)
    yield from leading_out(case)
    yield from floating_bodies(case)
    yield from held_edges(case)
    yield from coarse_drops(case)
    if case.grid_or_none is not None and len({body.field for body in case.body}) > 1:
        yield from coarse_indenters(case)
        yield from coarse_sheets(case)
    if case.grid_or_none is not None:
        yield from narrow_gaps(case, going_on)
        yield from narrow_slits(case, going_on)


def late_pictures(case: Case) -> Iterator[str]:
    """Yield a warning for each picture that the case requests at times later than the end of the run."""
    for picture in case.picture:
        late = [f"{time:g} s" for time in picture.times if case.time.passed(time)]
        if late:
            text = f"picture {picture.name}: {', '.join(late)} is later than time.end = {case.time.end:g} s"
            yield f"{text}; the last frame is drawn instead. Set `times` to times up to time.end."


def gravity_across(case: Case) -> Iterator[str]:
    """Yield a warning if gravity acts only along axes along which the grid is one cell thick: velocities along such axes
    are zero, so that gravity moves nothing."""
    across = [axis for axis, g, thin in zip("xyz", case.gravity, case.thin, strict=True) if g and thin]
    if across and not any(g for g, thin in zip(case.gravity, case.thin, strict=True) if not thin):
        within = [axis for axis, thin in zip("xyz", case.thin, strict=True) if not thin]
        yield (
            f"gravity acts only along {listed(across)}, where the grid is one cell thick, so it moves nothing. "
            f"Set a component of `gravity` along {' or '.join(within)}, or enlarge the grid along {listed(across)}."
        )
