"""Metrics and figures of a plane vesicle in a shear flow, compared with boundary integrals; conservation of mass and
enclosed area."""

import numpy as np

from pellucid.gallery.benet2015.films import kept, shapes_of
from pellucid.gallery.exact_curves import compared
from pellucid.references.finite_elements import read
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

NAME = "vesicle"
CLOSE, CELLS = 0.03, 4.0  # error at so many cells a radius, at first order
TURNED = 0.035  # 2 degrees, in radians
CAPTIONS = {
    "shape": "Deformation and inclination against time, compared with boundary integrals.",
}

METRICS = ("deformation", "inclination", "area", "film_mass")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: deformation (L - B)/(L + B) of the vesicle, with its longest and shortest diameter, and
    inclination of the longest one at the end; largest changes of the enclosed area and of the film's mass."""
    times, reference, shapes = run.times(NAME), read("vesicle_in_shear"), shapes_of(run, NAME)
    end, cells = float(times[-1]), 1.0 / run.case.grid.cell
    expected, angle = (float(np.interp(end, reference["time"], reference[key])) for key in ("deformation", "angle"))
    found, turned = shapes[-1].deformation, shapes[-1].inclination
    off = float(np.radians(abs(turned - angle)))
    shape = "deformation (L - B)/(L + B) at the end; reference: boundary integrals"
    axis = "inclination of the longest axis at the end; reference: boundary integrals; error and tolerance in radians"
    return {
        "deformation": compared(found, expected, CLOSE * CELLS / cells, "", shape),
        "inclination": Metric(turned, angle, off, TURNED * CELLS / cells, "degree", axis),
        **kept(run, NAME),
    }


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the deformation of the vesicle and the inclination of its longest axis against time."""
    times, reference, shapes = run.times(NAME), read("vesicle_in_shear"), shapes_of(run, NAME)
    figure, (left, right) = new_panels(1, 2, height=3.4)
    found = [shape.deformation for shape in shapes], [shape.inclination for shape in shapes]
    panels = zip((left, right), found, ("deformation", "angle"), strict=True)
    for axes, values, key in panels:
        axes.plot(times, values, "o-", color=COLOURS[0], markersize=3, label="film on the grid")
        axes.plot(reference["time"], reference[key], "--", color=COLOURS[1], label="boundary integrals")
    label(left, "time", "deformation", "s", "", legend=True)
    label(right, "time", "inclination", "s", "degree")
    return {"shape": figure}
