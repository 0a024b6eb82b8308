"""Metrics and figures of water that should stay at rest: speeds of its points, and their pressure compared with the
hydrostatic pressure."""

from typing import Any

import numpy as np

from pellucid.gallery.exact_curves import vanishing, worst_balance
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

SLOW = 1e-3  # m/s, of waves that would raise the surface to 2 m/s if they were as high as the water is deep
PRESSURE_SHARE = 0.01  # of the pressure on the ground; half of it is the compression g H/(2 c²) that ρ₀ g depth leaves out
COLUMN_SHARE = 0.005  # the same beside the compressible column, which leaves nothing out
LEDGER = 1e-6  # rounding of the energies stored, over the little that moves

CAPTIONS = {
    "tank": "Left: pressure of every point at the end against its height, compared with a compressible column of the "
    "same liquid under its own weight and with ρ₀ g depth, which neglects the compression. Right: largest difference "
    "between the pressure of a point and each of these two after the start, relative to the pressure on the ground. "
    "Dotted: tolerances."
}

METRICS = ("fastest", "pressure", "column", "energy")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest speed of a point, largest errors of the pressure relative to ρ₀ g depth and to a
    compressible column, largest error of the energy balance."""
    fastest = float(np.max(run.history["fastest"]))
    weight, squeezed = (float(np.max(errors)) for errors in pressure_errors(run))
    text = "speed of the fastest point in any row of the history"
    pressure = "largest difference of the pressure of a point from {} in any frame, relative to the pressure on the ground"
    return {
        "fastest": vanishing(fastest, SLOW, text, "m/s"),
        "pressure": vanishing(weight, PRESSURE_SHARE, pressure.format("density * g * depth")),
        "column": vanishing(squeezed, COLUMN_SHARE, pressure.format("the pressure of a compressible column")),
        "energy": worst_balance(run, LEDGER),
    }


def pressure_errors(run: Run) -> tuple[Array, Array]:
    """Return the largest errors of the pressure of a point in each stored frame, divided by the pressure on the ground, shape
    (frames,): relative to ρ₀ g depth, and relative to a column of the same compressible liquid."""
    water: Any = run.case.body[0]
    errors = []
    for time in run.times(water.name):
        points = run.fields(water.name, float(time))
        depth = water.hydrostatic.level - np.asarray(points["position"])[:, 1]
        found = np.asarray(points["pressure"])
        errors.append([np.abs(found - exact).max() for exact in (simple(run, depth), column(run, depth))])
    ground = simple(run, np.array([water.hydrostatic.level - run.case.grid.lower[1]]))
    worst = np.array(errors) / ground
    return worst[:, 0], worst[:, 1]


def simple(run: Run, depth: Array) -> Array:
    """Return the hydrostatic pressure of a liquid of constant density, ρ₀ g depth [Pa], at depths [m]."""
    return np.asarray(run.case.body[0].material.density * -run.case.gravity[1] * depth)


def column(run: Run, depth: Array) -> Array:
    """Return the hydrostatic pressure of a liquid with Tait's equation of state [Pa] at depths [m]. From dp = ρ g ds with the
    depth s, the squared speed of sound c² increases by (n-1) g s."""
    material: Any = run.case.body[0].material
    eos, n = material.eos, material.eos.exponent
    growth = 1.0 - (n - 1.0) * run.case.gravity[1] * depth / eos.sound_speed**2  # of c², from its value at the level
    stiffness = material.density * eos.sound_speed**2 / n
    return np.asarray(material.pressure + stiffness * (growth ** (n / (n - 1.0)) - 1.0))


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the pressure of the points against their heights at the end, and the largest relative
    error of the pressure against time."""
    water: Any = run.case.body[0]
    figure, (profile, errors) = new_panels(1, 2, width=10.0, height=3.6)
    name, points = water.name, run.fields(water.name)
    height = np.asarray(points["position"])[:, 1]
    line = np.linspace(run.case.grid.lower[1], water.hydrostatic.level, 200)
    depth = water.hydrostatic.level - line
    profile.plot(np.asarray(points["pressure"]), height, ".", color=COLOURS[1], markersize=3, label="every point")
    profile.plot(column(run, depth), line, color="black", linewidth=1, label="compressible column")
    profile.plot(simple(run, depth), line, color="grey", linewidth=1, linestyle="--", label="ρ₀ g depth")
    label(profile, "pressure", "height", "Pa", "m", title=f"t = {run.times(name)[-1]:.4g} s", legend=True)
    times = np.asarray(run.times(name), dtype=float)
    references = (("ρ₀ g depth", PRESSURE_SHARE), ("compressible column", COLUMN_SHARE))
    for values, (text, allowed), colour in zip(pressure_errors(run), references, COLOURS, strict=False):
        errors.plot(times[1:], 100.0 * values[1:], color=colour, label=f"difference from {text}")
        errors.axhline(100.0 * allowed, color=colour, linestyle=":", label="allowed")
    errors.set_yscale("log")
    label(errors, "time", "largest error of the pressure", "s", "%", legend=True)
    return {"tank": figure}
