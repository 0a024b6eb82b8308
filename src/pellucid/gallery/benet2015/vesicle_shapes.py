"""Shapes of vesicles and their bending energies against published ones."""

from math import pi
from typing import TYPE_CHECKING

from pellucid.gallery.benet2015.films import films_of
from pellucid.references.vesicles import SHAPE_ENERGIES
from pellucid.results.metrics import Metric
from pellucid.results.pictures.curves_in_plane import film_of_curves
from pellucid.results.pictures.films import Film
from pellucid.results.pictures.style import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.storage.run import Run

CAPTIONS = {"shapes": "Meridians of the vesicles at rest, with reduced volume and bending energy over that of a sphere."}

METRICS = tuple(f"{branch}-{round(100 * reduced)}" for branch, reduced in SHAPE_ENERGIES)


def _energies(run: "Run") -> dict[str, float]:
    """Bending energy at the end over 8πκ of each film."""
    return {
        film.name: float(run.history[f"bending-{film.name}"][-1]) / (8.0 * pi * film.material.bending_rigidity)
        for film in films_of(run)
    }


def metrics(run: "Run") -> dict[str, Metric]:
    """Energies at the end."""
    result = {}
    for name, found in _energies(run).items():
        branch, hundredths = name.split("-")
        exact = SHAPE_ENERGIES[branch, int(hundredths) / 100]
        result[name] = Metric(found, exact, abs(found / exact - 1.0), 1e-3, "", "bending energy over 8πκ")
    return result


def figures(run: "Run") -> dict[str, "Figure"]:
    """The shapes at the end."""
    energies = _energies(run)
    figure = new_figure(10.0, 5.6)
    panels = figure.subplots(2, -(-len(energies) // 2), squeeze=False).ravel()
    for axes, film in zip(panels, films_of(run), strict=False):
        place = run.fields(film.name)["position"]
        for sign in (1.0, -1.0):
            axes.plot(sign * place[:, 0], place[:, 2] - place[:, 2].mean(), color="#0072B2", linewidth=2)
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_title(f"{film.name.split('-')[0]}, v = {int(film.name.split('-')[1]) / 100:g}\n{energies[film.name]:.5f}")
    for axes in panels[len(energies) :]:
        axes.remove()
    figure.suptitle(run.case.title)
    return {"shapes": figure}


def films(run: "Run") -> dict[str, Film]:
    """The vesicles as they come to rest."""
    return {"motion": film_of_curves(run)}
