"""Metrics of discs that roll without slip or slide without friction down a slope, compared with rigid discs."""

from pellucid.gallery.exact_curves import column, compared, energy_metric
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

METRICS = ("rigid", "elastic", "gliding", "gliding_speed", "energy")

SHARES = {"rigid": 2.0 / 3.0, "elastic": 2.0 / 3.0, "gliding": 1.0}
"""Acceleration of each disc, divided by the gravity component along the slope; a rolling disc also rotates, with a
moment of inertia of m R²/2."""
RADIUS = 0.4


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: distances of the discs along the slope at the end, speed of the frictionless disc at the end,
    error of the energy balance."""
    end, along = float(run.history["time"][-1]), float(run.case.gravity[0])
    # A surface of points is round to a share of (cell/R)², but a layer of half a cell gives way where it touches: the radius
    # it rolls with, and the place where it is borne, are known to a small share of cell/R. 2 % at R/8, twice for elastic ones.
    cells = run.case.grid.cell / RADIUS
    tolerances = {"rigid": 0.16 * cells, "elastic": 0.32 * cells, "gliding": 0.08 * cells}
    result = {
        name: compared(
            float(column(run, f"{name}_x")[-1]), 0.5 * share * along * end**2, tolerances[name], "m", "distance along the slope"
        )
        for name, share in SHARES.items()
    }
    speed = float(column(run, "gliding_vx")[-1])
    result["gliding_speed"] = compared(
        speed, along * end, tolerances["gliding"], "m/s", "speed of the frictionless disc at the end"
    )
    return result | {"energy": energy_metric(run, 0.005)}
