"""Metrics of two colliding bars in one dimension, of which one transfers its whole velocity to the other."""

import numpy as np

from pellucid.gallery.exact_curves import column, compared, energy_metric
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

METRICS = ("force", "duration", "striker", "struck", "energy")

LENGTH, WAVE_SPEED, IMPEDANCE = 1.0, 100.0, 1e5  # [m], [m/s], ρ c A [N s/m] of a bar of 1 m²
SPEED, GAP = 0.1, 0.001  # [m/s], [m]
TOUCH, DURATION, FORCE = GAP / SPEED, 2.0 * LENGTH / WAVE_SPEED, 0.5 * IMPEDANCE * SPEED


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: mean contact force, duration of contact, speeds of both bars at the end, error of the energy
    balance."""
    time, force = column(run, "time"), column(run, "force")
    since = (time - TOUCH) / DURATION
    middle = float(np.mean(force[(since > 0.2) & (since < 0.8)]))
    lasted = float(np.sum(np.diff(time) * (force[1:] > 0.5 * FORCE)))
    striker, struck = (float(column(run, f"{name}_vx")[-1]) for name in ("striker", "struck"))
    # A front is a cell wide at first, and on its way widens as (c t h²)^(1/3), as in basics/elastic-block-drop: what comes
    # back late stays as vibration.
    front = (0.125 * (run.case.grid.cell / (2.0 * LENGTH)) ** 2) ** (1.0 / 3.0)
    return {
        "force": compared(middle, FORCE, 0.02, "N", "mean force from 20 % to 80 % of the exact contact time"),
        "duration": compared(
            lasted, DURATION, 2.0 * front, "s", "time for which the contact force exceeds half of the exact force"
        ),
        "striker": Metric(
            striker,
            0.0,
            abs(striker) / SPEED,
            2.0 * front,
            "m/s",
            "speed of the striking bar at the end; error relative to the initial speed",
        ),
        "struck": compared(struck, SPEED, 2.0 * front, "m/s", "speed of the struck bar at the end"),
        "energy": energy_metric(run, 0.01),
    }
