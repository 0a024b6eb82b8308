"""Metrics and figures of vesicle shapes: bending energies compared with solutions of the shape equations."""

from math import pi

import numpy as np

from pellucid.gallery.benet2015.films import films_of
from pellucid.gallery.exact_curves import compared
from pellucid.references.membranes import SHAPE_ENERGIES
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Figure, Run, new_figure

CAPTIONS = {
    "shapes": "Meridians of the vesicles at rest (common scale), with reduced volume and bending energy relative to a sphere."
}

METRICS = tuple(f"{branch}-{round(100 * reduced)}" for branch, reduced in SHAPE_ENERGIES)


def _energies(run: Run) -> dict[str, float]:
    """Return the bending energy of each film at the end divided by 8πκ (that of a sphere, with the bending rigidity κ), by
    name."""
    return {
        film.name: float(run.history[f"bending-{film.name}"][-1]) / (8.0 * pi * film.material.bending_rigidity)
        for film in films_of(run)
    }


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: bending energy of each vesicle at the end, divided by that of a sphere."""
    result = {}
    for name, found in _energies(run).items():
        branch, hundredths = name.split("-")
        exact = SHAPE_ENERGIES[branch, int(hundredths) / 100]
        result[name] = compared(found, exact, 1e-3, "", "bending energy divided by 8πκ, the energy of a sphere")
    return result


def figures(run: Run) -> dict[str, Figure]:
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
