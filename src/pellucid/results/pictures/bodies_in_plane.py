"""Pictures of bodies in one or two dimensions: dots at their points, coloured by a field, and films as curves in the plane or
as meridians with their mirror images."""

from functools import partial
from itertools import repeat

import numpy as np

from pellucid.errors import UsageError
from pellucid.results.pictures.camera import INK, UNCOLOURED
from pellucid.results.pictures.quantities import (
    BY_BODY,
    Fields,
    Look,
    colours_of,
    explain,
    is_film,
    limits_of,
    there,
    values_of,
)
from pellucid.results.pictures.style import COLOURS, Axes, Figure, Run, instant, label, new_panels
from pellucid.results.pictures.surroundings import (
    cells_with_images,
    draw_walls,
    in_box,
    places_unmoved,
    with_images,
    with_mirrored,
)
from pellucid.results.storage.probes import scalar
from pellucid.state import FIELDS

MOST_TICKS = 5
MOST_POINTS = 60_000
"""Largest number of points in a picture; of more points, an evenly spaced subset is drawn."""

PROFILES = ("density", "velocity", "pressure", "internal_energy")


def profiles(run: Run, axis: int) -> Figure:
    """Plot density, velocity, pressure and specific internal energy of all points in the last frame against the position along
    an axis (0, 1 or 2).

    Fields that a body does not have are omitted. Returns the figure.
    """
    names = [body.name for body in run.stored.bodies]
    bodies = {name: _thinned(run.fields(name)) for name in names}
    wanted = [field for field in PROFILES if all(field in fields for fields in bodies.values())]
    component, title = "xyz"[axis], f"All points at t = {run.times(names[0])[-1]:.4g} s"
    figure, grid = new_panels(2, 2, sharex=True, height=5.6, title=title)
    for axes, field in zip(grid.flat, wanted, strict=False):
        for name, colour in zip(names, COLOURS * len(names), strict=False):
            fields = {key: values[there(bodies[name])] for key, values in bodies[name].items()}
            values = scalar(fields[field], component if fields[field].ndim > 1 else None)
            axes.plot(fields["position"][:, axis], values, ".", markersize=2, color=colour, label=name)
        label(axes, component, field, "m", FIELDS[field].unit)
    for axes in list(figure.axes)[len(wanted) :]:
        axes.remove()
    figure.axes[0].legend(markerscale=5)
    return figure


class PlaneStage:
    """Object that draws the bodies of a plane case, or a slice of bodies in space, as dots at their points, with the same
    scales in all pictures of a figure (a `Stage`).

    Fluid films among the bodies are drawn as dark lines on top. look: settings of the picture. times: times of all pictures
    [s], from which the scales follow.
    """

    def __init__(self, run: Run, look: Look, times: np.ndarray) -> None:
        bodies = [body for body in run.stored.bodies if body.name in (look.names or {body.name})]
        self._run, self._look, self._beside = run, look, dict[str, np.ndarray]()
        sliced = look.slice is not None
        self._bodies = [body for body in bodies if sliced or not is_film(body)]
        self._skins = [body.name for body in bodies if is_film(body) and not sliced]
        thin = [axis == look.slice.axis for axis in range(3)] if look.slice is not None else run.stored.thin
        self._flat = [axis for axis in range(3) if not thin[axis]]
        self._start = {body.name: places_unmoved(self._fields(body.name, 0.0)) for body in self._bodies}
        states = [of_body for time in times for of_body in self._state(float(time))]
        self._colours = limits_of([values for _, values in states], look)
        skins = [self._skin(name, float(time)) for name in self._skins for time in times]
        paper = np.concatenate([*(place for place, _ in states), *skins])
        if not len(paper):
            raise UsageError("The slice contains no points.\n    Move it, or set a larger `thickness`.")
        low, high = paper.min(axis=0), paper.max(axis=0)
        margin = 0.04 * (high - low).max()
        corners: tuple[np.ndarray, np.ndarray] = look.window or (low - margin, high + margin)
        self._low, self._high = corners
        self._walls = with_mirrored(run.stored.walls, look.mirrors)

    @property
    def ratio(self) -> float:
        """Ratio of height to width of the picture."""
        width, height = self._high - self._low
        return float(height / width)

    def draw(self, axes: Axes, time: float, width: float) -> None:
        """Draw the frame nearest to `time` [s]. width: width of the axes [inch], from which the size of the dots follows."""
        state = self._state(time)
        paper, values = (np.concatenate(part) for part in zip(*state, strict=True))
        spacing = np.sqrt(np.prod(np.ptp(paper, axis=0) + 1e-300) / len(paper)) if len(paper) else 0.0  # all may have left
        spacing *= width * 72.0 / (self._high - self._low)[0]
        size = (1.15 * float(np.clip(spacing, 1.0, 8.0))) ** 2  # circles a little larger than the gaps between them
        if self._look.quantity == BY_BODY:
            for (place, _), colour in zip(state, colours_of(body.name for body in self._bodies).values(), strict=True):
                axes.scatter(place[:, 0], place[:, 1], s=size, color=colour, linewidths=0)
        else:
            self._draw_values(axes, paper, values, size)
        for name in self._skins:
            place = self._skin(name, time)
            cells = cells_with_images(self._run.cells(name), len(place) // 2 ** len(self._look.mirrors), self._look.mirrors)
            self._draw_skin(axes, place, cells.lines)
        at = self._look.slice.at if self._look.slice is not None else 0.0
        draw_walls(axes, self._walls, time, self._flat, at, (self._low, self._high))
        axes.set(xlim=(self._low[0], self._high[0]), ylim=(self._low[1], self._high[1]), aspect="equal")
        axes.locator_params(nbins=MOST_TICKS)  # else there are more after the layout, with longer labels that find no room
        axes.grid(False)
        label(axes, "xyz"[self._flat[0]], "xyz"[self._flat[1]], "m", "m", instant(time))
        axes.label_outer()

    def _draw_values(self, axes: Axes, paper: np.ndarray, values: np.ndarray, size: float) -> None:
        known, (x, y) = np.isfinite(values), paper.T
        if not known.all():
            axes.scatter(x[~known], y[~known], s=size, color=UNCOLOURED, linewidths=0)
        limited, palette = self._colours, self._colours.palette
        axes.scatter(x[known], y[known], size, values[known], linewidths=0, cmap=palette, vmin=limited.low, vmax=limited.high)

    def bar(self, figure: Figure) -> None:
        """Draw the colour bar of the shown quantity, or a legend if each body has its own colour."""
        explain(figure, self._bodies, self._look, self._colours, shrink=0.9)

    def _state(self, time: float) -> list[tuple[np.ndarray, np.ndarray]]:
        """Collect for each body the positions in the picture [m], shape (n, 2), and the values that colour the points,
        shape (n,); points that have left the grid are omitted."""
        found = []
        for body in self._bodies:
            fields, start = self._fields(body.name, time), self._start[body.name]
            kept = there(fields)
            found.append((fields["position"][kept][:, self._flat], values_of(body, fields, self._look, start)[kept]))
        return found

    def _fields(self, name: str, time: float) -> Fields:
        fields = in_box(self._run.fields(name, time), partial(self._run.cells, name), self._run.stored.grid)
        if (sliced := self._look.slice) is not None:
            if name not in self._beside:
                start = self._run.fields(name, 0.0, ("position",))["position"][:, sliced.axis]
                self._beside[name] = np.abs(start - sliced.at) <= sliced.reach
            fields = {key: values[self._beside[name]] for key, values in fields.items()}
        return with_images(_thinned(fields), self._look.mirrors)

    def _skin(self, name: str, time: float) -> np.ndarray:
        fields = in_box(self._run.fields(name, time, ("position",)), partial(self._run.cells, name), self._run.stored.grid)
        return with_images(fields, self._look.mirrors)["position"][:, self._flat]

    def _draw_skin(self, axes: Axes, position: np.ndarray, lines: np.ndarray) -> None:
        """Draw a fluid film as a dark line with a white margin, which contrasts with every colour. position: of the nodes in
        the picture [m], shape (n, 2). lines: node indices of the line elements, shape (m, 2)."""
        from matplotlib.collections import LineCollection

        for width, colour in ((3.2, "white"), (1.6, INK)):
            drawn = LineCollection(position[lines], linewidths=width, colors=colour, capstyle="round")
            axes.add_collection(drawn)


def _thinned(fields: Fields) -> Fields:
    stride = max(-(-len(fields["position"]) // MOST_POINTS), 1)
    return {name: values[::stride] for name, values in fields.items()}


ARROWS = 40  # on a film, at most
LONGEST = 0.12  # of the picture's width, of an arrow


def are_curves(run: Run, names: tuple[str, ...] = ()) -> bool:
    """Return True if every body of a run, or each of the named bodies, is a fluid film that is a curve: the body has line
    elements and stores an areal density."""
    return all(_is_curve(run, name) for name in names or [body.name for body in run.stored.bodies])


def _is_curve(run: Run, name: str) -> bool:
    cells = run.cells(name)
    return bool(len(cells.lines)) and not len(cells.triangles) and "areal_density" in run.fields(name, 0.0)


class CurveStage:
    """Object that draws fluid films that are curves, with arrows of their velocity and the same scales in all pictures of a
    figure (a `Stage`).

    look: settings of the picture. times: times of all pictures [s], from which the scales follow.
    """

    def __init__(self, run: Run, look: Look, times: np.ndarray) -> None:
        self._run, self._look = run, look
        self._bodies = [body for body in run.stored.bodies if body.name in (look.names or {body.name})]
        states = [self._state(float(time)) for time in times]
        self._lines = [run.cells(body.name).lines for body in self._bodies]
        self._start = [run.fields(body.name, 0.0, ("position",))["position"] for body in self._bodies]
        # the axes of the plane in which a curve lies: x and y, or of a meridian x, which is r, and z
        self._planes = [[0, 1] if np.ptp(fields["position"][:, 1]) > 0.0 else [0, 2] for fields in states[0]]
        places = [_mirrored(f["position"][:, axes], axes) for s in states for f, axes in zip(s, self._planes, strict=True)]
        together = np.concatenate(places)
        self._colours = limits_of([values for state in states for values in self._values(state)], look)
        self._low, self._high = together.min(axis=0), together.max(axis=0)
        self._margin = (LONGEST + 0.02) * float((self._high - self._low).max())

    @property
    def ratio(self) -> float:
        """Ratio of height to width of the picture."""
        return float((self._high - self._low)[1] / (self._high - self._low)[0])

    def draw(self, axes: Axes, time: float, width: float) -> None:
        """Draw the frame nearest to `time` [s] on axes. width: width of the axes [inch]."""
        from matplotlib.collections import LineCollection

        low, high, margin = self._low, self._high, self._margin
        state = self._state(time)
        fastest = max(float(np.linalg.norm(fields["velocity"], axis=1).max()) for fields in state)
        own = colours_of(body.name for body in self._bodies).values() if self._look.quantity == BY_BODY else repeat(None)
        curves = zip(state, self._lines, self._planes, self._values(state), own, strict=False)
        for fields, ends, plane, values, colour in curves:
            place, speed = fields["position"][:, plane], fields["velocity"][:, plane]
            for sign in (1.0, -1.0) if plane == [0, 2] else (1.0,):
                turned = np.array([sign, 1.0])
                drawn = LineCollection(turned * place[ends], linewidths=3.0, capstyle="round", cmap=self._colours.palette)
                if colour is None:
                    drawn.set_array(values[ends].mean(axis=1))
                    drawn.set_clim(self._colours.low, self._colours.high)
                else:
                    drawn.set_color(colour)
                axes.add_collection(drawn)
                if fastest > 0.0:
                    some = slice(None, None, -(-len(place) // ARROWS))
                    arrows = turned * speed[some] * (LONGEST * float((high - low)[0]) / fastest)
                    x, y = (turned * place[some]).T
                    axes.quiver(x, y, *arrows.T, angles="xy", scale_units="xy", scale=1.0, width=0.004, color="#334", zorder=3)
        axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
        axes.grid(False)
        axes.set_title(f"t = {time:.4g} s\nlargest speed {fastest:.3g} m/s")
        around = self._planes[0] == [0, 2]
        label(axes, "r" if around else "x", "z" if around else "y", "m", "m")
        axes.label_outer()

    def bar(self, figure: Figure) -> None:
        explain(figure, self._bodies, self._look, self._colours, shrink=0.9)

    def _state(self, time: float) -> list[Fields]:
        return [self._run.fields(body.name, time) for body in self._bodies]

    def _values(self, state: list[Fields]) -> list[np.ndarray]:
        of = zip(self._bodies, state, self._start, strict=True)
        return [values_of(body, fields, self._look, start) for body, fields, start in of]


def _mirrored(places: np.ndarray, axes: list[int]) -> np.ndarray:
    return np.concatenate([places, places * np.array([-1.0, 1.0])]) if axes == [0, 2] else places
