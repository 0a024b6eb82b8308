"""Metrics of soft balls on a slope, solid and inflated, rolling and sliding, compared with rigid balls."""

from typing import Any

import numpy as np

from pellucid.gallery.exact_curves import column, compared, energy_metric
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

SHARES = {"solid_rolls": 5.0 / 7.0, "hollow_rolls": 3.0 / 5.0, "solid_glides": 1.0, "hollow_glides": 1.0}
"""Acceleration of each ball, divided by the gravity component along the slope. The moments of inertia of the solid and
the hollow ball are 2/5 and 2/3 m R²; sliding balls do not rotate."""
ROLLS, GLIDES, ASIDE, ENERGY = 0.02, 0.005, 0.002, 0.005
LAST = 0.1  # s at the end, over which the speed is taken: a ball of flat faces rolls on unevenly

METRICS = (*(f"{name}_{what}" for name in SHARES for what in ("way", "speed")), "aside", "energy")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: distance along the slope and speed of each ball at the end, largest lateral deviation of any
    ball, error of the energy balance."""
    time = column(run, "time")
    end, result, aside = float(time[-1]), {}, 0.0
    for name, share in SHARES.items():
        way, tolerance = column(run, f"{name}_way"), ROLLS if "rolls" in name else GLIDES
        exact = share * exact_way(run, time)
        result[f"{name}_way"] = compared(
            float(way[-1]), float(exact[-1]), tolerance, "m", "distance along the slope at the end"
        )
        found, reference = ((way[-1] - np.interp(end - LAST, time, way)) / LAST for way in (way, exact))
        text = f"mean speed along the slope over the last {LAST:g} s"
        result[f"{name}_speed"] = compared(float(found), float(reference), tolerance, "m/s", text)
        aside = max(aside, float(np.abs(column(run, f"{name}_aside")).max() / way[-1]))
    text = "largest lateral deviation, relative to the distance travelled: the meshes are not exactly symmetric"
    return {**result, "aside": Metric(aside, 0.0, aside, ASIDE, "", text), "energy": energy_metric(run, ENERGY)}


def exact_way(run: Run, time: np.ndarray) -> np.ndarray:
    """Return the distance that a frictionless body slides down the slope [m] at times [s]; as in the case, gravity first
    increases linearly."""
    case: Any = run.case
    grown, pull = float(case.gravity_amplitude.times[1]), float(case.gravity[0])
    late = np.maximum(time - grown, 0.0)
    early = np.minimum(time, grown)
    return np.asarray(pull * (early**3 / (6.0 * grown) + 0.5 * grown * late + 0.5 * late**2))
