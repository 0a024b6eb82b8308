"""Metrics of the discharge of a tank through a slot."""

import numpy as np

from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

METRICS = ("discharge", "energy")
AREA, DEPTH, SLOT, GRAVITY, DENSITY = 1.0, 0.5, 0.1, 9.81, 1000.0  # of the case: per metre of thickness, in SI units
EXACT = np.pi / (np.pi + 2.0)
FROM = 0.3  # time at which the water that started behind the slot has left [s]


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: discharge coefficient from the mass that leaves, and the error of the energy balance."""
    time, left = (np.asarray(run.history[name], dtype=float) for name in ("time", "outflow_mass"))
    # dh/dt = -C a/A sqrt(2 g h): the root of the depth falls at a constant rate
    later = time >= FROM
    root = np.sqrt(DEPTH - left[later] / (DENSITY * AREA))
    fall = -np.polyfit(time[later], root, 1)[0]
    found = float(fall * AREA / SLOT / np.sqrt(0.5 * GRAVITY))
    lost = float(np.max(np.abs(np.asarray(run.history["energy_error"], dtype=float))))
    meaning = "outflow divided by that of Torricelli's law; reference: contraction of a free jet from a slot"
    return {
        "discharge": Metric(found, float(EXACT), abs(found / EXACT - 1.0), 0.08, "", meaning),
        "energy": Metric(lost, 0.0, lost, 0.02, "", "largest relative error of the energy balance"),
    }
