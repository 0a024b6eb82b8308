"""Pictures of bodies as dots at their points, coloured by a field, in one or two dimensions."""

import numpy as np

from pellucid.results.pictures.annotations import Axes, Figure, Run
from pellucid.results.pictures.quantities import Fields, Limits, is_film, limits, meaning, values_of
from pellucid.results.pictures.rendering.axes import INK
from pellucid.results.pictures.style import COLOURS, WIDTH, colour_bar, label, new_panels, panels, with_unit
from pellucid.results.storage.probes import scalar
from pellucid.state import FIELDS

INSTANTS = 4
MOST_TICKS = 5
MOST_POINTS = 60_000
"""More points than this are thinned out evenly: a picture has no more places to show them."""

PROFILES = ("density", "velocity", "pressure", "internal_energy")

MOST_HEIGHT = 6.5  # of the panels together [inch]


def profiles(run: Run, axis: int) -> Figure:
    """Fields of every point at the end along an axis, 0 to 2."""
    names = [body.name for body in run.stored.bodies]
    bodies = {name: _thinned(run.fields(name)) for name in names}
    wanted = [field for field in PROFILES if all(field in fields for fields in bodies.values())]
    component, title = "xyz"[axis], f"Every point at t = {run.times(names[0])[-1]:.4g} s"
    figure, grid = new_panels(2, 2, sharex=True, height=5.6, title=title)
    for axes, field in zip(grid.flat, wanted, strict=False):
        for name, colour in zip(names, COLOURS * len(names), strict=False):
            fields = {key: values[_there(bodies[name])] for key, values in bodies[name].items()}
            values = scalar(fields[field], component if fields[field].ndim > 1 else None)
            axes.plot(fields["position"][:, axis], values, ".", markersize=2, color=colour, label=name)
        label(axes, component, field, "m", FIELDS[field].unit)
    for axes in list(figure.axes)[len(wanted) :]:
        axes.remove()
    figure.axes[0].legend(markerscale=5)
    return figure


def panels_in_plane(run: Run, quantity: str) -> Figure:
    """All bodies at some instants, coloured by "speed", "displacement" or "load"; films among them are dark lines on top."""
    described = [body for body in run.stored.bodies if not is_film(body)]
    skins = [body.name for body in run.stored.bodies if is_film(body)]
    names = [body.name for body in described]
    times = run.times(names[0])
    chosen = times[np.unique(np.linspace(0, len(times) - 1, INSTANTS).astype(int))]
    states = [[_thinned(run.fields(name, time)) for name in names] for time in chosen]
    start = [fields["position"] for fields in states[0]]
    values = [
        np.concatenate(
            [values_of(body, fields, quantity, at) for body, fields, at in zip(described, bodies, start, strict=True)]
        )
        for bodies in states
    ]
    colours = limits(values)
    flat = _Flat(run.stored.thin, [fields["position"] for bodies in states for fields in bodies])
    down, width, height = flat.arrangement(len(chosen))
    across, tall = -(-len(chosen) // down), height * down + 0.75
    figure, drawn = panels(len(chosen), across, height=tall, layout="compressed", sharex=True, sharey=True)
    for axes, bodies, shown, time in zip(drawn, states, values, chosen, strict=True):
        together = np.concatenate([fields["position"] for fields in bodies])
        there = np.concatenate([_there(fields) for fields in bodies])
        flat.draw(axes, together[there], shown[there], width, colours)
        for skin in skins:
            flat.draw_skin(axes, run.fields(skin, float(time))["position"], run.cells(skin).lines)
        axes.set_title(f"t = {time:.4g} s")
    colour_bar(figure, with_unit(*meaning(described, quantity)), colours, colours.palette, shrink=0.9)
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

    def draw(self, axes: Axes, position: np.ndarray, values: np.ndarray, width: float, colours: Limits) -> None:
        paper = position[:, self.flat]
        extent = self.high - self.low
        spacing = np.sqrt(np.prod(np.ptp(paper, axis=0) + 1e-300) / len(paper)) if len(paper) else 0.0  # all may have left
        spacing *= width * 72.0 / extent[0]
        size = (1.15 * float(np.clip(spacing, 1.0, 8.0))) ** 2  # circles a little larger than the gaps between them
        x, y = paper.T
        axes.scatter(x, y, c=values, s=size, linewidths=0, cmap=colours.palette, vmin=colours.low, vmax=colours.high)
        axes.set(xlim=(self.low[0], self.high[0]), ylim=(self.low[1], self.high[1]), aspect="equal")
        axes.locator_params(nbins=MOST_TICKS)  # else there are more after the layout, with longer labels that find no room
        axes.grid(False)
        label(axes, "xyz"[self.flat[0]], "xyz"[self.flat[1]], "m", "m")
        axes.label_outer()

    def draw_skin(self, axes: Axes, position: np.ndarray, lines: np.ndarray) -> None:
        """A film as a dark line, light at its sides, so that it stands out from every colour."""
        from matplotlib.collections import LineCollection

        for width, colour in ((3.2, "white"), (1.6, INK)):
            drawn = LineCollection(position[:, self.flat][lines], linewidths=width, colors=colour, capstyle="round")
            axes.add_collection(drawn)


def _there(fields: Fields) -> np.ndarray:
    """Which points have not left the grid: these have no mass any more."""
    return np.asarray(fields["mass"] > 0.0) if "mass" in fields else np.ones(len(fields["position"]), dtype=bool)


def _thinned(fields: Fields) -> Fields:
    stride = -(-len(fields["position"]) // MOST_POINTS)
    return {name: values[::stride] for name, values in fields.items()}
