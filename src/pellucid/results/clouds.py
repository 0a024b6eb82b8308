"""Pictures of bodies as clouds of points, coloured by a field, in one or two dimensions."""

from typing import TYPE_CHECKING

import numpy as np

from pellucid.results.bodies_in_space import panels_in_space
from pellucid.results.probes import scalar
from pellucid.results.quantities import Cloud, limits, meaning, values_of
from pellucid.results.style import COLOURS, WIDTH, label, new_figure, with_unit
from pellucid.state import FIELDS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure

    from pellucid.results.run import Run

INSTANTS = 4
MOST_POINTS = 60_000
"""More points than this are thinned out evenly: a picture has no more places to show them."""

PROFILES = ("density", "velocity", "pressure", "internal_energy")

MOST_HEIGHT = 6.5  # of the panels together [inch]


def pictures(run: "Run") -> dict[str, "Figure"]:
    """Bodies at some instants by speed and by pressure or stress; along a tube the profiles at the end."""
    thin = run.case.grid.thin()
    if sum(thin) == 2:
        return {"profiles_of_points": _profiles(run, thin.index(False))}
    draw = _panels if any(thin) else panels_in_space
    return {f"bodies_{name}": draw(run, name) for name in ("speed", "load")}


def _profiles(run: "Run", axis: int) -> "Figure":
    names = [body.name for body in run.case.body]
    clouds = {name: _thinned(run.fields(name)) for name in names}
    wanted = [field for field in PROFILES if all(field in cloud for cloud in clouds.values())]
    figure = new_figure(height=5.6)
    grid = figure.subplots(2, 2, sharex=True).flat
    component = "xyz"[axis]
    for axes, field in zip(grid, wanted, strict=False):
        for name, colour in zip(names, COLOURS * len(names), strict=False):
            cloud = clouds[name]
            values = scalar(cloud[field], component if cloud[field].ndim > 1 else None)
            axes.plot(cloud["position"][:, axis], values, ".", markersize=2, color=colour, label=name)
        label(axes, component, field, "m", FIELDS[field].unit)
    for axes in list(figure.axes)[len(wanted) :]:
        axes.remove()
    figure.axes[0].legend(markerscale=5)
    figure.suptitle(f"Every point at t = {run.times(names[0])[-1]:.4g} s")
    return figure


def _panels(run: "Run", quantity: str) -> "Figure":
    names = [body.name for body in run.case.body]
    times = run.times(names[0])
    chosen = times[np.unique(np.linspace(0, len(times) - 1, INSTANTS).astype(int))]
    scenes = [[_thinned(run.fields(name, time)) for name in names] for time in chosen]
    title, unit = meaning(scenes[0], quantity)
    values = [[values_of(cloud, quantity) for cloud in scene] for scene in scenes]
    low, high = limits(values)
    flat = _Flat(run.case.grid.thin(), [cloud["position"] for scene in scenes for cloud in scene])
    down, width, height = flat.arrangement(len(chosen))
    figure = new_figure(height=height * down + 0.75, layout="compressed")
    panels = figure.subplots(down, -(-len(chosen) // down), sharex=True, sharey=True, squeeze=False).ravel()
    for unused in panels[len(chosen) :]:
        unused.remove()
    panels = panels[: len(chosen)]
    for number, (axes, scene, time) in enumerate(zip(panels, scenes, chosen, strict=True)):
        together = np.concatenate([cloud["position"] for cloud in scene])
        dots = flat.draw(axes, together, np.concatenate(values[number]), width, (low, high))
        axes.set_title(f"t = {time:.4g} s")
    bar = figure.colorbar(dots, ax=list(panels), shrink=0.9, pad=0.01, aspect=25)
    bar.set_label(with_unit(title, unit))
    bar.outline.set_visible(False)
    return figure


class _Flat:
    """Where points lie on the paper, the same for all panels."""

    def __init__(self, thin: tuple[bool, bool, bool], positions: list[np.ndarray]) -> None:
        self.flat = [axis for axis in range(3) if not thin[axis]]
        together = np.concatenate(positions)[:, self.flat]
        low, high = together.min(axis=0), together.max(axis=0)
        margin = 0.04 * float((high - low).max())
        self.low, self.high = low - margin, high + margin

    def arrangement(self, panels: int) -> tuple[int, float, float]:
        """Rows of panels that make them largest on the paper, and width and height of a panel [inch]."""
        ratio = (self.high - self.low)[1] / (self.high - self.low)[0]
        best = (1, 0.0, 0.0)
        for down in range(1, panels + 1):
            across = -(-panels // down)
            width = min((WIDTH - 1.4) / across, (MOST_HEIGHT / down - 0.3) / ratio)
            if width > best[1]:
                best = (down, width, width * ratio + 0.3)
        return best

    def draw(
        self, axes: "Axes", position: np.ndarray, values: np.ndarray, width: float, limits: tuple[float, float]
    ) -> "PathCollection":
        paper = position[:, self.flat]
        extent = self.high - self.low
        spacing = np.sqrt(np.prod(np.ptp(paper, axis=0) + 1e-300) / len(paper)) / extent[0] * width * 72.0
        size = (1.15 * float(np.clip(spacing, 1.0, 8.0))) ** 2  # circles a little larger than the gaps between them
        x, y = paper.T
        dots = axes.scatter(x, y, c=values, s=size, linewidths=0, vmin=limits[0], vmax=limits[1])
        axes.set_xlim(self.low[0], self.high[0])
        axes.set_ylim(self.low[1], self.high[1])
        axes.set_aspect("equal")
        axes.grid(False)
        label(axes, "xyz"[self.flat[0]], "xyz"[self.flat[1]], "m", "m")
        axes.label_outer()
        return dots


def _thinned(cloud: Cloud) -> Cloud:
    stride = -(-len(cloud["position"]) // MOST_POINTS)
    return {name: values[::stride] for name, values in cloud.items()}
