"""Curves of a run beside exact ones, and metrics of numbers that have an exact value."""

from collections.abc import Mapping, Sequence

import numpy as np

from pellucid.references.annotations import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Axes, Run


def column(run: Run, name: str) -> Array:
    """A column of the history."""
    return np.asarray(run.history[name], dtype=float)


def compared(value: float, exact: float, tolerance: float, unit: str, meaning: str) -> Metric:
    """A number beside its exact value, by the relative error."""
    return Metric(value, exact, abs(value / exact - 1.0), tolerance, unit, meaning)


def vanishing(value: float, tolerance: float, meaning: str, unit: str = "") -> Metric:
    """A number that is zero if all is right."""
    return Metric(value, 0.0, abs(value), tolerance, unit, meaning)


def worst_balance(run: Run, tolerance: float, meaning: str = "largest relative error of the energy balance") -> Metric:
    """The error of the energy balance where it is largest."""
    return vanishing(float(np.abs(run.history["energy_error"]).max()), tolerance, meaning)


def energy_metric(run: Run, tolerance: float) -> Metric:
    """The relative error of the energy balance at the end."""
    error = abs(float(run.summary["conservation"]["energy"]))
    return vanishing(error, tolerance, "relative error of the energy balance at the end")


def beside_elements(
    panels: Sequence[Axes], run: Run, name: str, times: Array, known: Mapping[str, Array], colour: str, scale: float = 1.0
) -> None:
    """Above, a column of the history over curves of finite elements, the known ones by their names and in black; below, how far
    it is from the first of these where the run has been.

    scale: of lengths and times in the picture.
    """
    (above, below), now, found, exact = panels, run.history["time"], run.history[name], next(iter(known.values()))
    for (label, values), line in zip(known.items(), ("-", ":"), strict=True):
        above.plot(scale * times, scale * values, color="black", linewidth=1, linestyle=line, label=label)
    length = "mm" if scale == 1e3 else "m"
    above.plot(scale * now, scale * found, color=colour, label=f"cell {scale * run.case.grid.cell:g} {length}")
    above.legend()
    reached = times <= now[-1] * (1.0 + 1e-9)
    apart = (np.interp(times, now, found) - exact)[reached]
    below.plot(scale * times[reached], 100.0 * apart / np.abs(exact - exact[0]).max(), color=colour)


def beside(axes: Axes, time: Array, found: Array, exact: Array, name: str, colour: str) -> None:
    """A curve in colour over the exact one, which is wide and grey; later ones are dashed, so that none hides another."""
    first = not axes.lines
    axes.plot(time, exact, color="#bbb", linewidth=4.0, zorder=1.5, label="exact" if first else None)
    axes.plot(time, found, color=colour, linewidth=1.2, linestyle="-" if first else (0, (4, 3)), label=name)
