"""Metrics and figures of sheets that bend under their own weight: the Scordelis-Lo roof and a clamped strip of cloth."""

from math import pi
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from pellucid.bodies.membrane_elements.model import MembraneElementsCase
from pellucid.gallery.exact_curves import column, compared, energy_metric
from pellucid.geometry.surfaces.quadrilaterals import Rectangle, Tube
from pellucid.materials.elastic import ElasticMaterial
from pellucid.references.solids import heavy_elastica
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

ROOF_CAPTIONS = {"section": "Deflection of the mid-span section of the roof, and the reference at the free edge."}

ROOF_METRICS = ("deflection", "weight", "energy")

DEFLECTION, WEIGHT = 0.3024, 90.0
"""Deflection in the middle of the free edge, and weight per unit area, in the units of the benchmark."""
LIMIT = 0.006
"""Tolerance of the deflection: relative difference between the reference and deep shell theory (0.3006), to which meshes
converge."""
SPAN, HALF_ANGLE = 25.0, 40.0 / 180.0 * pi


def roof_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: deflection in the middle of the free edge, vertical force on the diaphragm that supports the
    roof, error of the energy balance."""
    body = run.case.body[0]
    if not isinstance(body, MembraneElementsCase):
        raise ValueError(f"body {body.name} is not a membrane of elements")
    load = body.material.density * body.thickness * abs(run.case.gravity[2])
    surface = body.surface.chosen()
    if not isinstance(surface, Tube):
        raise ValueError(f"the surface of body {body.name} is not a tube")
    across, along = surface.points[0] * HALF_ANGLE / (2.0 * pi), surface.points[1] - 1
    # triangles of constant strain are too stiff, to second order in the edges: by 3.9 % with 16 edges on both sides
    tolerance = LIMIT + 6.0 / across**2 + 10.0 / along**2
    carried = load * SPAN * SPAN * HALF_ANGLE
    return {
        "deflection": compared(
            -float(column(run, "edge")[-1]),
            DEFLECTION * load / WEIGHT,
            tolerance,
            "m",
            "deflection in the middle of the free edge",
        ),
        "weight": compared(
            float(column(run, "hold_z")[-1]),
            carried,
            2e-3,
            "N",
            "force on the diaphragm; reference: weight of a quarter of the roof",
        ),
        "energy": energy_metric(run, 0.005),
    }


def roof_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the deflection of the middle section of the roof at the end against the angle from the
    crown."""
    start, end = (run.fields("roof", float(time)) for time in (run.times("roof")[0], run.times("roof")[-1]))
    x, place = np.asarray(start["position"]), np.asarray(end["position"])
    middle = np.abs(x[:, 1] - SPAN) < 1e-9
    angle = np.degrees(np.arctan2(x[middle, 0], x[middle, 2]))
    order = np.argsort(angle)
    figure, axes = new_panels(1, 1, width=5.0, height=3.4, title=run.case.title)
    axes.plot(angle[order], (place - x)[middle, 2][order], ".-", color=COLOURS[1], label="nodes")
    axes.plot([40.0], [-roof_metrics(run)["deflection"].reference], "o", color="black", label="reference")
    label(axes, "angle from the crown", "deflection", "degrees", "m")
    axes.legend()
    return {"section": figure}


SHELF_CAPTIONS = {"shape": "Centreline of the strip at rest, compared with the heavy elastica."}

SHELF_METRICS = ("drop", "reach", "weight", "energy")

FREE = 1.0  # length of the strip beyond the clamp [m]


def shelf_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: deflection of the tip at rest, its horizontal distance from the clamp, vertical force on the
    clamp, error of the energy balance."""
    body = _strip(run)
    reach, drop = _elastica(run, np.array([FREE]))
    surface = body.surface.chosen()
    if not isinstance(surface, Rectangle):
        raise ValueError(f"the surface of body {body.name} is not a rectangle")
    # second order in the edges h: folds at nodes sum moments by the trapezoidal rule, which gives h²/L² of the drop
    edge = surface.first_edge[0] / (surface.points[0] - 1)
    tolerance = 1.5 * (edge / FREE) ** 2
    pull = body.material.density * body.thickness * abs(run.case.gravity[2]) * surface.first_edge[0] * surface.second_edge[1]
    return {
        "drop": compared(-float(column(run, "tip_z")[-1]), float(drop[0]), tolerance, "m", "deflection of the tip at rest"),
        "reach": compared(
            float(column(run, "tip_x")[-1]), float(reach[0]), tolerance, "m", "distance of the tip from the clamp"
        ),
        "weight": compared(
            float(column(run, "hold_z")[-1]), pull, 1e-3, "N", "force on the clamp; reference: weight of the strip"
        ),
        "energy": energy_metric(run, 0.005),
    }


def shelf_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the middle line of the strip at rest, with the exact heavy elastica."""
    start, end = (run.fields("strip", float(time)) for time in (run.times("strip")[0], run.times("strip")[-1]))
    x, place = np.asarray(start["position"]), np.asarray(end["position"])
    middle = np.abs(x[:, 1] - 0.1) < 1e-9
    along, below = _elastica(run, np.linspace(0.0, FREE, 100))
    figure, axes = new_panels(1, 1, width=5.0, height=3.4, title=run.case.title)
    axes.plot(along, -below, color="black", linewidth=1, label="heavy elastica")
    axes.plot(place[middle, 0], place[middle, 2], ".", color=COLOURS[1], label="nodes")
    axes.set_aspect("equal")
    label(axes, "x", "z", "m", "m")
    axes.legend()
    return {"shape": figure}


def _strip(run: Run) -> MembraneElementsCase:
    body = run.case.body[0]
    if not isinstance(body, MembraneElementsCase):
        raise ValueError(f"body {body.name} is not a membrane of elements")
    return body


def _elastica(run: Run, along: "NDArray[np.float64]") -> "tuple[NDArray[np.float64], NDArray[np.float64]]":
    """Return the exact horizontal and vertical distances from the clamp at rest [m] of positions on the strip; along: arc
    lengths of the positions from the clamp [m]."""
    body = _strip(run)
    material: object = body.material
    if not isinstance(material, ElasticMaterial) or body.bending is None:
        raise ValueError(f"body {body.name} must be an elastic membrane that bends")
    weight = body.material.density * body.thickness * abs(run.case.gravity[2])
    stretching = material.young_modulus * body.thickness
    return heavy_elastica(along, FREE, body.bending.rigidity, weight, stretching)


CASES = {
    "roof": SimpleNamespace(METRICS=ROOF_METRICS, CAPTIONS=ROOF_CAPTIONS, metrics=roof_metrics, figures=roof_figures),
    "shelf": SimpleNamespace(METRICS=SHELF_METRICS, CAPTIONS=SHELF_CAPTIONS, metrics=shelf_metrics, figures=shelf_figures),
}
"""Metrics, captions and figures of each case, by its name without the group."""
