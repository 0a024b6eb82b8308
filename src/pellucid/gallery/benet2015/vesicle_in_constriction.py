"""Metrics and figures of a vesicle in a constriction: it passes with the flow, stays off the walls, and conserves its mass
and enclosed area."""

from typing import Any

import numpy as np

from pellucid.gallery.benet2015.films import enclosed_area, kept, shapes_of
from pellucid.gallery.exact_curves import vanishing
from pellucid.geometry.region import Region
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

NAME = "vesicle"
NEAREST, TOUCH = 1.5, 0.5  # cells: quadratic functions reach so far; walls are nodes, and known to half a cell
SHORT = 0.01  # of its radius
FASTEST = 1.5  # of the mean velocity between plates: the middle of the channel
SIDEWAYS = 0.01  # of its radius: channel, flow and points are symmetric
CAPTIONS = {
    "shape": "Position and deformation of the vesicle, and enclosed area, against time.",
}

METRICS = ("passage", "beyond", "clearance", "sideways", "area", "film_mass")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: volume displaced by the piston until the vesicle is in the throat, final position, smallest
    distance from the walls, sideways motion, changes of enclosed area and film mass.

    In the middle of a channel the vesicle moves faster than the mean flow and slower than its maximum, which is 1.5 times the
    mean. When the vesicle reaches the throat, the piston has therefore displaced between 1/1.5 and all of the volume of the
    channel between the initial position of the vesicle and the throat.
    """
    times = run.times(NAME)
    places = [run.fields(NAME, float(time))["position"][:, :2] for time in times]
    middle = np.array([place.mean(axis=0) for place in places])
    radius = 0.5 * float(np.ptp(places[0][:, 1]))
    piston = np.array([run.fields("piston", float(time))["position"][:, 0].mean() for time in times])
    height = run.case.grid.upper[1] - run.case.grid.lower[1]
    pushed = height * (piston - piston[0]) / _room(run, float(middle[0, 0]), 0.0)
    through = bool(middle[-1, 0] > 0.0)
    share = float(np.interp(0.0, middle[:, 0], pushed)) if through else float("nan")
    reference, band = 0.5 * (1.0 + 1.0 / FASTEST), 0.5 * (1.0 - 1.0 / FASTEST)
    last, end = (
        float(places[-1][:, 0].min()) / radius,
        max(float(wall.centre()[0] + wall.radius) for wall in _walls(run)) / radius,
    )
    nearest = min(_distance(run, place) for place in places) / run.case.grid.cell
    aside = float(np.abs(middle[:, 1]).max()) / radius
    text = "volume displaced until the vesicle is in the throat, over the volume up to there; reference: mean of 1/1.5 and 1"
    return {
        "passage": Metric(share, reference, abs(share - reference), band, "", text),
        "beyond": Metric(
            last,
            end,
            max(0.0, end - last),
            SHORT,
            "",
            "position of the vesicle's last node at the end, in radii; reference: end of the walls",
        ),
        "clearance": Metric(
            nearest, NEAREST, max(0.0, NEAREST - nearest), TOUCH, "", "smallest distance from the walls, in cells"
        ),
        "sideways": vanishing(aside, SIDEWAYS, "largest distance of the vesicle's centre from the channel axis, in radii"),
        **kept(run, NAME),
    }


def _room(run: Run, start: float, end: float) -> float:
    """Return the area of the channel between two positions along x (`start`, `end` [m]) and its walls [m²]."""
    x = np.linspace(start, end, 2001)
    low, high = (np.full(len(x), side) for side in (run.case.grid.lower[1], run.case.grid.upper[1]))
    for wall in _walls(run):
        centre = wall.centre()
        reach = np.sqrt(np.maximum(float(wall.radius) ** 2 - (x - centre[0]) ** 2, 0.0))
        if centre[1] < 0.0:
            low = np.maximum(low, centre[1] + reach)
        else:
            high = np.minimum(high, centre[1] - reach)
    return float(np.trapezoid(high - low, x))


def _walls(run: Run) -> list[Any]:
    """Return the cylinders that form the constriction: the regions of the supports, in which nodes are fixed."""
    regions = [support.region() for support in run.case.support]
    return [region.cylinder for region in regions if isinstance(region, Region)]


def _distance(run: Run, position: np.ndarray) -> float:
    """Return the distance of the nearest node from the walls [m]. position: of the nodes [m], shape (n, 2) or (n, 3)."""
    return min(float(np.hypot(*(position[:, :2] - wall.centre()[:2]).T).min()) - float(wall.radius) for wall in _walls(run))


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show position, shape and enclosed area of the vesicle over time."""
    times, shapes = run.times(NAME), shapes_of(run, NAME)
    middle = [run.fields(NAME, float(time))["position"][:, 0].mean() for time in times]
    areas = np.array([enclosed_area(run, NAME, float(time)) for time in times])
    figure, (left, centre, right) = new_panels(1, 3, height=3.0)
    left.plot(times, middle, color=COLOURS[0])
    label(left, "time", "mean x of its nodes", "s", "m")
    centre.plot(times, [shape.deformation for shape in shapes], color=COLOURS[0])
    label(centre, "time", "deformation", "s", "")
    right.plot(times, 100.0 * (areas / areas[0] - 1.0), color=COLOURS[0])
    label(right, "time", "change of the enclosed area", "s", "%")
    return {"shape": figure}
