"""The sheet on the sphere against finite elements of our own with elements of the same size."""

from typing import TYPE_CHECKING

import numpy as np

from pellucid.case import load
from pellucid.gallery.lian2014 import shapes
from pellucid.gallery.lian2014.curves import Curve, deviations, figure_of
from pellucid.references import finite_elements
from pellucid.results.films import Film
from pellucid.results.metrics import Metric
from pellucid.results.scenes.scene import View

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.run import Run

FINE = 7.5e-4
"""Elements with shorter sides [m] are compared with finite elements of 0.5 mm, others with those of 1 mm."""

VIEW = View(-55.0, 14.0)
INSTANTS = (1e-4, 2.2e-4, 3.6e-4, 5e-4)

CAPTIONS = {
    "curves": "Middle and corner of the sheet beside finite elements of the same size: mean over sheets that differ by a trace "
    "of noise, and for sides of 1 mm the range of sixteen; dotted a sheet that bears no compression.",
    "shapes": "The sheet wraps itself round the sphere, which is drawn as a ball of its volume.",
}


def metrics(run: "Run") -> dict[str, Metric]:
    """Largest deviations over the run."""
    if not finite_elements.same_problem(run.case, load("lian2014/membrane-on-sphere")):
        raise ValueError("the finite elements are for the paper's sheet and sphere")
    return deviations(run, _curves(run))


def figures(run: "Run") -> "dict[str, Figure]":
    """Curves beside the finite elements, and pictures."""
    return {"curves": figure_of(run, _curves(run)), "shapes": shapes.panels(run, VIEW, INSTANTS)}


def films(run: "Run") -> dict[str, Film]:
    """The sheet as it falls and wraps itself round the sphere."""
    return {"draping": shapes.film(run, VIEW)}


def _curves(run: "Run") -> tuple[Curve, ...]:
    table = finite_elements.read("membrane_on_sphere")
    kind = "fine_" if _side(run) < FINE else ""
    relaxed = {name: {"no compression": table[f"relaxed_{name}"]} for name in ("centre_z", "corner_z")}
    band = None if kind else (table["least_corner_z"], table["greatest_corner_z"])
    return (
        Curve("centre_z", "the sheet's middle", table["time"], table[f"{kind}centre_z"], relaxed["centre_z"]),
        Curve("corner_z", "a corner of the sheet", table["time"], table[f"{kind}corner_z"], relaxed["corner_z"], band),
    )


def _side(run: "Run") -> float:
    """Of the sheet's elements [m]: the root of their mean area at the start."""
    sheet = run.fields("sheet", 0.0)["position"]
    lower, upper = sheet.min(axis=0), sheet.max(axis=0)
    return float(np.sqrt(np.prod((upper - lower)[:2]) / (len(run.triangles("sheet")) / 2)))
