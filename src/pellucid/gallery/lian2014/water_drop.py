"""The drop on the clamped sheet: nothing passes through, and the drop spreads and breaks."""

from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from pellucid.results.metrics import Metric
from pellucid.results.style import COLOURS, label, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.run import Run

Array = np.ndarray

ROUNDING = 1e-12
SPREAD = 1.5  # times its first radius, from 1.2 ms on
REACH = 1.5  # spacings, to which points still belong together: the lattice's diagonal in a face is 1.41
LEAST_BROKEN = 0.01  # share of the points
SHOWN = 0.012  # to each side of the middle [m]

CAPTIONS = {
    "curves": "Middle of the sheet and top of the drop.",
    "shapes": "What lay beside the plane y = 0 at the start, of sheet and drop.",
}


def metrics(run: "Run") -> dict[str, Metric]:
    """Points of the water below the sheet in any frame, momentum, spread of the drop, and what broke off it."""
    times = run.times("drop")
    worst = max(points_below(run, float(time)) for time in times)
    number = len(run.fields("drop")["mass"])
    result = {
        "leak": Metric(worst, 0.0, worst, 0.5 / number, "", "largest share of the drop's points below the sheet in any frame")
    }
    momentum = run.summary["conservation"]["momentum"]
    text = "momentum that no impulse explains, over the largest sum of mass times speed"
    result["momentum"] = Metric(momentum, 0.0, momentum, ROUNDING, "", text)
    grown = _radius(run, float(times[-1])) / _radius(run, 0.0)
    text = "the drop's radius over that at the start; falls short of the reference by"
    result["spread"] = Metric(grown, SPREAD, max(0.0, 1.0 - grown / SPREAD), 1e-9, "", text)
    apart = broken(run, float(times[-1]))
    text = "share of the drop's points that no longer hang together with most; falls short of the reference by"
    result["broken"] = Metric(apart, LEAST_BROKEN, max(0.0, LEAST_BROKEN - apart), 1e-9, "", text)
    return result


def points_below(run: "Run", time: float) -> float:
    """Share of the drop's points that are below the sheet, flat between its nodes, in the frame nearest to a time [s]."""
    sheet, drop = (np.asarray(run.fields(name, time)["position"]) for name in ("sheet", "drop"))
    height = LinearNDInterpolator(sheet[:, :2], sheet[:, 2])(drop[:, :2])
    return float(np.mean(~(drop[:, 2] >= height)))  # outside the sheet counts as below


def broken(run: "Run", time: float) -> float:
    """Share of the drop's points that are not in its largest piece in the frame nearest to a time [s]."""
    start = np.asarray(run.fields("drop", 0.0)["position"])
    distances = np.asarray(cKDTree(start).query(start, 2)[0])
    spacing = float(np.median(distances[:, 1]))
    now = cKDTree(np.asarray(run.fields("drop", time)["position"]))
    _, piece = connected_components(now.sparse_distance_matrix(now, REACH * spacing), directed=False)
    return float(1.0 - np.bincount(piece).max() / len(piece))


def _radius(run: "Run", time: float) -> float:
    x, y, _ = np.asarray(run.fields("drop", time)["position"]).T
    return float(np.hypot(x, y).max())


def figures(run: "Run") -> dict[str, "Figure"]:
    """Curves against time, and the middle cut."""
    return {"curves": _curves(run), "shapes": _shapes(run)}


def _curves(run: "Run") -> "Figure":
    figure = new_figure(height=3.2)
    axes = figure.subplots()
    for column, what, colour in (("membrane_z", "sheet's middle", COLOURS[0]), ("drop_top_z", "drop's top", COLOURS[1])):
        axes.plot(1e3 * run.history["time"], 1e3 * run.history[column], color=colour, label=what)
    label(axes, "time", "z", "ms", "mm")
    axes.legend()
    figure.suptitle(run.case.title)
    return figure


def _shapes(run: "Run") -> "Figure":
    figure = new_figure(height=5.2)
    subplots = figure.subplots(3, 2, sharex=True, sharey=True)
    half = 0.51 * run.case.grid.cell
    times = run.times("drop")
    for axes, time in zip(subplots.flat, np.linspace(0.0, times[-1], 6), strict=True):
        nearest = times[np.argmin(np.abs(times - time))]
        for name, colour in (("drop", COLOURS[1]), ("sheet", COLOURS[0])):
            begun, now = (np.asarray(run.fields(name, instant)["position"]) for instant in (0.0, float(nearest)))
            shown = (np.abs(begun[:, 1]) < half) & (np.abs(now[:, 0]) < SHOWN)
            axes.plot(1e3 * now[shown, 0], 1e3 * now[shown, 2], ".", markersize=2, color=colour, label=name)
        axes.set_aspect("equal")
        axes.set_title(f"t = {1e3 * nearest:.2f} ms")
        label(axes, "x", "z", "mm", "mm")
        axes.label_outer()
    subplots[0, 0].legend(markerscale=4, loc="lower left")
    return figure
