"""Metrics of a lid above expanding gas and of a net under a falling cuboid, compared with finite elements in which the bodies
are tied to each other, as on a common grid."""

from types import SimpleNamespace

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from pellucid.gallery.exact_curves import compared, deviations, vanishing
from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

LID_TOLERANCE, LID_CELL = 0.05, 0.01  # of the largest change, at this cell [m]; in proportion to the cell above it
LEAK = 1e-4  # of the gas's points that may be above the lid: less than one of the quick variant's

LID_METRICS = ("cube_z_deviation", "gas_pressure_deviation", "leak")


def lid_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest deviations of the displacement of the cube and of the mean gas pressure from finite
    elements during the run, and share of the gas points that leaked through the lid."""
    columns = {
        "cube_z_deviation": ("cube_z", "the displacement of the cube"),
        "gas_pressure_deviation": ("gas_pressure", "the mean gas pressure"),
    }
    tolerance = LID_TOLERANCE * max(1.0, run.case.grid.cell / LID_CELL)
    result = deviations(run, "membrane_expansion", columns, tolerance, "flowing_")
    share = points_above(run) / len(run.fields("gas")["mass"])
    result["leak"] = vanishing(share, LEAK, "share of the gas points above the lid at the end")
    return result


def points_above(run: Run) -> int:
    """Return the number of gas points above the lid at the end; the lid is interpolated linearly between its points."""
    lid, gas = (np.asarray(run.fields(name)["position"]) for name in ("lid", "gas"))
    height = LinearNDInterpolator(lid[:, :2], lid[:, 2])(gas[:, :2])
    return int(np.sum(gas[:, 2] > height))


NET_TOLERANCE, NET_CELL = 0.03, 0.02  # of the largest excursion, at this cell [m]; in proportion to the cell above it
TURNING_TIME = 0.05  # the curve turns flatly: it is within 0.5 % of its lowest point for 7 ms to each side
TURNED = 0.15  # s, by when the cuboid is on its way back

NET_METRICS = ("cuboid_deviation", "net_deviation", "lowest", "turning_time")


def net_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest deviations of the heights of the centres of cuboid and net from finite elements
    during the run; lowest height of the cuboid's centre, and the time at which it is reached."""
    reference, times = finite_elements.read("net_impact"), run.history["time"]
    tolerance = NET_TOLERANCE * max(1.0, run.case.grid.cell / NET_CELL)
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


CASES = {
    "membrane-expansion": SimpleNamespace(METRICS=LID_METRICS, metrics=lid_metrics),
    "net-impact": SimpleNamespace(METRICS=NET_METRICS, metrics=net_metrics),
}
"""Metrics, captions and figures of each case, by its name without the group."""
