"""Metrics and pictures of piezo-ICSI, in which a pipette that oscillates sideways pierces the zona (the shell of an oocyte):
position of the failure of the zona, leaks of the cytoplasm, and energy balance."""

from collections.abc import Callable
from functools import partial

import numpy as np

from pellucid.case import load
from pellucid.gallery.exact_curves import vanishing, worst_balance
from pellucid.gallery.gan2011 import piezo_pictures
from pellucid.gallery.gan2011.piezo_pictures import films
from pellucid.geometry.meshes.enclosure import inside
from pellucid.results.metrics import Metric
from pellucid.results.pictures.films import recorded
from pellucid.results.pictures.style import Figure, Run, label, new_panels

__all__ = ["CAPTIONS", "figures", "films", "metrics"]

PAPER_POINTS = 175_522
FIRST = piezo_pictures.INSTANTS[0]
MICRO = 1e6

CAPTIONS = piezo_pictures.CAPTIONS | {
    "failure": "The side of the zona that faces the pipette, in the initial configuration. Colours: recorded instant by "
    "which a point had failed.",
}

METRICS = ("tip_path", "leak", "facing", "energy_error", "points")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest distance of the pipette's tip from its prescribed path; largest number of cytoplasm
    points outside the zona; share of the points of the zona failed after 28 µs that are on the half that faces the pipette;
    largest error of the energy balance; number of material points, compared with the paper."""
    history = run.history
    tip = next(motion for motion in run.case.motion if motion.name == "tip")
    signal = tip.displacement.y
    if signal is None:
        raise ValueError("motion `tip` must prescribe a displacement along y, which the metrics of this case require")
    path = signal.function()
    wanted = np.array([path(time) for time in history["time"]])
    swing = float(np.abs(wanted).max())
    off = float(np.abs(history["tip_y"] - wanted).max()) / swing
    zona = run.triangles("zona")
    escaped = float(max(_escaped(run, float(time), zona) for time in run.times("zona")))
    facing = _facing(run, float(recorded(run.times("zona"), [FIRST])[0]))
    result = {
        # rounding of places of 100 um under displacements of 10 um
        "tip_path": vanishing(off, 1e-9, "largest distance of the tip from its prescribed path, relative to its amplitude"),
        "leak": vanishing(escaped, 0.5, "largest number of cytoplasm points outside the zona at any recorded instant"),
        # a failure that knew no place would give a half
        "facing": Metric(
            facing, 1.0, 1.0 - facing, 0.15, "", "share of the points failed at 28 us that are on the half facing the pipette"
        ),
        # of first order in the step; with five times the paper's it is 0.9 % just after the pipette has set off
        "energy_error": worst_balance(run, 0.05),
    }
    if run.case.grid == load("gan2011/piezo-icsi").grid:
        points = sum(len(run.fields(body.name, 0.0)["mass"]) for body in run.case.body)
        error = abs(points / PAPER_POINTS - 1.0)
        result["points"] = Metric(
            float(points), float(PAPER_POINTS), error, 0.02, "", "number of material points; reference: the paper"
        )
    return result


def _escaped(run: Run, time: float, zona: np.ndarray) -> int:
    """Return the number of points of the cytoplasm outside the zona in the stored frame nearest to a time [s]; zona: triangles
    of its surface as point numbers, shape (m, 3)."""
    surface, inner = (run.fields(body, time, ("position",))["position"] for body in ("zona", "cytoplasm"))
    return int(np.count_nonzero(~inside(inner, surface, zona)))


def _facing(run: Run, time: float) -> float:
    """Return the share of the failed points of the zona that were initially on the side of the pipette, in the stored frame
    nearest to a time [s]; NaN if no point failed."""
    start = run.fields("zona", 0.0, ("position",))["position"][:, 0]
    failed = run.fields("zona", time, ("failed",))["failed"] > 0
    return float(np.mean(start[failed] > start.mean())) if failed.any() else float("nan")


def figures(run: Run) -> "dict[str, Callable[[], Figure]]":
    """Return figures by name, as functions that draw them: the oocyte as a whole, the oocyte without its upper half, and the
    time and place of the failure of the zona."""
    return piezo_pictures.figures(run) | {"failure": partial(_failure, run)}


def _failure(run: Run) -> Figure:
    """Return a figure of the initial positions of the points of the zona that face the pipette, coloured by the time of
    failure."""
    times = run.times("zona")
    start = run.fields("zona", 0.0)["position"]
    first = np.full(len(start), np.nan)
    for time in times[::-1]:
        first[run.fields("zona", float(time), ("failed",))["failed"] > 0] = MICRO * time
    figure, axes = new_panels(width=6.5, height=5.0)
    middle = start.mean(axis=0)
    shown = start[:, 0] > middle[0]
    across = MICRO * (start - middle)[shown]
    size = 2.0 if len(start) > 10_000 else 12.0
    axes.scatter(across[:, 1], across[:, 2], s=size, color="#d8e6e6", linewidths=0)
    failed = np.isfinite(first[shown])
    dots = axes.scatter(across[failed, 1], across[failed, 2], s=size, c=first[shown][failed], cmap="plasma_r", linewidths=0)
    bar = figure.colorbar(dots, ax=axes, shrink=0.8)
    bar.set_label("failed by [µs]")
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    axes.plot(5.0 * np.cos(angle), 5.0 * np.sin(angle), color="black", linewidth=1)
    axes.annotate("pipette", (0.0, 5.0), (12.0, 40.0), arrowprops={"arrowstyle": "-", "linewidth": 0.8})
    axes.set_aspect("equal")
    label(axes, "y", "z", "µm", "µm")
    return figure
