"""Two curves of a run beside finite elements of our own."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.style import COLOURS, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.run import Run

Array = np.ndarray

CELL = 0.001
"""That of the paper [m]."""

TOLERANCE, LEAST_TOLERANCE = 0.10, 0.05
"""Shares of the largest excursion: at the paper's cell, and at half of it and below."""


class Curve(NamedTuple):
    """A column of the history beside its reference; `known` and `others` [m] over `times` [s], others by what they are."""

    column: str
    what: str
    times: Array
    known: Array
    others: dict[str, Array]
    band: tuple[Array, Array] | None = None
    """Least and greatest of the computations whose mean `known` is."""


def tolerance_of(run: "Run") -> float:
    """In proportion to the cell."""
    return max(LEAST_TOLERANCE, TOLERANCE * run.case.grid.cell / CELL)


def deviations(run: "Run", curves: tuple[Curve, ...]) -> dict[str, Metric]:
    """Largest deviation of each curve, as a share of the largest excursion of its reference."""
    found = {}
    for curve in curves:
        error = finite_elements.largest_deviation(run.history["time"], run.history[curve.column], curve.times, curve.known)
        text = f"largest deviation of {curve.what} from finite elements over their largest excursion"
        found[f"{curve.column[:-2]}_deviation"] = Metric(error, 0.0, error, tolerance_of(run), "", text)
    return found


def figure_of(run: "Run", curves: tuple[Curve, ...]) -> "Figure":
    """The curves above, how far they are from the reference below."""
    figure = new_figure(height=5.6)
    panels = figure.subplots(2, len(curves), sharex=True, height_ratios=(3, 1))
    now = run.history["time"]
    for (above, below), curve, colour in zip(panels.T, curves, COLOURS, strict=False):
        ms, reached = 1e3 * curve.times, curve.times <= now[-1] * (1.0 + 1e-9)
        if curve.band is not None:
            above.fill_between(ms, *(1e3 * side for side in curve.band), color="black", alpha=0.15, linewidth=0)
        above.plot(ms, 1e3 * curve.known, color="black", linewidth=1, label="finite elements")
        for (name, other), line in zip(curve.others.items(), (":", "--", "-."), strict=False):
            above.plot(ms, 1e3 * other, color="black", linewidth=1, linestyle=line, label=f"finite elements, {name}")
        above.plot(1e3 * now, 1e3 * run.history[curve.column], color=colour, label=f"cell {1e3 * run.case.grid.cell:g} mm")
        above.set_title(curve.what)
        above.legend()
        apart = np.interp(curve.times, now, run.history[curve.column]) - curve.known
        scale = np.abs(curve.known - curve.known[0]).max()
        if curve.band is not None:
            sides = (100.0 * (side - curve.known) / scale for side in curve.band)
            below.fill_between(ms, *sides, color="black", alpha=0.15, linewidth=0)
        below.plot(ms[reached], 100.0 * apart[reached] / scale, color=colour)
        below.set_xlabel("time [ms]")
    panels[0, 0].set_ylabel("z [mm]")
    panels[1, 0].set_ylabel("deviation [%]")
    figure.suptitle(run.case.title)
    return figure
