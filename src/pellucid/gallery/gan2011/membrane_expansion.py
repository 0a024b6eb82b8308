"""The lid, its cube and the gas below against finite elements that are tied like them."""

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from pellucid.case import load
from pellucid.gallery.exact_curves import beside_elements, vanishing
from pellucid.references import finite_elements
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.style import COLOURS, label, new_panels, with_unit

TOLERANCE, CELL = 0.05, 0.01  # of the largest change, at this cell [m]; in proportion to the cell above it
LEAK = 1e-4  # of the gas's points that may be above the lid: less than one of the quick variant's

CAPTIONS = {
    "curves": "Displacement of the cube's centre and mean pressure of the gas against time beside finite elements, with a gas "
    "that flows and one that has the same pressure everywhere; below, how far the run is from the flowing one.",
}

METRICS = ("cube_z_deviation", "gas_pressure_deviation", "leak")


def metrics(run: Run) -> dict[str, Metric]:
    """Largest deviations from the finite elements over the run, and leaks."""
    if not finite_elements.same_problem(run.case, load("gan2011/membrane-expansion")):
        raise ValueError("the finite elements are for the paper's box, lid and cube")
    reference, times = finite_elements.read("membrane_expansion"), run.history["time"]
    tolerance = TOLERANCE * max(1.0, run.case.grid.cell / CELL)
    result = {}
    for name, what in (("cube_z", "cube's displacement"), ("gas_pressure", "mean pressure")):
        error = finite_elements.largest_deviation(times, run.history[name], reference["time"], reference[f"flowing_{name}"])
        text = f"largest deviation of the {what} from finite elements over its largest change"
        result[f"{name}_deviation"] = vanishing(error, tolerance, text)
    share = points_above(run) / len(run.fields("gas")["mass"])
    result["leak"] = vanishing(share, LEAK, "share of the gas's points that are above the lid at the end")
    return result


def points_above(run: Run) -> int:
    """How many points of the gas are above the lid at the end, where the lid is flat between its points."""
    lid, gas = (np.asarray(run.fields(name)["position"]) for name in ("lid", "gas"))
    height = LinearNDInterpolator(lid[:, :2], lid[:, 2])(gas[:, :2])
    return int(np.sum(gas[:, 2] > height))


def figures(run: Run) -> dict[str, Figure]:
    """Curves beside the references."""
    return {"curves": _curves(run)}


def _curves(run: Run) -> Figure:
    reference = finite_elements.read("membrane_expansion")
    figure, grid = new_panels(2, 2, sharex=True, height_ratios=(3, 1), height=5.6, title=run.case.title)
    columns = (("cube_z", "cube's displacement", "m"), ("gas_pressure", "mean pressure", "Pa"))
    for panels, (name, text, unit), colour in zip(grid.T, columns, COLOURS, strict=False):
        known = {f"finite elements, {gas} gas": reference[f"{gas}_{name}"] for gas in ("flowing", "uniform")}
        beside_elements(panels, run, name, reference["time"], known, colour)
        panels[0].set(title=text, ylabel=with_unit(text, unit))
        label(panels[1], "time", "deviation", "s", "%")
    return figure
