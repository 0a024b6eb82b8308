"""Metrics of a cuboid that falls on a net, compared with finite elements in which the cuboid and the net are tied to each
other, as on a common grid."""

import numpy as np

from pellucid.gallery.exact_curves import compared, deviations
from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

TOLERANCE, CELL = 0.03, 0.02  # of the largest excursion, at this cell [m]; in proportion to the cell above it
TURNING_TIME = 0.05  # the curve turns flatly: it is within 0.5 % of its lowest point for 7 ms to each side
TURNED = 0.15  # s, by when the cuboid is on its way back

METRICS = ("cuboid_deviation", "net_deviation", "lowest", "turning_time")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest deviations of the heights of the centres of cuboid and net from finite elements
    during the run; lowest height of the cuboid's centre, and the time at which it is reached."""
    reference, times = finite_elements.read("net_impact"), run.history["time"]
    tolerance = TOLERANCE * max(1.0, run.case.grid.cell / CELL)
    columns = {
        "cuboid_deviation": ("cuboid_z", "the centre of the cuboid"),
        "net_deviation": ("net_z", "the centre of the net"),
    }
    result = deviations(run, "net_impact", columns, tolerance, "tied_")
    if times[-1] >= TURNED:
        found, wanted = run.history["cuboid_z"], reference["tied_cuboid_z"]
        low, lowest = float(found.min()), float(wanted.min())
        result["lowest"] = compared(low, lowest, tolerance, "m", "lowest point of the cuboid's centre")
        turn, turning = float(times[np.argmin(found)]), float(reference["time"][np.argmin(wanted)])
        result["turning_time"] = compared(turn, turning, TURNING_TIME, "s", "time of the lowest point of the cuboid's centre")
    return result
