"""Curves of a run beside exact ones, and metrics of numbers that have an exact value."""

from collections.abc import Mapping

import numpy as np

from pellucid.case import load
from pellucid.references import finite_elements
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


def deviations(
    run: Run, table: str, columns: Mapping[str, tuple[str, str]], tolerance: float, known: str = ""
) -> dict[str, Metric]:
    """Largest deviations of columns of the history from finite elements over the largest change of these.

    columns: of each metric the column and what that is; known: how the columns of the table begin that are the reference.
    Raises ValueError for another problem than that of the gallery, for which alone the finite elements are.
    """
    if not finite_elements.same_problem(run.case, load(run.stored.id)):
        raise ValueError("the finite elements are for bodies and materials as the gallery's case has them")
    reference, found = finite_elements.read(table), {}
    for name, (of, what) in columns.items():
        error = finite_elements.largest_deviation(
            run.history["time"], run.history[of], reference["time"], reference[known + of]
        )
        text = f"largest deviation of {what} from finite elements over their largest change"
        found[name] = vanishing(error, tolerance, text)
    return found


def beside(axes: Axes, time: Array, found: Array, exact: Array, name: str, colour: str) -> None:
    """A curve in colour over the exact one, which is wide and grey; later ones are dashed, so that none hides another."""
    first = not axes.lines
    axes.plot(time, exact, color="#bbb", linewidth=4.0, zorder=1.5, label="exact" if first else None)
    axes.plot(time, found, color=colour, linewidth=1.2, linestyle="-" if first else (0, (4, 3)), label=name)
