"""Metrics of a lid with a cube on it above expanding gas, compared with finite elements in which lid, cube and gas are tied to
each other, as on a common grid."""

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from pellucid.gallery.exact_curves import deviations, vanishing
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

TOLERANCE, CELL = 0.05, 0.01  # of the largest change, at this cell [m]; in proportion to the cell above it
LEAK = 1e-4  # of the gas's points that may be above the lid: less than one of the quick variant's

METRICS = ("cube_z_deviation", "gas_pressure_deviation", "leak")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest deviations of the displacement of the cube and of the mean gas pressure from finite
    elements during the run, and share of the gas points that leaked through the lid."""
    columns = {
        "cube_z_deviation": ("cube_z", "the displacement of the cube"),
        "gas_pressure_deviation": ("gas_pressure", "the mean gas pressure"),
    }
    tolerance = TOLERANCE * max(1.0, run.case.grid.cell / CELL)
    result = deviations(run, "membrane_expansion", columns, tolerance, "flowing_")
    share = points_above(run) / len(run.fields("gas")["mass"])
    result["leak"] = vanishing(share, LEAK, "share of the gas points above the lid at the end")
    return result


def points_above(run: Run) -> int:
    """Return the number of gas points above the lid at the end; the lid is interpolated linearly between its points."""
    lid, gas = (np.asarray(run.fields(name)["position"]) for name in ("lid", "gas"))
    height = LinearNDInterpolator(lid[:, :2], lid[:, 2])(gas[:, :2])
    return int(np.sum(gas[:, 2] > height))
