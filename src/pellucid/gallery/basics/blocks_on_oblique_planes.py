"""Metrics and figures of blocks that slide down planes rotated about two axes: motion along the steepest descent, compared
with Coulomb's law."""

import numpy as np

from pellucid.gallery.exact_curves import beside, column, compared, energy_metric
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"blocks_on_oblique_planes": "Speeds down the slope, paths from above, and distances from the exact line."}

METRICS = ("on_plate", "on_wall", "on_plate_aside", "on_wall_aside", "energy")

FIRST, SECOND = np.radians(20.0), np.radians(25.0)  # turned back about x, then forth about y
NORMAL = np.array([np.cos(FIRST) * np.sin(SECOND), np.sin(FIRST), np.cos(FIRST) * np.cos(SECOND)])
SLOPE, FRICTION = np.arccos(NORMAL[2]), 0.3
DOWN = (np.cos(SLOPE) * NORMAL - [0.0, 0.0, 1.0]) / np.sin(SLOPE)
"""Direction of the steepest descent."""
ASIDE = np.cross(NORMAL, DOWN)
PULL = 9.81 * (np.sin(SLOPE) - FRICTION * np.cos(SLOPE))  # [m/s²]
BLOCKS = {"on_plate": "on the plate", "on_wall": "on the wall"}


def vectors(run: Run, block: str, quantity: str = "") -> Array:
    """Return the mean displacement [m] or, with quantity "v", mean velocity [m/s] of the points of a block at each row of the
    history, shape (rows, 3)."""
    return np.stack([column(run, f"{block}_{quantity}{axis}") for axis in "xyz"], axis=1)


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: for each block its speed down the slope at the end plus μ times its speed normal to the
    slope, a sum that oscillations of the block do not change; its largest distance from the line of steepest descent; error of
    the energy balance."""
    end = float(column(run, "time")[-1])
    result = {}
    for block in BLOCKS:
        # v_down + μ v_off = g (sin - μ cos) t however the block swings, as friction is μ times the force of the plane; its
        # springs take a millisecond to load
        found = float(vectors(run, block, "v")[-1] @ (DOWN + FRICTION * NORMAL))
        meaning = "at the end: speed down the slope plus μ times the speed normal to it; reference: g (sin α - μ cos α) t"
        result[block] = compared(found, PULL * end, 0.005, "m/s", meaning)
    for block in BLOCKS:
        way = vectors(run, block)
        # friction leans against the motion of each point of the foot, and these swing
        aside = float(np.max(np.abs(way @ ASIDE)))
        meaning = "largest distance from the line of steepest descent; error relative to the distance travelled"
        result[f"{block}_aside"] = Metric(aside, 0.0, aside / float(way[-1] @ DOWN), 0.002, "m", meaning)
    return result | {"energy": energy_metric(run, 0.005)}


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the speeds down the slope against time, the paths of the blocks seen from above, and
    their distances from the line of steepest descent against time."""
    time = column(run, "time")
    figure, (speed, above, aside) = new_panels(1, 3, height=3.4)
    for colour, (block, name) in zip(COLOURS, BLOCKS.items(), strict=False):
        way = vectors(run, block)
        beside(speed, time, vectors(run, block, "v") @ DOWN, PULL * time, name, colour)
        line = 0.5 * PULL * time**2
        beside(above, way[:, 0], way[:, 1], np.interp(way[:, 0], line * DOWN[0], line * DOWN[1]), name, colour)
        aside.plot(time, 1e3 * (way @ ASIDE), color=colour, label=name)
    aside.axhline(0.0, color="#bbb", linewidth=1.0)
    label(speed, "time", "speed down the slope", "s", "m/s", legend=True)
    label(above, "way along x", "way along y", "m", "m")
    label(aside, "time", "distance from the line of steepest descent", "s", "mm", legend=True)
    return {"blocks_on_oblique_planes": figure}
