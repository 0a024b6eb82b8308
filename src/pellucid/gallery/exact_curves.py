"""Comparison of curves of a run with exact curves, and metrics of numbers with an exact value."""

from collections.abc import Mapping

import numpy as np

from pellucid.case import load
from pellucid.references import Array, finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Axes, Run


def column(run: Run, name: str) -> Array:
    """Return a column of the history of a run (time series, a row for each output), shape (rows,)."""
    return np.asarray(run.history[name], dtype=float)


def compared(value: float, exact: float, tolerance: float, unit: str, meaning: str) -> Metric:
    """Return the metric of a computed number whose exact value is known and not 0; the error of the metric is relative to
    the exact value. tolerance: largest allowed error; unit: unit of the number; meaning: description."""
    return Metric(value, exact, abs(value / exact - 1.0), tolerance, unit, meaning)


def vanishing(value: float, tolerance: float, meaning: str, unit: str = "") -> Metric:
    """Return the metric of a computed number whose exact value is zero; the error of the metric is the magnitude of the
    number. tolerance: largest allowed error; meaning: description."""
    return Metric(value, 0.0, abs(value), tolerance, unit, meaning)


def worst_balance(run: Run, tolerance: float, meaning: str = "largest relative error of the energy balance") -> Metric:
    """Return the metric of the largest relative error of the energy balance during the run. tolerance: largest allowed
    error; meaning: description of the metric."""
    return vanishing(float(np.abs(run.history["energy_error"]).max()), tolerance, meaning)


def energy_metric(run: Run, tolerance: float) -> Metric:
    """Return the metric of the relative error of the energy balance at the end of the run; tolerance: largest allowed
    error."""
    error = abs(float(run.summary["conservation"]["energy"]))
    return vanishing(error, tolerance, "relative error of the energy balance at the end")


def deviations(
    run: Run, table: str, columns: Mapping[str, tuple[str, str]], tolerance: float, known: str = ""
) -> dict[str, Metric]:
    """Return metrics of the largest deviations of history columns from finite elements, relative to the largest change of the
    finite-element curve.

    table: name of the stored finite-element curves. columns: column of the history and its description, by name of the metric.
    tolerance: largest allowed deviation. known: prefix of the columns in the table. Raises ValueError if the case of the run
    describes another problem than the case of the gallery, for which the reference is valid.
    """
    if not finite_elements.same_problem(run.case, load(run.stored.id)):
        raise ValueError("the finite-element reference requires the bodies and materials of the gallery's case")
    reference, found = finite_elements.read(table), {}
    for name, (of, what) in columns.items():
        error = finite_elements.largest_deviation(
            run.history["time"], run.history[of], reference["time"], reference[known + of]
        )
        text = f"largest deviation of {what} from finite elements, relative to their largest change"
        found[name] = vanishing(error, tolerance, text)
    return found


def beside(axes: Axes, time: Array, found: Array, exact: Array, name: str, colour: str) -> None:
    """Draw a computed curve `found` in colour, with the label `name`, over the exact curve, which is wide and grey. Further
    computed curves on the same axes are dashed so that none hides another."""
    first = not axes.lines
    axes.plot(time, exact, color="#bbb", linewidth=4.0, zorder=1.5, label="exact" if first else None)
    axes.plot(time, found, color=colour, linewidth=1.2, linestyle="-" if first else (0, (4, 3)), label=name)
