"""Metrics of a bag of water: no leaks, contact with the floor, roundness, and the energy needed to flatten it."""

from typing import Any

import numpy as np

from pellucid.gallery.exact_curves import vanishing
from pellucid.geometry.meshes.enclosure import enclosed_volume, heights
from pellucid.references.membranes import least_energy
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

CLOSE = 0.25
"""Largest gap between bodies in contact, in cells."""
ROUND = 0.05  # of the half width
SLACK = 0.02  # of the least energy, for the cones it was computed with

METRICS = ("leak", "space", "touch", "roundness", "skin_energy", "balance")


def metrics(run: Run) -> dict[str, Metric]:
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
