"""Pictures, films and plots that a case asks for."""

from collections.abc import Iterator

import numpy as np

from pellucid.case.picture import Picture, Pictured
from pellucid.case.plot import Plot
from pellucid.results.pictures.annotations import Figure, Run
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
from pellucid.results.pictures.style import COLOURS, LINES, label, new_panels
from pellucid.units import to_si

INSTANTS = 4
MARKS = "osD^v"


def bodies_at(run: Run, look: Look, times: np.ndarray | None = None) -> Figure:
    """Bodies at some instants [s], without these at some from the first to the last."""
    chosen = evenly(_frames(run, look), INSTANTS) if times is None else times
    return side_by_side(_stage(run, look, chosen), chosen.tolist())


def picture(run: Run, asked: Picture) -> Figure:
    """A picture of a case."""
    look = _look(run, asked)
    frames = _frames(run, look)
    times = [*asked.times, *_extremes(run, asked)]
    return bodies_at(run, look, recorded(frames, times) if times else evenly(frames, asked.instants or INSTANTS))


def films(run: Run, notices: list[str]) -> dict[str, Animation]:
    """The films of a case, by name; to `notices` comes why one cannot be drawn."""
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
    return Look(*colours, asked.bodies, view, plane, mirrors=mirrors, arrows=asked.arrows, slice=_slice(run, asked))


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
    """A plot of a case: columns of the history, and measured curves with the bars of their deviations."""
    figure, axes = new_panels(height=3.8)
    x_si, y_si = (_si(run.units[name]) for name in (asked.x, asked.y[0]))
    x_unit, y_unit = asked.x_unit or x_si, asked.y_unit or y_si
    x_size, y_size = (to_si(f"1 {unit}", si) if unit else 1.0 for unit, si in ((x_unit, x_si), (y_unit, y_si)))
    for number, name in enumerate(asked.y):
        line = LINES[number // len(COLOURS) % len(LINES)]
        values = run.history[name]
        mark = "o" if np.sum(~np.isnan(values)) == 1 else ""
        axes.plot(run.history[asked.x] / x_size, values / y_size, line + mark, label=name.replace("_", " "))
    for curve, mark in zip(asked.measured, MARKS * len(asked.measured), strict=False):
        x, y, deviation = curve.read(x_si, y_si)
        look = {"color": INK, "markersize": 4.5, "markerfacecolor": "none", "label": curve.title, "capsize": 2.5}
        axes.errorbar(x / x_size, y / y_size, None if deviation is None else deviation / y_size, fmt=mark, zorder=3, **look)
    several = len(asked.y) + len(asked.measured) > 1
    label(axes, asked.x, asked.y[0] if len(asked.y) == 1 else "", x_unit, y_unit, legend=several)
    if len(asked.y) > 1:
        axes.set_ylabel(f"[{y_unit}]" if y_unit else "")
    return figure


def _si(unit: str) -> str:
    """The unit of a column of the history as cases say it."""
    return "" if unit == "1" else unit
