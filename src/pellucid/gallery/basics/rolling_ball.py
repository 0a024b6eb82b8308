"""Metrics of a ball that rolls down a plate in space, compared with a rigid ball."""

import numpy as np

from pellucid.gallery.exact_curves import column, compared, energy_metric
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

METRICS = ("way", "speed", "aside", "energy")

SHARE = 5.0 / 7.0
"""Acceleration of a rolling ball, divided by the gravity component along the slope; its moment of inertia is 2/5 m R²."""


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: distance and speed along the slope at the end, largest lateral deviation of the ball, error
    of the energy balance."""
    end, pull = float(run.history["time"][-1]), SHARE * float(run.case.gravity[0])
    way, aside = float(column(run, "ball_x")[-1]), float(np.max(np.abs(column(run, "ball_y"))))
    # four cells to the radius: as far as a disc of eight may err, twice over
    return {
        "way": compared(way, 0.5 * pull * end**2, 0.04, "m", "distance along the slope at the end"),
        "speed": compared(float(column(run, "ball_vx")[-1]), pull * end, 0.04, "m/s", "speed along the slope at the end"),
        "aside": Metric(
            aside, 0.0, aside / way, 0.002, "m", "largest lateral deviation; error relative to the distance travelled"
        ),
        "energy": energy_metric(run, 0.005),
    }
