"""The sphere on the clamped sheet against finite elements of our own."""

import numpy as np

from pellucid.case import load
from pellucid.gallery.exact_curves import compared
from pellucid.gallery.lian2014 import shapes
from pellucid.gallery.lian2014.curves import Curve, curves_of, deviations, figure_of, tolerance_of
from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.films import Animation
from pellucid.results.pictures.rendering.camera import View

LEAVING = 5e-5  # s, before the end: the sphere's speed then, when all but a hundredth of its impulse is spent
VIEW = View(-60.0, 12.0)

CAPTIONS = {
    "curves": "Middle of the sheet and top of the sphere beside finite elements with sides of 0.25 mm and, dotted, of 1 mm.",
}

METRICS = ("membrane_deviation", "sphere_top_deviation", "hourglass", "lowest", "rebound")


def metrics(run: Run) -> dict[str, Metric]:
    """Largest deviations over the run, the lowest point of the sheet and the speed of the rebound."""
    if not finite_elements.same_problem(run.case, load("lian2014/sphere-on-membrane")):
        raise ValueError("the finite elements are for the paper's sheet and sphere")
    curves = _curves()
    result = deviations(run, curves)
    tolerance = tolerance_of(run)
    times, found, known = run.history["time"], run.history, curves[0].known
    low, lowest = float(found["membrane_z"].min()), float(known.min())
    result["lowest"] = compared(low, lowest, tolerance, "m", "lowest point of the sheet's middle")
    speed = _last_speed(times, found["sphere_top_z"])
    wanted = _last_speed(curves[1].times, curves[1].known)
    result["rebound"] = compared(speed, wanted, tolerance, "m/s", "mean speed of the sphere's top over the last 0.05 ms")
    return result


def figures(run: Run) -> dict[str, Figure]:
    """Curves beside the finite elements."""
    return {"curves": figure_of(run, _curves())}


def films(run: Run) -> dict[str, Animation]:
    """Impact and rebound."""
    return {"impact": shapes.film(run, VIEW)}


def _last_speed(times: np.ndarray, z: np.ndarray) -> float:
    return float((z[-1] - np.interp(times[-1] - LEAVING, times, z)) / LEAVING)


def _curves() -> tuple[Curve, ...]:
    names = {"membrane_z": "the sheet's middle", "sphere_top_z": "the sphere's top"}
    return curves_of("sphere_on_membrane", names, "", "coarse_", "sides of 1 mm")
