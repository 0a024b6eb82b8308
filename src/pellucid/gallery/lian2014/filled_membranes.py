"""Metrics and figures of membranes with what they hold: a box that gas inflates to a circle, and a bag of water on a floor."""

from math import pi, sin
from types import SimpleNamespace
from typing import Any

import numpy as np

from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.geometry.meshes.enclosure import enclosed_volume, heights
from pellucid.references.membranes import least_energy
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

TOLERANCE = 0.005  # of the radius
ENERGY = 0.01  # of the energy at the start; the paper loses 5 %
LAST = 0.75  # s, over which the last swing is averaged: its period
GAS_CAPTIONS = {
    "energy": "Energy loss divided by the initial energy, against time.",
}

GAS_METRICS = ("radius_0", "radius_90", "energy")


def gas_metrics(run: Run) -> dict[str, Metric]:
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


def gas_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the relative loss of total energy against time."""
    figure, axes = new_panels(height=2.8, title=run.case.title)
    axes.plot(run.history["time"], 100.0 * loss(run), color=COLOURS[2])
    label(axes, "time", "loss of energy", "s", "%")
    return {"energy": figure}


CLOSE = 0.25
"""Largest gap between bodies in contact, in cells."""
ROUND = 0.05  # of the half width
SLACK = 0.02  # of the least energy, for the cones it was computed with

WATER_METRICS = ("leak", "space", "touch", "roundness", "skin_energy", "balance")


def water_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest share of the water outside the skin; largest mean gap between skin and water;
    distance of the bag from the floor when the contact force starts; at the largest width of the bag, the spread of its half
    widths, and the strain energy of the skin, compared with the minimum energy of a bag of this width and with the initial
    kinetic energy."""
    history, cell = run.history, run.case.grid.cell
    skin_case: Any = run.case.body[0]
    law = skin_case.material
    times = run.times("skin")
    outside, space = zip(*(_fit(run, float(time)) for time in times), strict=True)
    result = {}
    leak = max(outside)
    text = f"largest share of the water points more than {CLOSE:g} cells outside the skin"
    result["leak"] = vanishing(leak, 1e-6, text)
    widest_space = max(map(abs, space))
    text = "largest mean gap of skin and water, in cells: (volume of the bag - volume of the water) / area"
    result["space"] = vanishing(widest_space, CLOSE, text)
    first = int(np.argmax(np.abs(history["floor_force"]) > 0.0))
    gap = (float(history["bottom_z"][first]) - 0.5 * skin_case.thickness) / cell
    text = "distance of the bag from the floor when the contact force starts, in cells; at most one history row late"
    result["touch"] = vanishing(gap, CLOSE, text)
    wide = float(times[np.argmax([_half_width(run, float(time)) for time in times])])
    skin = run.fields("skin", wide)["position"]
    directions = np.linspace(0.0, 0.5 * np.pi, 19)
    widths = np.array([(skin[:, 0] * np.cos(a) + skin[:, 1] * np.sin(a)).max() for a in directions])
    spread = float((widths.max() - widths.min()) / widths.mean())
    result["roundness"] = vanishing(spread, ROUND, "spread of the half widths at the largest width, relative to their mean")
    stored = float(np.interp(wide, history["time"], history["strain_energy"]))
    least = least_energy(
        skin_case.surface.sphere.radius, float(widths.mean()), skin_case.thickness, law.young_modulus, law.poisson_ratio
    )
    text = "energy of the skin at the largest width; reference: least energy of a bag as wide; error: shortfall"
    result["skin_energy"] = Metric(stored, least, max(0.0, 1.0 - stored / least), SLACK, "J", text)
    start = float(history["kinetic_energy"][0])
    text = "energy of the skin at the largest width divided by the initial kinetic energy; error: excess over 1"
    result["balance"] = Metric(stored / start, 1.0, max(0.0, stored / start - 1.0), SLACK, "", text)
    return result


def _fit(run: Run, time: float) -> tuple[float, float]:
    """Return the share of the water points outside the skin by more than 0.25 cells (`CLOSE`), and the mean gap between skin
    and water in cells, in the stored frame nearest to a time [s]."""
    skin, water, triangles = run.fields("skin", time)["position"], run.fields("water", time), run.triangles("skin")
    height = heights(water["position"], skin, triangles)
    corners = skin[triangles]
    area = 0.5 * float(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum())
    cell = run.case.grid.cell
    room = enclosed_volume(skin, triangles) - float(np.sum(water["mass"] / water["density"]))
    return float(np.mean(height > CLOSE * cell)), room / area / cell


def _half_width(run: Run, time: float) -> float:
    x = run.fields("skin", time)["position"][:, :2]
    return float(np.linalg.norm(x, axis=1).max())


CASES = {
    "gas-expansion": SimpleNamespace(METRICS=GAS_METRICS, CAPTIONS=GAS_CAPTIONS, metrics=gas_metrics, figures=gas_figures),
    "york-bubble": SimpleNamespace(METRICS=WATER_METRICS, metrics=water_metrics),
}
"""Metrics, captions and figures of each case, by its name without the group."""
