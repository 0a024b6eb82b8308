"""Metrics of blocks that slide, stick and rest on a slope, compared with Coulomb's law."""

import numpy as np

from pellucid.gallery.exact_curves import column, compared, energy_metric
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

METRICS = ("slides", "wall_slides", "sticks", "wall_sticks", "sits", "rests", "energy")

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


def metrics(run: Run) -> dict[str, Metric]:
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
