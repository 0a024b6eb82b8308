"""A cube between clamps that is pressed to half its height."""

from typing import TYPE_CHECKING

import numpy as np

from pellucid.gallery.mountris2019.clamped_cube import METRICS, known_at, metrics_at, of_mesh
from pellucid.gallery.mountris2019.curves import displacement
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, label, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.storage.run import Run

__all__ = ["CAPTIONS", "METRICS", "figures", "metrics"]

JUDGED = -0.01  # m: beyond, the sides pass the plates, and finite elements without contact have a limit less and less
KNOWN = (JUDGED, -0.02)

CAPTIONS = {"cube_compression": "Force on the top and strain energy against its displacement, beside finite elements."}


def metrics(run: "Run") -> dict[str, Metric]:
    """Energy and reaction at a tenth of the edge against finite elements."""
    return metrics_at(run, JUDGED, of_mesh(run, 0.01, 1.0))  # singular edges: first order, as finite elements have nearly


def figures(run: "Run") -> dict[str, "Figure"]:
    """Reaction and energy against the displacement."""
    figure = new_figure(10.0, 4.0)
    left, right = figure.subplots(1, 2)
    moved = -1e3 * displacement(run, 2)
    left.plot(moved, -np.asarray(run.history["reaction_z"]), "-o", color=COLOURS[0], label="meshless solid")
    right.plot(moved, run.history["strain_energy"], "-o", color=COLOURS[0], label="meshless solid")
    known = [known_at(run, distance) for distance in KNOWN]
    places = [-1e3 * distance for distance in KNOWN]
    left.plot(places, [-state.reaction for state in known], "x", color="black", markersize=9, label="finite elements")
    right.plot(places, [state.energy for state in known], "x", color="black", markersize=9, label="finite elements")
    label(left, "displacement of the top, down", "force", "mm", "N")
    label(right, "displacement of the top, down", "strain energy", "mm", "J")
    left.legend()
    return {"cube_compression": figure}
