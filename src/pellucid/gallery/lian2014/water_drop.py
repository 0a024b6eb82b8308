"""Metrics and figures of a drop on a clamped sheet: no water penetrates the sheet, and the drop spreads and breaks.

A quarter, x > 0 and y > 0, is computed.
"""

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from pellucid.gallery.exact_curves import vanishing, worst_balance
from pellucid.results.metrics import Metric
from pellucid.results.pictures.films import recorded
from pellucid.results.pictures.style import COLOURS, Figure, Run, finish_panel, panels

Array = np.ndarray

ROUNDING = 1e-12
ENERGY = 0.01  # of the largest energy that moved; half of what the program warns at
SPREAD = 2.5  # times its first radius: on a thousandth of the stiffness it is 2.2
BROKEN = 0.05  # of the mass: on a thousandth of the stiffness it is nothing
SHORT = 1e-9  # by which rounding may fall short of a bound
IMAGES = np.array([(1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, 1)])
"""Signs of x, y, z of the four quarters."""
PLANS = (6e-4, 9e-4, 1.1e-3, 1.3e-3)

CAPTIONS = {
    "pieces": "The water from above: the largest connected piece, and separated pieces.",
}

METRICS = ("leak", "momentum", "energy", "spread", "broken")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest share of the water below the sheet, errors of the momentum and energy balances,
    radius of the drop relative to its initial radius, share of the mass that broke off."""
    times = run.times("drop")
    end, result = float(times[-1]), {}
    worst = max(below(run, float(time)) for time in times)
    least = 0.5 / len(run.fields("drop")["mass"])
    result["leak"] = vanishing(worst, least, "largest share of the drop's points below the sheet in any frame")
    momentum = run.summary["conservation"]["momentum"]
    text = "error of the momentum balance, relative to the largest sum of mass times speed"
    result["momentum"] = vanishing(momentum, ROUNDING, text)
    result["energy"] = worst_balance(
        run, ENERGY, "largest error of the energy balance, relative to the largest energy exchanged"
    )
    grown = radius(run, end) / radius(run, 0.0)
    text = "radius of the drop divided by the initial radius; error: shortfall from the reference"
    result["spread"] = Metric(grown, SPREAD, max(0.0, 1.0 - grown / SPREAD), SHORT, "", text)
    apart = broken(run, end)
    text = "share of the drop's mass more than a cell from its main part; error: shortfall from the reference"
    result["broken"] = Metric(apart, BROKEN, max(0.0, BROKEN - apart), SHORT, "", text)
    return result


def below(run: Run, time: float) -> float:
    """Return the share of the drop's points below or outside the sheet, in the stored frame nearest to a time [s].

    The sheet is interpolated linearly between its nodes.
    """
    sheet, drop = (run.fields(name, time)["position"] for name in ("sheet", "drop"))
    height = LinearNDInterpolator(sheet[:, :2], sheet[:, 2])(drop[:, :2])  # nan beside the sheet
    return float(np.mean(~(drop[:, 2] >= height)))


def radius(run: Run, time: float) -> float:
    """Return the largest distance of the drop's points from the axis [m], in the stored frame nearest to a time [s]."""
    x, y, _ = run.fields("drop", time)["position"].T
    return float(np.hypot(x, y).max())


def broken(run: Run, time: float) -> float:
    """Return the share of the drop's mass outside its heaviest piece, in the stored frame nearest to a time [s]."""
    drop = run.fields("drop", time)
    return float(1.0 - drop["mass"][in_largest(run, time)].sum() / drop["mass"].sum())


def in_largest(run: Run, time: float) -> Array:
    """Return a mask of the points in the heaviest piece of the drop, shape (n,). Points up to a cell apart are connected."""
    drop = run.fields("drop", time)
    whole = np.concatenate([drop["position"] * image for image in IMAGES])
    tree = cKDTree(whole)
    _, piece = connected_components(tree.sparse_distance_matrix(tree, run.case.grid.cell), directed=False)
    mass = np.bincount(piece, np.tile(drop["mass"], len(IMAGES)))
    return np.asarray(piece[: len(drop["mass"])] == np.argmax(mass))


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the water from above at several times, with the pieces that broke off in another
    colour."""
    reached = recorded(run.times("drop"), PLANS)
    figure, subplots = panels(len(reached), len(reached), height=3.5, sharex=True, sharey=True)
    for axes, time in zip(subplots, reached, strict=True):
        place, joined = 1e3 * run.fields("drop", time)["position"], in_largest(run, time)
        for shown, colour, what in ((joined, COLOURS[0], "largest piece"), (~joined, COLOURS[1], "broken off")):
            x, y, _ = np.concatenate([place[shown] * image for image in IMAGES]).T
            axes.plot(x, y, ".", markersize=1.5, color=colour, label=what)
        finish_panel(axes, f"t = {1e3 * time:.2f} ms", "x", "y", "mm")
    figure.legend(*subplots[0].get_legend_handles_labels(), markerscale=5, loc="outside lower center", ncols=2)
    return {"pieces": figure}
