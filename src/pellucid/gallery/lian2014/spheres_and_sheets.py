"""Metrics of a sphere that falls on a clamped sheet and of a sheet that falls on a sphere, compared with our own finite
elements, which also carry no compression in the sheet that falls."""

from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np

from pellucid.gallery.exact_curves import compared, deviations, vanishing
from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

CELL = 0.001
"""Cell size of the paper [m]."""

TOLERANCE, LEAST_TOLERANCE = 0.10, 0.05
"""Tolerances relative to the largest change: at the paper's cell size, and at half of it and below."""

HOURGLASS = 0.01
"""Largest hourglass energy, as a fraction of the initial kinetic energy."""


def tolerance_of(run: Run) -> float:
    """Return the largest allowed relative deviation of the curves of a run; it is proportional to the cell size of its grid."""
    return max(LEAST_TOLERANCE, TOLERANCE * run.case.grid.cell / CELL)


def beside_elements(run: Run, table: str, columns: Mapping[str, tuple[str, str]], known: str = "") -> dict[str, Metric]:
    """Return the metrics of `deviations`, with the arguments of that function, and of the largest hourglass energy (energy
    stored in zero-energy modes of the elements) relative to the initial kinetic energy."""
    share = float(run.history["hourglass_energy"].max() / run.history["kinetic_energy"][0])
    text = "largest hourglass energy, relative to the initial kinetic energy"
    return {
        **deviations(run, table, columns, tolerance_of(run), known),
        "hourglass": vanishing(share, HOURGLASS, text),
    }


LEAVING = 5e-5  # s, before the end: the sphere's speed then, when all but a hundredth of its impulse is spent

SPHERE_METRICS = ("membrane_deviation", "sphere_top_deviation", "hourglass", "lowest", "rebound")


def sphere_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest deviations of the heights of the middle of the sheet and the top of the sphere from
    finite elements during the run; lowest position of the sheet; rebound speed; largest hourglass energy."""
    columns = {
        "membrane_deviation": ("membrane_z", "the middle of the sheet"),
        "sphere_top_deviation": ("sphere_top_z", "the top of the sphere"),
    }
    result = beside_elements(run, "sphere_on_membrane", columns)
    found, known, tolerance = run.history, finite_elements.read("sphere_on_membrane"), tolerance_of(run)
    low, lowest = (float(curves["membrane_z"].min()) for curves in (found, known))
    result["lowest"] = compared(low, lowest, tolerance, "m", "lowest position of the middle of the sheet")
    speed, wanted = (_last_speed(curves["time"], curves["sphere_top_z"]) for curves in (found, known))
    result["rebound"] = compared(speed, wanted, tolerance, "m/s", "mean speed of the top of the sphere over the last 0.05 ms")
    return result


def _last_speed(times: np.ndarray, z: np.ndarray) -> float:
    return float((z[-1] - np.interp(times[-1] - LEAVING, times, z)) / LEAVING)


SHEET_METRICS = ("centre_deviation", "corner_deviation", "hourglass")


def sheet_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest deviations of the heights of the middle and a corner of the sheet from finite
    elements during the run, and largest hourglass energy."""
    columns = {
        "centre_deviation": ("centre_z", "the middle of the sheet"),
        "corner_deviation": ("corner_z", "a corner of the sheet"),
    }
    return beside_elements(run, "membrane_on_sphere", columns, "relaxed_")


CASES = {
    "sphere-on-membrane": SimpleNamespace(METRICS=SPHERE_METRICS, metrics=sphere_metrics),
    "membrane-on-sphere": SimpleNamespace(METRICS=SHEET_METRICS, metrics=sheet_metrics),
}
"""Metrics, captions and figures of each case, by its name without the group."""
