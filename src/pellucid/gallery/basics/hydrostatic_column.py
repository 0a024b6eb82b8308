"""Metrics and figures of a column at rest under its own weight: displacements, stresses and speeds of its points, compared
with the exact solution."""

import numpy as np

from pellucid.gallery.exact_curves import vanishing, worst_balance
from pellucid.references import Array
from pellucid.references.solids import HeavyColumn
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

SLOW = 1e-3  # m/s; the column swings at up to 1.1 m/s if it is let go
# Compressed, the points are no lattice of the cells any more: what sums over points lack of integrals does not fall with the
# cell, but with the points in it
PLACE, STRESS = 0.005, 0.02
LEDGER = 1e-4  # of what is at stake

CAPTIONS = {
    "column": "Displacement and stress of every point at the end against its height in the stress-free column; speed of "
    "the fastest point against time. Near the ground, where the column is compressed most, the points no longer form a "
    "lattice of the cells: stresses oscillate about the exact ones by the quadrature error of sums over points. "
    "Dotted: tolerances."
}

METRICS = ("displacement", "stress", "fastest", "energy")


def metrics(run: Run) -> dict[str, Metric]:
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
        "fastest": vanishing(fastest, SLOW, "speed of the fastest point in any row of the history", "m/s"),
        "energy": worst_balance(run, LEDGER),
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


def figures(run: Run) -> dict[str, Figure]:
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
    speed.axhline(SLOW, color="grey", linestyle=":", label="allowed")
    speed.set_yscale("log", nonpositive="mask")
    label(speed, "time", "speed of the fastest point", "s", "m/s", legend=True)
    return {"column": figure}
