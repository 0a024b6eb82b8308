"""Metrics of the discharge of a tank through a slot."""

import numpy as np

from pellucid.gallery.exact_curves import vanishing
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

METRICS = ("discharge", "energy")
EXACT = float(np.pi / (np.pi + 2.0))
FROM = 0.3  # time at which the water that started behind the slot has left [s]


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: discharge coefficient from the mass that leaves, and the error of the energy balance."""
    case = run.case
    floor, beside = (shape.geometry().bounds() for one in case.support if (shape := one.wall_of_fluids()) is not None)
    lower, upper = case.body[0].bounds()
    (width, depth, _), slot, gravity = upper - lower, beside[0][0] - floor[1][0], -case.gravity[1]
    time, left = (np.asarray(run.history[name], dtype=float) for name in ("time", "outflow_mass"))
    # dh/dt = -C (slot/width) sqrt(2 g h): the root of the depth falls at a constant rate
    later = time >= FROM
    root = np.sqrt(depth - left[later] / (case.body[0].material.density * width * case.grid.slice_thickness()))
    fall = -np.polyfit(time[later], root, 1)[0]
    found = float(fall * width / slot / np.sqrt(0.5 * gravity))
    lost = float(np.max(np.abs(np.asarray(run.history["energy_error"], dtype=float))))
    meaning = "outflow divided by that of Torricelli's law; reference: contraction of a free jet from a slot"
    return {
        "discharge": Metric(found, EXACT, abs(found / EXACT - 1.0), 0.08, "", meaning),
        "energy": vanishing(lost, 0.02, "largest relative error of the energy balance"),
    }
