"""Pictures, films and plots that a case requests, or that the Python module of its gallery case draws."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import cycle
from os.path import commonprefix
from typing import Any

import numpy as np

from pellucid import catalogue
from pellucid.case.picture import Picture, Pictured
from pellucid.case.plot import Panel, Plot
from pellucid.errors import UsageError
from pellucid.results.pictures.bodies_in_plane import CurveStage, PlaneStage, are_curves
from pellucid.results.pictures.bodies_in_space import SpaceStage, through_the_middle
from pellucid.results.pictures.camera import INK, Plane, View
from pellucid.results.pictures.films import Animation, Stage, evenly, film_of, recorded, side_by_side
from pellucid.results.pictures.quantities import Look, Slice
from pellucid.results.pictures.stopped import mark_stop
from pellucid.results.pictures.style import COLOURS, LINES, Axes, Figure, Run, new_panels, plain, with_unit
from pellucid.results.pictures.surroundings import mirrors_at
from pellucid.results.storage.files import OutputError
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


def drawn_by_module(run: Run, kind: str) -> dict[str, Any]:
    """Return the figures or the films (`kind`: "figures" or "films") that the Python module of the gallery case defines, by
    name.

    A figure is a matplotlib figure or a function that returns one; a film is an `Animation`. The result is empty if the case
    has no module. It is also empty, with a warning, if the module cannot draw this run.
    """
    make = getattr(catalogue.module(run.stored.id), kind, None)
    try:
        return dict(make(run)) if make else {}
    except Exception as error:  # a run stopped early or changed by settings may be none that the module can draw
        _warn(run, kind, error)
        return {}


def drawn(run: Run, figure: "Figure | Callable[[], Figure]") -> "Figure | None":
    """Return a figure that the Python module of the gallery case provides; `figure` is the figure or a function that
    returns the figure. Return None, with a warning, if the module cannot draw this run."""
    try:
        return figure() if callable(figure) else figure
    except OutputError:
        raise
    except Exception as error:
        _warn(run, "figures", error)
        return None


def _warn(run: Run, kind: str, error: Exception) -> None:
    warnings.warn(f"the {kind} of {run.stored.id} could not be drawn for this run: {error}", stacklevel=3)


@contextmanager
def noticed(notices: list[str], name: str = "") -> Iterator[None]:
    """Skip the picture drawn in the block if its files are damaged or missing, or if it would be empty, and append the reason
    to `notices`. name: name of the picture, put before the reason."""
    try:
        yield
    except (OutputError, UsageError) as error:
        text = str(error) if isinstance(error, OutputError) or not name else f"{name}: {error}"  # damage stops them all
        if text not in notices:
            notices.append(text)


def captions(run: Run) -> dict[str, str]:
    """Return the captions of the figures and films that the module of the gallery case draws, by name; empty if the module
    has no captions."""
    return dict(getattr(catalogue.module(run.stored.id), "CAPTIONS", {}))
