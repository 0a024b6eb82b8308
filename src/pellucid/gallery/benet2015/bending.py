"""Metrics and figures of vesicles at rest under bending, compared with solutions of the shape equations: bending energies of
closed shapes, and a tether pulled from a vesicle."""

from math import pi
from types import SimpleNamespace

import numpy as np

from pellucid.gallery.benet2015.films import film_of, films_of, pressures_of, radius_of
from pellucid.gallery.exact_curves import compared, worst_balance
from pellucid.references.membranes import SHAPE_ENERGIES, Tether, tether
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_figure, new_panels

SHAPE_CAPTIONS = {
    "shapes": "Meridians of the vesicles at rest (common scale), with reduced volume and bending energy relative to a sphere."
}

SHAPE_METRICS = tuple(f"{branch}-{round(100 * reduced)}" for branch, reduced in SHAPE_ENERGIES)


def _energies(run: Run) -> dict[str, float]:
    """Return the bending energy of each film at the end divided by 8πκ (that of a sphere, with the bending rigidity κ), by
    name."""
    return {
        film.name: float(run.history[f"bending-{film.name}"][-1]) / (8.0 * pi * film.material.bending_rigidity)
        for film in films_of(run)
    }


def shape_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: bending energy of each vesicle at the end, divided by that of a sphere."""
    result = {}
    for name, found in _energies(run).items():
        branch, hundredths = name.split("-")
        exact = SHAPE_ENERGIES[branch, int(hundredths) / 100]
        result[name] = compared(found, exact, 1e-3, "", "bending energy divided by 8πκ, the energy of a sphere")
    return result


def shape_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the meridians of the vesicles at the end."""
    energies = _energies(run)
    places = {film.name: run.fields(film.name)["position"] for film in films_of(run)}
    across = -(-len(energies) // 2)
    rows = [list(places.values())[:across], list(places.values())[across:]]
    heights = [
        max((0.55 * float(np.ptp(place[:, 2])) for place in row), default=0.0) for row in rows if row
    ]  # half of the room
    wide = 1.6 * max(float(place[:, 0].max()) for place in places.values())  # room for the titles
    figure = new_figure(10.0, 6.0, layout="compressed")
    grid = figure.subplots(len(heights), across, squeeze=False, sharex=True, sharey="row", height_ratios=heights)
    for row, height in zip(grid, heights, strict=True):
        row[0].set(xlim=(-wide, wide), ylim=(-height, height))
    panels = grid.ravel()
    for axes, (name, place) in zip(panels, places.items(), strict=False):
        middle = 0.5 * float(place[:, 2].max() + place[:, 2].min())
        for sign in (1.0, -1.0):
            axes.plot(sign * place[:, 0], place[:, 2] - middle, color="#0072B2", linewidth=2)
        axes.set_aspect("equal")
        axes.set_axis_off()
        branch, hundredths = name.split("-")
        axes.set_title(f"{branch}, v = {int(hundredths) / 100:g}\nE/8πκ = {energies[name]:.5f}")
    for axes in panels[len(energies) :]:
        axes.remove()
    figure.suptitle(run.case.title)
    return {"shapes": figure}


TETHER_CAPTIONS = {"tether": "Force at the pole against its displacement, compared with a tube, and the meridian at the end."}

TETHER_METRICS = ("force", "radius", "thin_force", "energy")


def _tube(run: Run) -> tuple[Tether, Tether]:
    """Return force and radius of the exact tube at the final tension of the run: with its inner pressure, and without
    pressure."""
    rigidity, tension = film_of(run).material.bending_rigidity, float(run.history["tension"][-1])
    return tether(tension, rigidity, pressures_of(run)[0].value), tether(tension, rigidity)


def _radius(run: Run) -> float:
    """Return the mean radius of the middle third of the tube [m]; towards both ends the radius oscillates about the radius
    of a long tube.

    The tube extends from its narrowest position near the vesicle to its widest position near the pole.
    """
    r, z = run.fields(film_of(run).name)["position"][:, [0, 2]].T
    widest = len(r) - 1 - int(np.argmax(np.diff(r[::-1]) < 0.0))
    equator = int(np.argmax(r))
    narrowest = equator + int(np.argmax(np.diff(r[equator:]) > 0.0))
    third = (z[widest] - z[narrowest]) / 3.0
    middle = (z >= z[narrowest] + third) & (z <= z[widest] - third)
    return float(r[middle].mean())


def tether_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: force on the pole and radius of the tether, compared with a tube at the same tension; largest
    error of the energy balance."""
    tube, thin = _tube(run)
    force, radius = float(run.history["force"][-1]), _radius(run)
    share = 0.5 * thin.radius / radius_of(film_of(run))  # πr²P/F with P = 2σ/R
    text = "force on the pole; reference: 2π√(2κσ), which neglects the pressure in the tube"
    return {
        "force": compared(force, tube.force, 0.02, "N", "force on the pole; reference: tube with pressure inside"),
        "radius": compared(radius, tube.radius, 0.02, "m", "radius of the tube; reference: tube with pressure inside"),
        "thin_force": compared(force, thin.force, 0.005 + share, "N", text),
        "energy": worst_balance(
            run, 1e-3, "largest relative error of the energy balance (work of loads, stored energy, dissipation)"
        ),
    }


def tether_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the pulling force against the displacement of the pole, and the meridian of the vesicle
    at the end."""
    tube, thin = _tube(run)
    figure, (left, right) = new_panels(1, 2, width_ratios=(3, 2), width=10.0, height=4.2, title=run.case.title)
    speed = run.case.support[0].velocity[2]
    left.plot(speed * run.history["time"][1:], run.history["force"][1:], color=COLOURS[1], label="film")
    left.axhline(tube.force, color="black", linewidth=1, linestyle="--", label="tube with the pressure inside")
    left.axhline(thin.force, color="#889", linewidth=1, linestyle=":", label="2π√(2κσ)")
    label(left, "displacement of the pole", "force", "m", "N", legend=True)
    place = run.fields(film_of(run).name)["position"]
    for sign in (1.0, -1.0):
        right.plot(sign * place[:, 0], place[:, 2], color=COLOURS[0])
    right.set_aspect("equal")
    label(right, "r", "z", "m", "m")
    return {"tether": figure}


CASES = {
    "vesicle-shapes": SimpleNamespace(
        METRICS=SHAPE_METRICS, CAPTIONS=SHAPE_CAPTIONS, metrics=shape_metrics, figures=shape_figures
    ),
    "tether": SimpleNamespace(METRICS=TETHER_METRICS, CAPTIONS=TETHER_CAPTIONS, metrics=tether_metrics, figures=tether_figures),
    "vesicle-in-space": SimpleNamespace(METRICS=("prolate-90",), metrics=shape_metrics),
}
"""Metrics, captions and figures of each case, by its name without the group."""
