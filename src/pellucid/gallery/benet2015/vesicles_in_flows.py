"""Metrics and figures of closed films in flows: a drop and a plane vesicle in shear flows, and a vesicle that passes a
constriction. The film conserves its mass and what it encloses."""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from pellucid.gallery.benet2015.films import enclosed_area, kept, shapes_of
from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.geometry.meshes.enclosure import ellipsoid_of
from pellucid.geometry.region import Region
from pellucid.references.finite_elements import read
from pellucid.references.flows import drop_approach, drop_deformation
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

DROP_CLOSE, DROP_CELLS = 0.05, 6.0  # error at so many cells a radius; it falls at second order

DROP_CAPTIONS = {
    "deformation": "Deformation of the drop against time, compared with small-deformation theory between plates.",
}

DROP_METRICS = ("deformation", "volume", "film_mass")


class Drop(NamedTuple):
    """Parameters of the drop in a shear flow between two plates."""

    radius: float  # initial radius of the drop [m]
    capillary: float  # capillary number: outer viscosity times shear rate times radius, divided by surface tension
    ratio: float  # viscosity of the drop divided by that of the outer fluid
    confinement: float  # radius divided by the distance of the plates
    shear: float  # shear rate [1/s]

    def expected(self, time: float) -> float:
        """Return the deformation (L - B)/(L + B) of the drop by small-deformation theory at a time [s]; L and B: largest and
        smallest diameter."""
        steady = drop_deformation(self.capillary, self.ratio, self.confinement)
        return steady * drop_approach(self.capillary, self.ratio, self.shear * time)


def drop_of(run: Run) -> Drop:
    """Return the parameters of the drop in the case of a run."""
    fluid, drop, film = (_body(run, name) for name in ("fluid", "drop", "film"))
    radius, shear = film.surface.sphere.radius, fluid.initial[0].x[1]
    viscosity, tension = fluid.material.viscosity, film.material.tension * film.thickness
    gap = run.case.grid.upper[1] - run.case.grid.lower[1]
    return Drop(radius, viscosity * shear * radius / tension, drop.material.viscosity / viscosity, radius / gap, shear)


def _body(run: Run, name: str) -> Any:
    return next(body for body in run.case.body if body.name == name)


def drop_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: deformation (L - B)/(L + B) of the drop at the end, L and B being its largest and smallest
    diameter; largest changes of the enclosed volume and of the film's mass."""
    times, drop, triangles = run.times("film"), drop_of(run), run.triangles("film")
    end = float(times[-1])
    found, expected = ellipsoid_of(run.fields("film", end)["position"], triangles).deformation, drop.expected(end)
    tolerance = DROP_CLOSE * (DROP_CELLS * run.case.grid.cell / drop.radius) ** 2
    return {
        "deformation": compared(
            found,
            expected,
            tolerance,
            "",
            "deformation (L - B)/(L + B) at the end; reference: Taylor, Cox; effect of the plates: Shapira & Haber",
        ),
        **kept(run, "film"),
    }


def drop_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the deformation and the semi-axes of the drop against time."""
    return {"deformation": _deformation(run)}


def _deformation(run: Run) -> Figure:
    times, drop, triangles = run.times("film"), drop_of(run), run.triangles("film")
    shapes = [ellipsoid_of(run.fields("film", float(time))["position"], triangles) for time in times]
    figure, (left, right) = new_panels(1, 2, height=3.4)
    left.plot(times, [shape.deformation for shape in shapes], "o-", color=COLOURS[0], markersize=3, label="drop")
    left.plot(times, [drop.expected(float(time)) for time in times], "--", color=COLOURS[1], label="small-deformation theory")
    free = drop_deformation(drop.capillary, drop.ratio)
    left.axhline(free, color="0.5", linewidth=1, linestyle=":", label="steady state without plates")
    label(left, "time", "deformation", "s", "", legend=True)
    for axis, name, colour in zip((2, 1, 0), ("shortest", "middle", "longest"), COLOURS, strict=False):
        right.plot(times, [shape.axes[axis] for shape in shapes], color=colour, label=name)
    label(right, "time", "semi-axis", "s", "m", legend=True)
    return figure


SHEAR_NAME = "vesicle"
SHEAR_CLOSE, SHEAR_CELLS = 0.03, 4.0  # error at so many cells a radius, at first order
TURNED = 0.035  # 2 degrees, in radians
SHEAR_CAPTIONS = {
    "shape": "Deformation and inclination against time, compared with boundary integrals.",
}

SHEAR_METRICS = ("deformation", "inclination", "area", "film_mass")


def shear_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: deformation (L - B)/(L + B) of the vesicle, with its longest and shortest diameter, and
    inclination of the longest one at the end; largest changes of the enclosed area and of the film's mass."""
    times, reference, shapes = run.times(SHEAR_NAME), read("vesicle_in_shear"), shapes_of(run, SHEAR_NAME)
    end, cells = float(times[-1]), 1.0 / run.case.grid.cell
    expected, angle = (float(np.interp(end, reference["time"], reference[key])) for key in ("deformation", "angle"))
    found, turned = shapes[-1].deformation, shapes[-1].inclination
    off = float(np.radians(abs(turned - angle)))
    shape = "deformation (L - B)/(L + B) at the end; reference: boundary integrals"
    axis = "inclination of the longest axis at the end; reference: boundary integrals; error and tolerance in radians"
    return {
        "deformation": compared(found, expected, SHEAR_CLOSE * SHEAR_CELLS / cells, "", shape),
        "inclination": Metric(turned, angle, off, TURNED * SHEAR_CELLS / cells, "degree", axis),
        **kept(run, SHEAR_NAME),
    }


def shear_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the deformation of the vesicle and the inclination of its longest axis against time."""
    times, reference, shapes = run.times(SHEAR_NAME), read("vesicle_in_shear"), shapes_of(run, SHEAR_NAME)
    figure, (left, right) = new_panels(1, 2, height=3.4)
    found = [shape.deformation for shape in shapes], [shape.inclination for shape in shapes]
    panels = zip((left, right), found, ("deformation", "angle"), strict=True)
    for axes, values, key in panels:
        axes.plot(times, values, "o-", color=COLOURS[0], markersize=3, label="film on the grid")
        axes.plot(reference["time"], reference[key], "--", color=COLOURS[1], label="boundary integrals")
    label(left, "time", "deformation", "s", "", legend=True)
    label(right, "time", "inclination", "s", "degree")
    return {"shape": figure}


CONSTRICTION_NAME = "vesicle"
NEAREST, TOUCH = 1.5, 0.5  # cells: quadratic functions reach so far; walls are nodes, and known to half a cell
SHORT = 0.01  # of its radius
FASTEST = 1.5  # of the mean velocity between plates: the middle of the channel
SIDEWAYS = 0.01  # of its radius: channel, flow and points are symmetric
CONSTRICTION_CAPTIONS = {
    "shape": "Position and deformation of the vesicle, and enclosed area, against time.",
}

CONSTRICTION_METRICS = ("passage", "beyond", "clearance", "sideways", "area", "film_mass")


def constriction_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: volume displaced by the piston until the vesicle is in the throat, final position, smallest
    distance from the walls, sideways motion, changes of enclosed area and film mass.

    In the middle of a channel the vesicle moves faster than the mean flow and slower than its maximum, which is 1.5 times the
    mean. When the vesicle reaches the throat, the piston has therefore displaced between 1/1.5 and all of the volume of the
    channel between the initial position of the vesicle and the throat.
    """
    times = run.times(CONSTRICTION_NAME)
    places = [run.fields(CONSTRICTION_NAME, float(time))["position"][:, :2] for time in times]
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
        **kept(run, CONSTRICTION_NAME),
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


def constriction_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show position, shape and enclosed area of the vesicle over time."""
    times, shapes = run.times(CONSTRICTION_NAME), shapes_of(run, CONSTRICTION_NAME)
    middle = [run.fields(CONSTRICTION_NAME, float(time))["position"][:, 0].mean() for time in times]
    areas = np.array([enclosed_area(run, CONSTRICTION_NAME, float(time)) for time in times])
    figure, (left, centre, right) = new_panels(1, 3, height=3.0)
    left.plot(times, middle, color=COLOURS[0])
    label(left, "time", "mean x of its nodes", "s", "m")
    centre.plot(times, [shape.deformation for shape in shapes], color=COLOURS[0])
    label(centre, "time", "deformation", "s", "")
    right.plot(times, 100.0 * (areas / areas[0] - 1.0), color=COLOURS[0])
    label(right, "time", "change of the enclosed area", "s", "%")
    return {"shape": figure}


CASES = {
    "vesicle-in-flow": SimpleNamespace(
        METRICS=DROP_METRICS, CAPTIONS=DROP_CAPTIONS, metrics=drop_metrics, figures=drop_figures
    ),
    "vesicle-in-shear": SimpleNamespace(
        METRICS=SHEAR_METRICS, CAPTIONS=SHEAR_CAPTIONS, metrics=shear_metrics, figures=shear_figures
    ),
    "vesicle-in-constriction": SimpleNamespace(
        METRICS=CONSTRICTION_METRICS, CAPTIONS=CONSTRICTION_CAPTIONS, metrics=constriction_metrics, figures=constriction_figures
    ),
}
"""Metrics, captions and figures of each case, by its name without the group."""
