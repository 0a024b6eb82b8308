"""Picture of the state at an error stop; the point at which the error occurred is marked."""

from typing import Any

import numpy as np

from pellucid.grid.model import GridCase
from pellucid.results.pictures.style import COLOURS, Axes, Figure, Run, label, new_figure
from pellucid.results.storage.files import OutputError
from pellucid.state import of_owner

MOST_POINTS = 30_000  # of a body
CLOSE_UP = 0.06  # half the width of the view at larger scale, as a share of the extent of the bodies
MARK = "#b3261e"


def where_it_stopped(run: Run) -> Figure | None:
    """Draw the state at which the run stopped: all bodies as points, in space in three views, and a close-up around the
    point that stopped the run, with the edge of the grid if the point is near the edge. Return the figure; None if no state
    was stored."""
    arrays = run.folder.read_state()
    if not arrays:
        return None
    places = {body.name: of_owner(body.name, arrays)["position"] for body in run.stored.bodies}
    positions = {name: place[np.isfinite(place).all(axis=1)] for name, place in places.items()}
    drawn = np.concatenate(list(positions.values()))
    if not len(drawn):
        return None
    place = place_of_stop(run)
    views = _views(run.stored.thin)
    scales = 1 if place is None else 2
    flat = len(views) == 1
    figure = new_figure(height=4.2 if flat else 3.4 * scales)
    panels = figure.subplots(1, scales, squeeze=False).T if flat else figure.subplots(scales, len(views), squeeze=False)
    reach = CLOSE_UP * float(np.ptp(drawn, axis=0).max())
    if place is not None and run.stored.grid is not None:
        reach = max(reach, 1.2 * _beyond(run.stored.grid, place))  # so that the face which it crossed is seen
    for row in panels:
        for axes, view in zip(row, views, strict=True):
            _dots(axes, positions, view)
            if place is not None:
                at = place[list(view)]
                ring = {"markerfacecolor": "none", "markeredgecolor": MARK, "markeredgewidth": 2.0, "clip_on": False}
                axes.plot(*at, "o", markersize=16, **ring)  # whole also at the edge of what is shown
    if place is not None and reach > 0.0:
        for axes, view in zip(panels[1], views, strict=True):
            axes.set_aspect("equal", adjustable="box")
            for limits, centre in zip((axes.set_xlim, axes.set_ylim), place[list(view)], strict=True):
                limits(centre - reach, centre + reach)
            if run.stored.grid is not None:
                _edge_of(axes, run.stored.grid, view, place, reach)
    known = {name: handle for axes in panels[:, 0] for handle, name in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(known.values(), known.keys(), loc="outside lower center", ncols=5, markerscale=3, fontsize=8)
    figure.suptitle(f"Where the run stopped: {_instant(run.stopped)}, {_named(run.stopped)}")
    return figure


def _dots(axes: Axes, positions: dict[str, np.ndarray], view: tuple[int, int]) -> None:
    for (name, position), colour in zip(positions.items(), COLOURS * len(positions), strict=False):
        stride = -(-len(position) // MOST_POINTS)
        axes.plot(*position[:: max(stride, 1), list(view)].T, ".", markersize=2.0, color=colour, label=name)
    axes.set_aspect("equal", adjustable="datalim")
    label(axes, "xyz"[view[0]], "xyz"[view[1]], "m", "m")


def _beyond(grid: GridCase, place: np.ndarray) -> float:
    """Return the distance of a position outside the grid [m], 0 inside."""
    return float(np.max((grid.lower - place, place - grid.extent_upper()), initial=0.0))


def _edge_of(axes: Axes, grid: GridCase, view: tuple[int, int], place: np.ndarray, reach: float) -> None:
    """Draw the boundary of the grid if the boundary is within `reach` [m] of the position `place` [m]. view: the two axes
    (0 to 2) of the picture."""
    from matplotlib.patches import Rectangle

    low, high = (np.array(corner)[list(view)] for corner in (grid.lower, grid.extent_upper()))
    if np.any(np.abs(np.stack((low, high)) - place[list(view)]) < reach):
        (x, y), (width, height) = low, high - low
        edge = Rectangle((x, y), width, height, fill=False, edgecolor="black", linewidth=1.2, label="boundary of the grid")
        axes.add_patch(edge)


def _views(thin: tuple[bool, bool, bool]) -> list[tuple[int, int]]:
    """Return, for each view of the point that stopped the run, the pair of axes that span the picture; thin: axes along
    which the grid is one cell thick."""
    wide = [axis for axis in range(3) if not thin[axis]]
    if len(wide) == 3:
        return [(0, 1), (0, 2), (1, 2)]
    return [(wide[0], wide[1] if len(wide) > 1 else (wide[0] + 1) % 3)]


def place_of_stop(run: Run) -> np.ndarray | None:
    """Return the position of the point that stopped the run [m], shape (3,). If the position at the stop is not finite, the
    position in the last frame is returned; None if no point is known."""
    failure = run.stopped
    known = failure.get("position") or failure.get("state", {}).get("position")
    if known and None not in known:
        return np.array(known, dtype=float)
    body, point = failure.get("body"), failure.get("point")
    if body is None or point is None:
        return None
    try:
        last = run.fields(body)["position"]
    except OutputError:  # its fields are damaged
        return None
    return last[point] if point < len(last) and np.isfinite(last[point]).all() else None


def mark_stop(run: Run, axes: Axes, name: str = "") -> None:
    """Draw a vertical line at the time of an error stop if the curves end before it (no row is recorded for the step that
    failed). name: label of the line in a legend."""
    time, times = run.stopped.get("time"), run.history["time"]
    if time is not None and len(times) and time > times[-1]:
        axes.axvline(time, color=MARK, linewidth=1.0, linestyle=":", label=name)


def _instant(failure: dict[str, Any]) -> str:
    return f"settling step {failure['settling_step']}" if "settling_step" in failure else f"step {failure['step']}"


def _named(failure: dict[str, Any]) -> str:
    what = [f"{word} {failure[word]}" for word in ("point", "node") if word in failure]
    return " of ".join([*what, *([str(failure["body"])] if "body" in failure else [])]) or "place unknown"
