"""The vesicle in a constriction: it passes, it stays off the walls, it keeps its mass and the area inside."""

from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.gallery.benet2015.films import enclosed_area, finish_panel, kept, shapes_of
from pellucid.geometry.region import Region
from pellucid.results.metrics import Metric
from pellucid.results.pictures.instants import evenly
from pellucid.results.pictures.style import COLOURS, label, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.storage.run import Run

NAME = "vesicle"
TOUCH = 0.5  # cells: walls are nodes of the grid
ROUNDING = 1e-9  # m
PANELS = 6

CAPTIONS = {
    "passage": "The film and the points of the fluid on its way; the walls that are held.",
    "shape": "Place and deformation of the vesicle, and the area inside, against time.",
}

METRICS = ("passed", "clearance", "area", "film_mass")


def metrics(run: "Run") -> dict[str, Metric]:
    """Where its last node is at the end, how near the walls it came, what it lost."""
    times = run.times(NAME)
    frames = [run.fields(NAME, float(time)) for time in times]
    beyond = float(frames[-1]["position"][:, 0].min())
    nearest = min(_distance(run, fields["position"]) for fields in frames) / run.case.grid.cell
    return {
        "passed": Metric(beyond, 0.0, max(0.0, -beyond), ROUNDING, "m", "place of its last node beyond the throat at the end"),
        "clearance": Metric(nearest, 0.0, max(0.0, -nearest), TOUCH, "", "least distance from the walls, in cells"),
        **kept(run, NAME),
    }


def _walls(run: "Run") -> list[Any]:
    """The cylinders whose nodes are held."""
    regions = [support.region() for support in run.case.support]
    return [region.cylinder for region in regions if isinstance(region, Region)]


def _distance(run: "Run", position: np.ndarray) -> float:
    """Of the nearest node from the walls [m]."""
    return min(float(np.hypot(*(position - wall.centre())[:, :2].T).min()) - float(wall.radius) for wall in _walls(run))


def figures(run: "Run") -> dict[str, "Figure"]:
    """The passage; curves."""
    return {"passage": _passage(run), "shape": _shape(run)}


def _passage(run: "Run") -> "Figure":
    from matplotlib.patches import Circle

    chosen = evenly(run.times(NAME), PANELS)
    grid = run.case.grid
    figure = new_figure(height=1.7 * -(-len(chosen) // 2), layout="compressed")
    panels = figure.subplots(-(-len(chosen) // 2), 2, sharex=True, sharey=True).ravel()
    for axes, time in zip(panels, chosen, strict=False):
        for wall in _walls(run):
            axes.add_patch(Circle(wall.centre()[:2], wall.radius, color="0.55", linewidth=0, label="wall"))
        place, film = run.fields("fluid", float(time))["position"], run.fields(NAME, float(time))["position"]
        axes.plot(place[:, 0], place[:, 1], ".", color=COLOURS[4], markersize=1.5, markeredgewidth=0, label="fluid")
        axes.plot(*np.concatenate([film, film[:1]])[:, :2].T, color=COLOURS[1], label="film")
        axes.set_xlim(-8.5, 8.5)
        axes.set_ylim(grid.lower[1], grid.upper[1])
        finish_panel(axes, float(time))
    handles, names = axes.get_legend_handles_labels()
    once = dict(zip(names, handles, strict=True))  # of two walls one
    figure.legend(once.values(), once.keys(), loc="outside lower center", ncols=3, markerscale=4.0)
    return figure


def _shape(run: "Run") -> "Figure":
    times, shapes = run.times(NAME), shapes_of(run, NAME)
    middle = [run.fields(NAME, float(time))["position"][:, 0].mean() for time in times]
    areas = np.array([enclosed_area(run, NAME, float(time)) for time in times])
    figure = new_figure(height=3.0)
    left, centre, right = figure.subplots(1, 3)
    left.plot(times, middle, color=COLOURS[0])
    label(left, "time", "mean x of its nodes", "s", "m")
    centre.plot(times, [shape.deformation for shape in shapes], color=COLOURS[0])
    label(centre, "time", "deformation", "s", "")
    right.plot(times, 100.0 * (areas / areas[0] - 1.0), color=COLOURS[0])
    label(right, "time", "change of the area inside", "s", "%")
    return figure
