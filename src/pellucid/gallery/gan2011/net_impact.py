"""The cuboid on the net against finite elements that are tied like it."""

import numpy as np

from pellucid.case import load
from pellucid.gallery.exact_curves import beside_elements, compared, vanishing
from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.style import COLOURS, new_panels

TOLERANCE, CELL = 0.03, 0.02  # of the largest excursion, at this cell [m]; in proportion to the cell above it
TURNING_TIME = 0.05  # the curve turns flatly: it is within 0.5 % of its lowest point for 7 ms to each side
TURNED = 0.15  # s, by when the cuboid is on its way back

CAPTIONS = {
    "displacement": "Cuboid and net along z against time beside finite elements: tied to the net as here, and sliding on it "
    "without friction; below, how far the run is from the tied ones.",
}

METRICS = ("cuboid_deviation", "net_deviation", "lowest", "turning_time")


def metrics(run: Run) -> dict[str, Metric]:
    """Largest deviations from the tied finite elements over the run, lowest point and its time."""
    if not finite_elements.same_problem(run.case, load("gan2011/net-impact")):
        raise ValueError("the finite elements are for the paper's net and cuboid")
    reference, times = finite_elements.read("net_impact"), run.history["time"]
    tolerance = TOLERANCE * max(1.0, run.case.grid.cell / CELL)
    result = {}
    for name, what in (("cuboid_z", "the cuboid's centre"), ("net_z", "the net's middle")):
        error = finite_elements.largest_deviation(times, run.history[name], reference["time"], reference[f"tied_{name}"])
        text = f"largest deviation of {what} from finite elements over their largest excursion"
        result[f"{name[:-2]}_deviation"] = vanishing(error, tolerance, text)
    if times[-1] >= TURNED:
        found, wanted = run.history["cuboid_z"], reference["tied_cuboid_z"]
        low, lowest = float(found.min()), float(wanted.min())
        result["lowest"] = compared(low, lowest, tolerance, "m", "lowest point of the cuboid's centre")
        turn, turning = float(times[np.argmin(found)]), float(reference["time"][np.argmin(wanted)])
        result["turning_time"] = compared(turn, turning, TURNING_TIME, "s", "when it is there")
    return result


def figures(run: Run) -> dict[str, Figure]:
    """Displacements against time beside both references."""
    return {"displacement": _displacement(run)}


def _displacement(run: Run) -> Figure:
    reference = finite_elements.read("net_impact")
    figure, grid = new_panels(2, 2, sharex=True, sharey="row", height_ratios=(3, 1), height=5.6, title=run.case.title)
    names = {"cuboid_z": "cuboid's centre", "net_z": "net's middle"}
    for panels, (name, what), colour in zip(grid.T, names.items(), COLOURS, strict=False):
        known = {f"finite elements, {how}": reference[f"{how}_{name}"] for how in ("tied", "sliding")}
        beside_elements(panels, run, name, reference["time"], known, colour)
        panels[0].set_title(what)
        panels[1].set_xlabel("time [s]")
    grid[0, 0].set_ylabel("displacement along z [m]")
    grid[1, 0].set_ylabel("deviation [%]")
    return figure
