"""Metrics of a sphere that falls on a clamped sheet, compared with our own finite elements."""

import numpy as np

from pellucid.gallery.exact_curves import compared
from pellucid.gallery.lian2014.curves import beside_elements, tolerance_of
from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

LEAVING = 5e-5  # s, before the end: the sphere's speed then, when all but a hundredth of its impulse is spent

METRICS = ("membrane_deviation", "sphere_top_deviation", "hourglass", "lowest", "rebound")


def metrics(run: Run) -> dict[str, Metric]:
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
