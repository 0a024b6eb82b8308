"""Metrics and figures of blocks that slide, stick and rest on slopes, on plates rotated relative to the grid and on oblique
planes, compared with Coulomb's law."""

from types import SimpleNamespace

import numpy as np

from pellucid.gallery.exact_curves import beside, column, compared, energy_metric
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

SLOPE_METRICS = ("slides", "wall_slides", "sticks", "wall_sticks", "sits", "rests", "energy")

ALONG, ACROSS = 9.81 * 0.5, 9.81 * np.sqrt(0.75)  # [m/s²]
FRICTION, HEIGHT, DENSITY, YOUNG = 0.3, 0.25, 2000.0, 1e7
PULL = ALONG - FRICTION * ACROSS


def softness(run: Run) -> float:
    """Return 10 MPa divided by Young's modulus of the blocks (no unit); elastic displacements and their tolerances scale with
    this ratio."""
    block = run.case.model_dump()["body"][1]
    return YOUNG / float(block["material"]["young_modulus"])


def shear_and_compression(run: Run) -> tuple[float, float]:
    """Return the mean displacements of a block under its own weight by shear and by compression, ρ g H²/3G and ρ g H²/3M
    [m], with the height H, the shear modulus G and the longitudinal modulus M."""
    weight = DENSITY * HEIGHT**2 * softness(run) / (3.0 * YOUNG)
    return weight * ALONG * 2.6, weight * 9.81 * 0.52 / 0.7  # ν = 0.3


def slope_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: for each sliding block its speed along the slope at the end plus μ times its speed normal to
    the slope; largest displacements of the sticking blocks along the slope; largest rise of the resting block above its start,
    and its largest speed in the second half of the run; error of the energy balance."""
    time = column(run, "time")
    end, (sheared, pressed) = float(time[-1]), shear_and_compression(run)
    result = {}
    for name in ("slides", "wall_slides"):
        # With the impulse N of what bears it m v_y = N - m g cos 30 t and m v_x = m g sin 30 t - μ N. So v_x + μ v_y is
        # g (sin 30 - μ cos 30) t, however the block swings. The springs of friction take up to two milliseconds to load.
        found = float(column(run, f"{name}_vx")[-1] + FRICTION * column(run, f"{name}_vy")[-1])
        meaning = "at the end: speed along the slope plus μ times the speed normal to it; reference: g (sin α - μ cos α) t"
        result[name] = compared(found, PULL * end, 0.0075, "m/s", meaning)
    for name in ("sticks", "wall_sticks"):
        way = float(np.max(np.abs(column(run, f"{name}_x"))))
        # friction is a spring, about as soft as a layer of cells of the block: with it the way stays below 0.1 mm at 10 MPa
        meaning = "largest displacement along the slope; reference: mean displacement by the shear of the block itself [m]"
        result[name] = Metric(way, sheared, abs(way - sheared), 1e-4 * softness(run) - sheared, "m", meaning)
    height, speed = column(run, "sits_y"), np.abs(column(run, "sits_vy"))
    rise, half = max(0.0, float(np.max(height))), len(time) // 2
    meaning = "largest rise of the block above its start; error relative to its compression by its weight"
    result["sits"] = Metric(rise, 0.0, rise / pressed, 0.3, "m", meaning)
    later, first = float(np.max(speed[half:])), float(np.max(speed[:half]))
    meaning = "largest speed in the second half of the run; reference: in the first half; error: relative excess"
    result["rests"] = Metric(later, first, max(0.0, later / first - 1.0), 0.05, "m/s", meaning)
    return result | {"energy": energy_metric(run, 0.005)}


TURNED_CAPTIONS = {
    "turned_blocks": "Speeds of the sliding blocks, displacements of the sticking blocks, and the bodies at the end."
}

TURNED_METRICS = ("east", "west", "east_aside", "west_aside", "east_sticks", "west_sticks", "energy")

PLATES = {"east": (np.radians(17.0), 1.0), "west": (np.radians(-33.0), -1.0)}
"""Angle of a plate, and the direction along it in which its blocks slide."""


def along_and_off(run: Run, block: str, quantity: str = "") -> tuple[Array, Array]:
    """Return the mean displacement [m] or, with quantity "v", mean velocity [m/s] of the points of a block at each row of the
    history: its component along the plate, and its component normal to the plate, shape (rows,) each."""
    angle, sign = PLATES[block[:4]]
    x, y = column(run, f"{block}_{quantity}x"), column(run, f"{block}_{quantity}y")
    return sign * (np.cos(angle) * x + np.sin(angle) * y), np.cos(angle) * y - np.sin(angle) * x


def turned_metrics(run: Run) -> dict[str, Metric]:
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


def turned_figures(run: Run) -> dict[str, Figure]:
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


OBLIQUE_CAPTIONS = {"blocks_on_oblique_planes": "Speeds down the slope, paths from above, and distances from the exact line."}

OBLIQUE_METRICS = ("on_plate", "on_wall", "on_plate_aside", "on_wall_aside", "energy")

FIRST, SECOND = np.radians(20.0), np.radians(25.0)  # turned back about x, then forth about y
NORMAL = np.array([np.cos(FIRST) * np.sin(SECOND), np.sin(FIRST), np.cos(FIRST) * np.cos(SECOND)])
SLOPE, OBLIQUE_FRICTION = np.arccos(NORMAL[2]), 0.3
DOWN = (np.cos(SLOPE) * NORMAL - [0.0, 0.0, 1.0]) / np.sin(SLOPE)
"""Direction of the steepest descent."""
ASIDE = np.cross(NORMAL, DOWN)
OBLIQUE_PULL = 9.81 * (np.sin(SLOPE) - OBLIQUE_FRICTION * np.cos(SLOPE))  # [m/s²]
BLOCKS = {"on_plate": "on the plate", "on_wall": "on the wall"}


def vectors(run: Run, block: str, quantity: str = "") -> Array:
    """Return the mean displacement [m] or, with quantity "v", mean velocity [m/s] of the points of a block at each row of the
    history, shape (rows, 3)."""
    return np.stack([column(run, f"{block}_{quantity}{axis}") for axis in "xyz"], axis=1)


def oblique_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: for each block its speed down the slope at the end plus μ times its speed normal to the
    slope, a sum that oscillations of the block do not change; its largest distance from the line of steepest descent; error of
    the energy balance."""
    end = float(column(run, "time")[-1])
    result = {}
    for block in BLOCKS:
        # v_down + μ v_off = g (sin - μ cos) t however the block swings, as friction is μ times the force of the plane; its
        # springs take a millisecond to load
        found = float(vectors(run, block, "v")[-1] @ (DOWN + OBLIQUE_FRICTION * NORMAL))
        meaning = "at the end: speed down the slope plus μ times the speed normal to it; reference: g (sin α - μ cos α) t"
        result[block] = compared(found, OBLIQUE_PULL * end, 0.005, "m/s", meaning)
    for block in BLOCKS:
        way = vectors(run, block)
        # friction leans against the motion of each point of the foot, and these swing
        aside = float(np.max(np.abs(way @ ASIDE)))
        meaning = "largest distance from the line of steepest descent; error relative to the distance travelled"
        result[f"{block}_aside"] = Metric(aside, 0.0, aside / float(way[-1] @ DOWN), 0.002, "m", meaning)
    return result | {"energy": energy_metric(run, 0.005)}


def oblique_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the speeds down the slope against time, the paths of the blocks seen from above, and
    their distances from the line of steepest descent against time."""
    time = column(run, "time")
    figure, (speed, above, aside) = new_panels(1, 3, height=3.4)
    for colour, (block, name) in zip(COLOURS, BLOCKS.items(), strict=False):
        way = vectors(run, block)
        beside(speed, time, vectors(run, block, "v") @ DOWN, OBLIQUE_PULL * time, name, colour)
        line = 0.5 * OBLIQUE_PULL * time**2
        beside(above, way[:, 0], way[:, 1], np.interp(way[:, 0], line * DOWN[0], line * DOWN[1]), name, colour)
        aside.plot(time, 1e3 * (way @ ASIDE), color=colour, label=name)
    aside.axhline(0.0, color="#bbb", linewidth=1.0)
    label(speed, "time", "speed down the slope", "s", "m/s", legend=True)
    label(above, "way along x", "way along y", "m", "m")
    label(aside, "time", "distance from the line of steepest descent", "s", "mm", legend=True)
    return {"blocks_on_oblique_planes": figure}


CASES = {
    "blocks-on-slope": SimpleNamespace(METRICS=SLOPE_METRICS, metrics=slope_metrics),
    "turned-blocks": SimpleNamespace(
        METRICS=TURNED_METRICS, CAPTIONS=TURNED_CAPTIONS, metrics=turned_metrics, figures=turned_figures
    ),
    "blocks-on-oblique-planes": SimpleNamespace(
        METRICS=OBLIQUE_METRICS, CAPTIONS=OBLIQUE_CAPTIONS, metrics=oblique_metrics, figures=oblique_figures
    ),
}
"""Metrics, captions and figures of each case, by its name without the group."""
