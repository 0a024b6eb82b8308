"""Discs that roll without slip and glide without friction down a slope, against rigid bodies."""

from pellucid.gallery.exact_curves import beside, column, compared, energy_metric
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.style import COLOURS, label, new_panels

CAPTIONS = {"rolling_discs": "How far the discs are, and how much that differs from the exact ways."}

METRICS = ("rigid", "elastic", "gliding", "gliding_speed", "energy")

SHARES = {"rigid": 2.0 / 3.0, "elastic": 2.0 / 3.0, "gliding": 1.0}
"""Of the acceleration along the slope: what rolls turns as well, with a moment of inertia of m R²/2."""
NAMES = {"rigid": "rigid, rolls", "elastic": "elastic, rolls", "gliding": "rigid, without friction"}
RADIUS = 0.4


def metrics(run: Run) -> dict[str, Metric]:
    """Where the discs are at the end, how fast the one without friction is, energy."""
    end, along = float(run.history["time"][-1]), float(run.case.gravity[0])
    # A surface of points is round to a share of (cell/R)², but a layer of half a cell gives way where it touches: the radius
    # it rolls with, and the place where it is borne, are known to a small share of cell/R. 2 % at R/8, twice for elastic ones.
    cells = run.case.grid.cell / RADIUS
    tolerances = {"rigid": 0.16 * cells, "elastic": 0.32 * cells, "gliding": 0.08 * cells}
    result = {
        name: compared(
            float(column(run, f"{name}_x")[-1]), 0.5 * share * along * end**2, tolerances[name], "m", "way along the slope"
        )
        for name, share in SHARES.items()
    }
    speed = float(column(run, "gliding_vx")[-1])
    result["gliding_speed"] = compared(speed, along * end, tolerances["gliding"], "m/s", "without friction, at the end")
    return result | {"energy": energy_metric(run, 0.005)}


def figures(run: Run) -> dict[str, Figure]:
    """Ways, and what is missing of them."""
    time, along = column(run, "time"), float(run.case.gravity[0])
    figure, (way, missing) = new_panels(1, 2, height=3.4)
    for colour, (name, share) in zip(COLOURS, SHARES.items(), strict=False):
        exact = 0.5 * share * along * time**2
        beside(way, time, column(run, f"{name}_x"), exact, NAMES[name], colour)
        missing.plot(time, 1e3 * (column(run, f"{name}_x") - exact), color=colour, label=NAMES[name])
    missing.axhline(0.0, color="#bbb", linewidth=1.0)
    label(way, "time", "way along the slope", "s", "m", legend=True)
    label(missing, "time", "way found - exact", "s", "mm")
    return {"rolling_discs": figure}
