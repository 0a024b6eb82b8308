"""Metrics and figures of an elastic column and of water that come to rest, or stay at rest, under their own weight."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from pellucid.gallery.exact_curves import vanishing, worst_balance
from pellucid.references import Array
from pellucid.references.solids import HeavyColumn
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

COLUMN_SLOW = 1e-3  # m/s; the column swings at up to 1.1 m/s if it is let go
# Compressed, the points are no lattice of the cells any more: what sums over points lack of integrals does not fall with the
# cell, but with the points in it
PLACE, STRESS = 0.005, 0.02
COLUMN_LEDGER = 1e-4  # of what is at stake

COLUMN_CAPTIONS = {
    "column": "Displacement and stress of every point at the end against its height in the stress-free column; speed of "
    "the fastest point against time. Near the ground, where the column is compressed most, the points no longer form a "
    "lattice of the cells: stresses oscillate about the exact ones by the quadrature error of sums over points. "
    "Dotted: tolerances."
}

COLUMN_METRICS = ("displacement", "stress", "fastest", "energy")


def column_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: displacement of the uppermost points at the end, with the largest error of the displacement
    of any point; RMS error of the stress; largest speed of a point; largest error of the energy balance."""
    column = HeavyColumn.of(run.case)
    rest, place, stress = points(run)
    exact = column.place(rest) - rest
    size = float(np.abs(exact).max())
    apart = float(np.abs(place - rest - exact).max()) / size
    top = int(np.argmax(rest))
    scale = float(np.abs(column.stress(np.zeros(1))).max())
    worst = float(np.sqrt(np.mean((stress - column.stress(rest)) ** 2))) / scale
    fastest = float(np.max(run.history["fastest"]))
    text = "displacement of the uppermost points; error: largest of any point, relative to the largest displacement"
    return {
        "displacement": Metric(float(place[top] - rest[top]), float(exact[top]), apart, PLACE, "m", text),
        "stress": vanishing(worst, STRESS, "rms error of the stress of the points, relative to the stress on the ground"),
        "fastest": vanishing(fastest, COLUMN_SLOW, "speed of the fastest point in any row of the history", "m/s"),
        "energy": worst_balance(run, COLUMN_LEDGER),
    }


def points(run: Run) -> tuple[Array, Array, Array]:
    """Return the heights of the points in the stress-free column and in the last stored frame [m] and the axial stress [Pa],
    (n,) each.

    The points are created in equal layers; sorting by height therefore identifies the layer of each point.
    """
    body = run.case.body[0]
    fields = run.fields(body.name)
    place, stress = np.asarray(fields["position"])[:, 1], np.asarray(fields["stress"])[:, 1]
    cell, (_, per_cell, _) = run.case.grid.cell, body.points_per_cell  # type: ignore[attr-defined]
    layers = round(HeavyColumn.of(run.case).height / cell * per_cell)
    order = np.argsort(place, kind="stable")
    rest = np.empty(len(place))
    rest[order] = run.case.grid.lower[1] + (np.repeat(np.arange(layers), len(place) // layers) + 0.5) * cell / per_cell
    return rest, place, stress


def column_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show displacement and axial stress of the points against their heights, and the largest speed
    of a point against time."""
    column = HeavyColumn.of(run.case)
    figure, (displacement, stress, speed) = new_panels(1, 3, width=10.0, height=3.6)
    rest, place, found = points(run)
    line = np.linspace(0.0, column.height, 200)
    for axes, values, exact in (
        (displacement, place - rest, column.place(line) - line),
        (stress, found, column.stress(line)),
    ):
        axes.plot(values, rest, ".", color=COLOURS[1], markersize=3, label="every point")
        axes.plot(exact, line, color="black", linewidth=1, label="exact")
        axes.legend()
        axes.set_title(f"t = {run.times(run.case.body[0].name)[-1]:.4g} s")
    label(displacement, "displacement", "height without stress", "m", "m")
    label(stress, "stress along the column", "height without stress", "Pa", "m")
    speed.plot(run.history["time"], run.history["fastest"])
    speed.axhline(COLUMN_SLOW, color="grey", linestyle=":", label="allowed")
    speed.set_yscale("log", nonpositive="mask")
    label(speed, "time", "speed of the fastest point", "s", "m/s", legend=True)
    return {"column": figure}


TANK_SLOW = 1e-3  # m/s, of waves that would raise the surface to 2 m/s if they were as high as the water is deep
PRESSURE_SHARE = 0.01  # of the pressure on the ground; half of it is the compression g H/(2 c²) that ρ₀ g depth leaves out
COLUMN_SHARE = 0.005  # the same beside the compressible column, which leaves nothing out
TANK_LEDGER = 1e-6  # rounding of the energies stored, over the little that moves

TANK_CAPTIONS = {
    "tank": "Left: pressure of every point at the end against its height, compared with a compressible column of the "
    "same liquid under its own weight and with ρ₀ g depth, which neglects the compression. Right: largest difference "
    "between the pressure of a point and each of these two after the start, relative to the pressure on the ground. "
    "Dotted: tolerances."
}

TANK_METRICS = ("fastest", "pressure", "column", "energy")


def tank_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest speed of a point, largest errors of the pressure relative to ρ₀ g depth and to a
    compressible column, largest error of the energy balance."""
    fastest = float(np.max(run.history["fastest"]))
    weight, squeezed = (float(np.max(errors)) for errors in pressure_errors(run))
    text = "speed of the fastest point in any row of the history"
    pressure = "largest difference of the pressure of a point from {} in any frame, relative to the pressure on the ground"
    return {
        "fastest": vanishing(fastest, TANK_SLOW, text, "m/s"),
        "pressure": vanishing(weight, PRESSURE_SHARE, pressure.format("density * g * depth")),
        "column": vanishing(squeezed, COLUMN_SHARE, pressure.format("the pressure of a compressible column")),
        "energy": worst_balance(run, TANK_LEDGER),
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


def tank_figures(run: Run) -> dict[str, Figure]:
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


CASES = {
    "hydrostatic-column": SimpleNamespace(
        METRICS=COLUMN_METRICS, CAPTIONS=COLUMN_CAPTIONS, metrics=column_metrics, figures=column_figures
    ),
    "tank-at-rest": SimpleNamespace(METRICS=TANK_METRICS, CAPTIONS=TANK_CAPTIONS, metrics=tank_metrics, figures=tank_figures),
}
"""Metrics, captions and figures of each case, by its name without the group."""
