"""The bending energy of a vesicle in space against that of the shape equations."""

import numpy as np

from pellucid.gallery.benet2015.films import film_of
from pellucid.gallery.benet2015.vesicle_shapes import metrics
from pellucid.references.vesicles import SHAPE_ENERGIES
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.style import COLOURS, label, new_panels

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]

CAPTIONS = {"energy": "Bending energy against time with that of the shape equations, and the profile at the end."}

METRICS = ("prolate-90",)


def figures(run: Run) -> dict[str, Figure]:
    """Energy against time, distance from the axis against height."""
    film = film_of(run)
    figure, (left, right) = new_panels(1, 2, width_ratios=(3, 2), width=10.0, height=4.0, title=run.case.title)
    energies = run.history[f"bending-{film.name}"] / (8.0 * np.pi * film.material.bending_rigidity)
    left.plot(run.history["time"], energies, color=COLOURS[1], label="film")
    left.axhline(SHAPE_ENERGIES["prolate", 0.9], color="black", linewidth=1, linestyle="--", label="shape equations")
    label(left, "time", "bending energy over 8πκ", "s", "", legend=True)
    place = run.fields(film.name)["position"]
    right.plot(np.hypot(place[:, 0], place[:, 1]), place[:, 2], ".", color=COLOURS[0], markersize=2)
    right.set_aspect("equal")
    label(right, "distance from the axis", "z", "m", "m")
    return {"energy": figure}
