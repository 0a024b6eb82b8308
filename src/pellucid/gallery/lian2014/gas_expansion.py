"""Metrics and figures of a box inflated to a circle: its radius, and the loss of energy."""

from math import pi, sin
from typing import Any

import numpy as np

from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

TOLERANCE = 0.005  # of the radius
ENERGY = 0.01  # of the energy at the start; the paper loses 5 %
LAST = 0.75  # s, over which the last swing is averaged: its period
CAPTIONS = {
    "energy": "Energy loss divided by the initial energy, against time.",
}

METRICS = ("radius_0", "radius_90", "energy")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: radii of the membrane at 0 and 90 degrees, averaged over the last oscillation, and largest
    change of the total energy."""
    wanted, times, result = circle(run), run.history["time"], {}
    last = times >= times[-1] - LAST
    for name in ("radius_0", "radius_90"):
        found = float(run.history[name][last].mean())
        text = f"mean radius over the last {LAST:g} s; reference: circular membrane stretched by the gas pressure"
        result[name] = compared(found, wanted, TOLERANCE, "m", text)
    lost = float(np.abs(loss(run)).max())
    result["energy"] = vanishing(lost, ENERGY, "largest change of the total energy, relative to the initial energy")
    return result


def circle(run: Run) -> float:
    """Return the exact radius of the membrane at rest [m]: distance of the nodes from the centre, for elements that form a
    regular polygon and are stretched by the tension p r (gas pressure p, radius r)."""
    membrane: Any = run.case.body[1]
    (x, y, _), (m, n, _) = membrane.surface.box.upper, membrane.surface.box.points
    radius = 0.5 * (x + y) / (m + n - 2) / sin(pi / (4 * (m + n - 2)))
    stiffness = membrane.material.young_modulus / (1.0 - membrane.material.poisson_ratio**2) * membrane.thickness
    tension = float(run.history["gas_pressure"][-1]) * (radius - 0.5 * membrane.thickness)  # on the inner side
    return float(radius * (1.0 + tension / stiffness))


def loss(run: Run) -> np.ndarray:
    """Return the loss of total energy (kinetic, internal, strain, hourglass) since the start in each row of the history, as a
    fraction of the initial energy."""
    parts = ("kinetic_energy", "internal_energy", "strain_energy", "hourglass_energy")
    total = np.sum([run.history[part] for part in parts if part in run.history], axis=0)
    return np.asarray(1.0 - total / total[0])


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the relative loss of total energy against time."""
    figure, axes = new_panels(height=2.8, title=run.case.title)
    axes.plot(run.history["time"], 100.0 * loss(run), color=COLOURS[2])
    label(axes, "time", "loss of energy", "s", "%")
    return {"energy": figure}
