"""A box blown up to a circle: its radius, and the energy that is lost."""

from math import pi, sin
from typing import Any

import numpy as np

from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.instants import recorded
from pellucid.results.pictures.style import COLOURS, finish_panel, label, new_panels, panels

TOLERANCE = 0.005  # of the radius
ENERGY = 0.01  # of the energy at the start; the paper loses 5 %
LAST = 0.75  # s, over which the last swing is averaged: its period
INSTANTS = (0.0, 0.5, 6.0)  # s

CAPTIONS = {
    "radii": "Distance of the membrane from the middle at 0 and 90 degrees; dotted, the circle.",
    "energy": "Share of the energy at the start that is lost.",
    "shapes": "Membrane and gas of the quarter that is computed; dotted, the circle.",
}

METRICS = ("radius_0", "radius_90", "energy")


def metrics(run: Run) -> dict[str, Metric]:
    """Both radii, as means over the last swing, and the loss of energy."""
    wanted, times, result = circle(run), run.history["time"], {}
    last = times >= times[-1] - LAST
    for name in ("radius_0", "radius_90"):
        found = float(run.history[name][last].mean())
        text = f"mean over the last {LAST:g} s, against a circle of the membrane's length, stretched by the gas"
        result[name] = compared(found, wanted, TOLERANCE, "m", text)
    lost = float(np.abs(loss(run)).max())
    result["energy"] = vanishing(lost, ENERGY, "largest change of the total energy over that at the start")
    return result


def circle(run: Run) -> float:
    """Radius of the nodes of a regular polygon that the elements make, each stretched by the tension p r [m]."""
    membrane: Any = run.case.body[1]
    (x, y, _), (m, n, _) = membrane.surface.box.upper, membrane.surface.box.points
    radius = 0.5 * (x + y) / (m + n - 2) / sin(pi / (4 * (m + n - 2)))
    stiffness = membrane.material.young_modulus / (1.0 - membrane.material.poisson_ratio**2) * membrane.thickness
    tension = float(run.history["gas_pressure"][-1]) * (radius - 0.5 * membrane.thickness)  # on the inner side
    return float(radius * (1.0 + tension / stiffness))


def loss(run: Run) -> np.ndarray:
    """Share of the energy at the start that is lost, in each row of the history."""
    parts = ("kinetic_energy", "internal_energy", "strain_energy", "hourglass_energy")
    total = np.sum([run.history[part] for part in parts if part in run.history], axis=0)
    return np.asarray(1.0 - total / total[0])


def figures(run: Run) -> dict[str, Figure]:
    """Radii and loss of energy against time, and shapes."""
    (radii, axes), times = new_panels(height=3.2, title=run.case.title), run.history["time"]
    for name, angle, colour in (("radius_0", 0, COLOURS[0]), ("radius_90", 90, COLOURS[1])):
        axes.plot(times, run.history[name], color=colour, label=f"{angle}°")
    axes.axhline(circle(run), color="black", linestyle=":", linewidth=1)
    label(axes, "time", "radius", "s", "m", legend=True)
    energy, below = new_panels(height=2.8, title=run.case.title)
    below.plot(times, 100.0 * loss(run), color=COLOURS[2])
    label(below, "time", "loss of energy", "s", "%")
    return {"radii": radii, "energy": energy, "shapes": _shapes(run)}


def _shapes(run: Run) -> Figure:
    reached = recorded(run.times("membrane"), INSTANTS)
    figure, subplots = panels(len(reached), len(reached), height=3.2, sharey=True)
    turn = np.linspace(0.0, 0.5 * pi, 91)
    for axes, time in zip(subplots, reached, strict=True):
        for name, size in (("gas", 1.5), ("membrane", 3.0)):
            axes.plot(*run.fields(name, time)["position"][:, :2].T, ".", markersize=size, label=name)
        axes.plot(circle(run) * np.cos(turn), circle(run) * np.sin(turn), "k:", linewidth=1)
        finish_panel(axes, f"t = {time:.3g} s", "x", "y", "m")
    figure.legend(*axes.get_legend_handles_labels(), markerscale=3, loc="outside lower center", ncols=2)
    return figure
