"""Two curves of a run beside finite elements of our own."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pellucid.gallery.exact_curves import beside_elements, vanishing
from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.style import COLOURS, new_panels

Array = np.ndarray

CELL = 0.001
"""That of the paper [m]."""

TOLERANCE, LEAST_TOLERANCE = 0.10, 0.05
"""Shares of the largest excursion: at the paper's cell, and at half of it and below."""


HOURGLASS = 0.01
"""Of the kinetic energy at the start."""


class Curve(NamedTuple):
    """A column of the history beside its reference: `known` and `other` [m] over `times` [s]; `remark` says what that is."""

    column: str
    what: str
    times: Array
    known: Array
    other: Array
    remark: str


def curves_of(table: str, names: Mapping[str, str], known: str, other: str, remark: str) -> tuple[Curve, ...]:
    """Those of a table: of columns with what they are; known, other: how the table's columns begin, beside the same names."""
    read = finite_elements.read(table)
    return tuple(Curve(of, what, read["time"], read[known + of], read[other + of], remark) for of, what in names.items())


def tolerance_of(run: Run) -> float:
    """In proportion to the cell."""
    return max(LEAST_TOLERANCE, TOLERANCE * run.case.grid.cell / CELL)


def deviations(run: Run, curves: tuple[Curve, ...]) -> dict[str, Metric]:
    """Largest deviation of each curve, as a share of the largest excursion of its reference, and the hourglass energy."""
    found = {}
    for curve in curves:
        error = finite_elements.largest_deviation(run.history["time"], run.history[curve.column], curve.times, curve.known)
        text = f"largest deviation of {curve.what} from finite elements over their largest excursion"
        found[f"{curve.column[:-2]}_deviation"] = vanishing(error, tolerance_of(run), text)
    share = float(run.history["hourglass_energy"].max() / run.history["kinetic_energy"][0])
    found["hourglass"] = vanishing(share, HOURGLASS, "largest energy of hourglass modes over that of the motion at first")
    return found


def figure_of(run: Run, curves: tuple[Curve, ...]) -> Figure:
    """The curves above, how far they are from the reference below."""
    figure, panels = new_panels(2, len(curves), sharex=True, height_ratios=(3, 1), height=5.6, title=run.case.title)
    for both, curve, colour in zip(panels.T, curves, COLOURS, strict=False):
        known = {"finite elements": curve.known, f"finite elements, {curve.remark}": curve.other}
        beside_elements(both, run, curve.column, curve.times, known, colour, 1e3)
        both[0].set_title(curve.what)
        both[1].set_xlabel("time [ms]")
    panels[0, 0].set_ylabel("z [mm]")
    panels[1, 0].set_ylabel("deviation [%]")
    return figure
