"""Metrics and figures of blocks that slide or stick on plates rotated relative to the grid, compared with Coulomb's law."""

import numpy as np

from pellucid.gallery.basics.blocks_on_slope import FRICTION, PULL, shear_and_compression, softness
from pellucid.gallery.exact_curves import beside, column, compared, energy_metric
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"turned_blocks": "Speeds of the sliding blocks, displacements of the sticking blocks, and the bodies at the end."}

METRICS = ("east", "west", "east_aside", "west_aside", "east_sticks", "west_sticks", "energy")

PLATES = {"east": (np.radians(17.0), 1.0), "west": (np.radians(-33.0), -1.0)}
"""Angle of a plate, and the direction along it in which its blocks slide."""


def along_and_off(run: Run, block: str, quantity: str = "") -> tuple[Array, Array]:
    """Return the mean displacement [m] or, with quantity "v", mean velocity [m/s] of the points of a block at each row of the
    history: its component along the plate, and its component normal to the plate, shape (rows,) each."""
    angle, sign = PLATES[block[:4]]
    x, y = column(run, f"{block}_{quantity}x"), column(run, f"{block}_{quantity}y")
    return sign * (np.cos(angle) * x + np.sin(angle) * y), np.cos(angle) * y - np.sin(angle) * x


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: for each plate the speed of the sliding block along the plate at the end plus μ times its
    speed normal to the plate, a sum that oscillations of the block do not change; the largest displacement of this block normal
    to the plate; the largest displacement of the sticking block along the plate; error of the energy balance."""
    end, cell = float(column(run, "time")[-1]), run.case.grid.cell
    sheared, _ = shear_and_compression(run)
    result = {}
    for side in PLATES:
        # as in blocks-on-slope: exact however the block swings on the plate
        along, off = along_and_off(run, f"{side}_slides", "v")
        meaning = "at the end: speed along the plate plus μ times the speed normal to it; reference: g (sin α - μ cos α) t"
        result[side] = compared(float((along + FRICTION * off)[-1]), PULL * end, 0.005, "m/s", meaning)
        aside = float(np.max(np.abs(along_and_off(run, f"{side}_slides")[1])))
        # what the weight presses the block and the layers in contact together, no more
        meaning = "largest displacement normal to the plate; error relative to the cell size"
        result[f"{side}_aside"] = Metric(aside, 0.0, aside / cell, 0.02, "m", meaning)
        # and friction is a spring about as soft as a layer of cells
        way = float(np.max(np.abs(along_and_off(run, f"{side}_sticks")[0])))
        meaning, spare = (
            "largest displacement along the plate; reference: mean displacement by the shear of the block itself [m]",
            1e-4 * softness(run) - sheared,
        )
        result[f"{side}_sticks"] = Metric(way, sheared, abs(way - sheared), spare, "m", meaning)
    return result | {"energy": energy_metric(run, 0.005)}


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the speeds of sliding blocks and the displacements of sticking blocks against time, and
    the positions of all points at the end."""
    time = column(run, "time")
    figure, (speed, slip, place) = new_panels(1, 3, width_ratios=(1.0, 1.0, 1.6), height=3.4)
    slip.axhline(1e3 * shear_and_compression(run)[0], color="#bbb", linewidth=4.0, label="own shear, mean")
    for colour, side in zip(COLOURS, PLATES, strict=False):
        beside(speed, time, along_and_off(run, f"{side}_slides", "v")[0], PULL * time, side, colour)
        slip.plot(time, 1e3 * along_and_off(run, f"{side}_sticks")[0], color=colour, label=side)
        for what, shade in (("plate", "#999"), ("slides", colour), ("sticks", colour)):
            x, y = np.asarray(run.fields(f"{side}_{what}")["position"])[:, :2].T
            place.plot(x, y, ".", markersize=1, color=shade)
    place.set_aspect("equal")
    label(speed, "time", "speed of the sliding blocks", "s", "m/s", legend=True)
    label(slip, "time", "displacement of the sticking blocks", "s", "mm", legend=True)
    label(place, "x", "y", "m", "m")
    return {"turned_blocks": figure}
