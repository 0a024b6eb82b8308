"""Pictures, films and plots that a case requests."""

from collections.abc import Iterator
from itertools import cycle
from os.path import commonprefix
from typing import Any

import numpy as np

from pellucid.case.picture import Picture, Pictured
from pellucid.case.plot import Panel, Plot
from pellucid.results.pictures.annotations import Axes, Figure, Run
from pellucid.results.pictures.bodies_in_plane import PlaneStage
from pellucid.results.pictures.bodies_in_space import SpaceStage, through_the_middle
from pellucid.results.pictures.case_module import noticed
from pellucid.results.pictures.curves_in_plane import CurveStage, are_curves
from pellucid.results.pictures.films import Animation
from pellucid.results.pictures.instants import evenly, recorded
from pellucid.results.pictures.mirrors import mirrors_at
from pellucid.results.pictures.quantities import Look, Slice
from pellucid.results.pictures.rendering.axes import INK
from pellucid.results.pictures.rendering.camera import Plane, View
from pellucid.results.pictures.stage import Stage, film_of, side_by_side
from pellucid.results.pictures.stopped import mark_stop
from pellucid.results.pictures.style import COLOURS, LINES, new_panels, plain, with_unit
from pellucid.units import to_si

INSTANTS = 4
MARKS = "osD^v"
ABOVE: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0)}


def bodies_at(run: Run, look: Look, times: np.ndarray | None = None) -> Figure:
    """Return a figure of the bodies at the given times [s]; by default at a few times from the first frame to the last. look:
    settings of the picture."""
    chosen = evenly(_frames(run, look), INSTANTS) if times is None else times
    return side_by_side(_stage(run, look, chosen), chosen.tolist())


def picture(run: Run, asked: Picture) -> Figure:
    """Draw the bodies at several times, as the entry `asked` of `picture` in the case requests; return the figure."""
    look = _look(run, asked)
    frames = _frames(run, look)
    times = [*asked.times, *_extremes(run, asked)]
    return bodies_at(run, look, recorded(frames, times) if times else evenly(frames, asked.instants or INSTANTS))


def films(run: Run, notices: list[str]) -> dict[str, Animation]:
    """Return the films that the case requests (tables `film`), by name; append to `notices` the reason for each film that
    cannot be drawn."""
    found = {}
    for asked in run.stored.film:
        with noticed(notices, asked.name):
            look = _look(run, asked)
            times = evenly(_frames(run, look), asked.pictures)
            found[asked.name] = film_of(_stage(run, look, times), times.tolist())
    return found


def _stage(run: Run, look: Look, times: np.ndarray) -> Stage:
    if look.slice is None and are_curves(run, look.names):
        return CurveStage(run, look, times)
    is_flat = any(run.stored.thin) or look.slice is not None
    return PlaneStage(run, look, times) if is_flat else SpaceStage(run, look, times)


def _frames(run: Run, look: Look) -> np.ndarray:
    return run.times(look.names[0] if look.names else run.stored.bodies[0].name)


def _look(run: Run, asked: Pictured) -> Look:
    cut, camera = asked.cut, asked.camera
    plane = None
    if cut is not None:
        normal = np.array(cut.normal) / np.linalg.norm(cut.normal)
        if cut.through is not None:
            place = run.fields(cut.through, 0.0, ("position",))["position"]
            plane = through_the_middle([(place.min(axis=0), place.max(axis=0))], tuple(normal))
        else:
            plane = Plane(tuple(normal), float(normal @ np.array(cut.at)))
    view = View(camera.turn, camera.rise)
    mirrors = mirrors_at(asked.mirror, run.stored.grid)
    colours = asked.quantity, asked.component, asked.unit, asked.limits
    window = None if asked.window is None else (np.array(asked.window.lower), np.array(asked.window.upper))
    look = Look(*colours, asked.bodies, view, plane, mirrors=mirrors, arrows=asked.arrows)
    return look._replace(slice=_slice(run, asked), window=window)


def _slice(run: Run, asked: Pictured) -> Slice | None:
    if asked.slice is None:
        return None
    thickness = asked.slice.thickness or (run.stored.grid.cell if run.stored.grid is not None else 0.0)
    return Slice("xyz".index(asked.slice.across), asked.slice.at, 0.5 * thickness)


def _extremes(run: Run, asked: Picture) -> Iterator[float]:
    for name, find in ((asked.largest, np.nanargmax), (asked.smallest, np.nanargmin)):
        if name is not None:
            yield float(run.history["time"][find(run.history[name])])


def plot(run: Run, asked: Plot) -> Figure:
    """Draw a plot as the entry `asked` of `plot` in the case requests, and return the figure: columns of the history,
    curves from files, and below, if requested, the difference between the columns and the first of these curves."""
    shown = (asked, *asked.beside)
    rows = 2 if any(panel.difference for panel in shown) else 1
    room: dict[str, Any] = {"squeeze": False, "height_ratios": (3, 1)[:rows]}
    figure, axes = new_panels(rows, len(shown), height=3.8 if rows == 1 else 5.2, **room)
    for panel, column in zip(shown, axes.T, strict=True):
        _draw_panel(run, panel, column[0], narrow=len(shown) > 2)
        if panel.difference:
            _draw_difference(run, panel, column[1])
            column[1].sharex(column[0])
            column[0].set_xlabel("")
            column[0].tick_params(labelbottom=False)
        elif rows == 2:
            column[1].remove()
    return figure


def _draw_panel(run: Run, asked: Panel, axes: Axes, narrow: bool) -> None:
    """Draw the columns of the history and the measured curves (curves from files) of the panel `asked` of a plot.

    narrow: True if the panel has little width; a legend of more than two entries is then placed above it.
    """
    (x_si, x_unit, x_size), (y_si, y_unit, y_size) = _units(run, asked)
    lines, marks, reach = cycle(LINES), cycle(MARKS), run.history[asked.x]
    for number, name in enumerate(asked.y):
        line = LINES[number // len(COLOURS) % len(LINES)]
        places, values = run.curve(name, asked.x)
        mark = "o" if np.sum(~np.isnan(values)) == 1 else ""
        axes.plot(places / x_size, values / y_size, line + mark, label=name.replace("_", " "))
    for curve in asked.measured:
        x, y, deviation = curve.read(x_si, y_si)
        if curve.line:  # as far as the run has come
            reached = np.clip(x, np.nanmin(reach), np.nanmax(reach))
            x, y = reached, np.where(reached == x, y, np.interp(reached, x, y))
        look: dict[str, Any] = {"color": INK, "markersize": 4.5, "markerfacecolor": "none", "capsize": 2.5, "linewidth": 0.9}
        bars = None if deviation is None else deviation / y_size
        form = next(lines if curve.line else marks)
        axes.errorbar(x / x_size, y / y_size, bars, fmt=form, label=plain(curve.title), zorder=3, **look)
    if asked.y_limits is not None:
        axes.set_ylim(asked.y_limits)
    common = commonprefix(asked.y).rstrip("_-")  # noqa: RUF071 names, not paths
    axes.set(xlabel=_abscissa(asked, x_unit), ylabel=plain(asked.y_label) or with_unit(common, y_unit))
    entries = len(asked.y) + len(asked.measured)
    if entries > 1:
        axes.legend(**(ABOVE if narrow and entries > 2 else {}))
    if asked.x == "time":
        mark_stop(run, axes)


def _draw_difference(run: Run, asked: Panel, axes: Axes) -> None:
    """Plot the columns of the panel `asked` minus its first measured curve, where both are defined."""
    (x_si, x_unit, x_size), (y_si, y_unit, y_size) = _units(run, asked)
    x, y, _ = asked.measured[0].read(x_si, y_si)
    for name in asked.y:
        places, values = run.curve(name, asked.x)
        axes.plot(places / x_size, (values - np.interp(places, x, y, np.nan, np.nan)) / y_size)
    axes.set(xlabel=_abscissa(asked, x_unit), ylabel=with_unit("difference", y_unit))


def _abscissa(asked: Panel, unit: str) -> str:
    """Return the label of the abscissa of a panel, with the displayed unit `unit`."""
    return plain(asked.x_label) or with_unit(asked.x, unit)


def _units(run: Run, asked: Panel) -> Iterator[tuple[str, str, float]]:
    """Yield (SI unit, displayed unit, size of the displayed unit in SI units) for the abscissa of a panel, then for its
    ordinate."""
    for column, shown in ((asked.x, asked.x_unit), (asked.y[0], asked.y_unit)):
        si = "" if run.units[column] == "1" else run.units[column]
        unit = shown or si
        yield si, unit, to_si(f"1 {unit}", si) if unit else 1.0
