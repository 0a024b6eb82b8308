"""Figures of a run: figures of its gallery case, bodies, energy balance, momentum and probes."""

from collections.abc import Callable, Sequence
from functools import partial
from io import BytesIO
from textwrap import fill
from typing import NamedTuple

import numpy as np

from pellucid.case.plot import Plot
from pellucid.energy import FIRST_JUDGED
from pellucid.results.pictures.bodies_in_plane import are_curves, profiles
from pellucid.results.pictures.bodies_in_space import is_open_in_front
from pellucid.results.pictures.own import bodies_at, drawn, drawn_by_module, noticed, picture, plot
from pellucid.results.pictures.quantities import Look, is_still
from pellucid.results.pictures.stopped import mark_stop, where_it_stopped
from pellucid.results.pictures.style import DPI, LINES, Figure, Run, label, new_panels, panels, settle

Draw = Callable[[], Figure | None]

MOMENTUM = Plot(name="momentum", y=tuple(f"momentum_{axis}" for axis in "xyz"))
NUMERICAL = ("time", "step", "dt", "energy_error", "inflow_points", "outflow_points")  # columns of the method, not of the case
RESIDUE = ("kinetic_energy", "transfer_error", "time_integration_error")  # of no meaning in a steady state


MARKERS = "os^D"  # beside LINES: colours come again after seven curves

WIDE, EQUAL = (3.2, 1.0), 1.6  # of the first curve of the energies and of the last; of all in a steady state [pt]
SWINGS = 60  # along the time, beyond which lines are drawn thinner
LEAST_SHOWN = 1e-3  # of the largest energy: less is thinner than a line

ROUNDING = 1e-9  # of the largest value: what varies less is constant
SAME = 1e-4  # of the extent of curves: those that differ by less cannot be told apart


class Picture(NamedTuple):
    """A drawn figure for the report: the bytes of the PNG image (`data`) and the title of the figure."""

    data: bytes
    title: str


def figures_of(run: Run, beside: "Run | None", notices: list[str]) -> dict[str, Draw]:
    """Return the functions that draw the figures of a run, by name in the order of the report.

    beside: another run, whose probes of the same names are drawn in the figure of the probes. notices: receives a text for
    each figure that cannot be drawn because files of the run are damaged.
    """
    stopped = where_it_stopped(run)
    figures: dict[str, Draw] = {} if stopped is None else {"where_it_stopped": lambda: stopped}
    figures |= {shown.name: partial(picture, run, shown) for shown in run.stored.picture}
    figures |= {shown.name: partial(plot, run, shown) for shown in run.stored.plot}
    figures |= {name: partial(drawn, run, figure) for name, figure in drawn_by_module(run, "figures").items()}
    with noticed(notices):
        figures |= bodies(run)
    if not all(is_still(body) for body in run.stored.bodies):
        figures["energies"] = lambda: energies(run)
        if run.stored.steady is None and any(np.any(run.history[name] != 0.0) for name in MOMENTUM.y):
            figures["momentum"] = partial(plot, run, MOMENTUM)
    if run.stored.probes:
        figures["probes"] = lambda: columns(run, run.stored.probes, beside=beside)
    if shown := condition_columns(run):
        figures["conditions"] = lambda: columns(run, shown, beside=beside)
    return figures


def picture_of(figure: Figure) -> Picture:
    """Return a figure as PNG data with its title, as included in the report."""
    figure.set_dpi(DPI)
    settle(figure)
    file = BytesIO()
    figure.savefig(file, format="png", dpi=DPI)
    return Picture(file.getvalue(), figure.get_suptitle())


def bodies(run: Run) -> dict[str, Draw]:
    """Return the functions that draw the bodies of a run, by name of the figure.

    Bodies are coloured by speed (in a steady analysis by displacement), and in a second figure by pressure or stress. Solids in
    space have a third and a fourth figure, in which the material in front of a plane through their middle is not drawn; these
    are omitted if a plane of symmetry shows the inside. A case in one dimension has profiles of the fields in the last frame.
    Films that are curves are coloured by density. Bodies at rest have no figure of the speed. If all bodies are lines that are
    not films, there is no figure.
    """
    if are_curves(run):
        return {"bodies": partial(bodies_at, run, Look("load"))}
    if all(len(run.cells(body.name).lines) for body in run.stored.bodies):
        return {}
    if all(is_still(body) for body in run.stored.bodies):
        return {"bodies_load": partial(bodies_at, run, Look("load"))}
    thin, quantities = run.stored.thin, ("displacement" if run.stored.steady else "speed", "load")
    if sum(thin) == 2:
        return {"profiles_of_points": partial(profiles, run, thin.index(False))}
    figures: dict[str, Draw] = {f"bodies_{name}": partial(bodies_at, run, Look(name)) for name in quantities}
    if any(thin):
        return figures
    if any(len(run.cells(body.name).tetrahedra) for body in run.stored.bodies) and not is_open_in_front(run):
        figures |= {f"bodies_{name}_inside": partial(bodies_at, run, Look(name, halved=True)) for name in quantities}
    return figures


def energy_columns(run: Run) -> list[str]:
    """Return the names of the history columns with unit J, except probes: the entries of the energy balance."""
    return [name for name, unit in run.units.items() if unit == "J" and name not in run.stored.probes]


def condition_columns(run: Run) -> list[str]:
    """Return the names of the history columns that conditions (supports, loads and others) write and that no other figure
    shows.

    Examples are columns of enclosed gas, prescribed volumes and points at open faces. Constant columns are omitted, and
    columns whose curve has the same unit and shape as a curve that is already plotted (e.g. absolute and gauge pressure).
    """
    plotted = {name for asked in run.stored.plot for panel in (asked, *asked.beside) for name in (panel.x, *panel.y)}
    known = {*run.stored.probes, *energy_columns(run), *MOMENTUM.y, *NUMERICAL, *plotted}
    drawn, found = sorted(plotted), []
    for name in run.units:
        values = run.history[name]
        if name in known or not np.ptp(values) > ROUNDING * np.max(np.abs(values)):
            continue
        alike = (other for other in drawn if run.units[other] == run.units[name])
        if not any(np.allclose(_between_ends(values), _between_ends(run.history[other]), atol=SAME) for other in alike):
            drawn.append(name)
            found.append(name)
    return found


def _between_ends(values: np.ndarray) -> np.ndarray:
    """Scale values linearly so that the smallest is 0 and the largest is 1."""
    extent = np.ptp(values)
    return (values - np.min(values)) / extent if extent > 0.0 else np.zeros_like(values)


def energies(run: Run) -> Figure:
    """Plot the energy balance: all energies against time, and the relative energy error with the limits of the case.

    In a steady analysis the abscissa is the load time, and works have hollow markers because they often coincide with the
    strain energy. Otherwise each curve is thinner than the curves before it, so that a curve that it covers stays visible
    at its sides.
    """
    figure, (left, right) = new_panels(1, 2, width_ratios=(3, 2), height=4.0)
    times = run.history["time"]
    shown, small = _shown_energies(run)
    widths = _widths(list(shown.values()), run.stored.steady is not None)
    for (words, values), width in zip(shown.items(), widths, strict=False):
        hollow = run.stored.steady is not None and words.endswith(" work")
        marker = {"markersize": 10.0, "fillstyle": "none"} if hollow else {}
        left.plot(times, values, _line(run, len(left.lines) // 7 % 4), label=words, linewidth=width, **marker)
    mark_stop(run, left, "stop")
    mark_stop(run, right)
    label(left, _time(run), "energy", "s", "J")
    right.plot(times, 100.0 * run.history["energy_error"], _line(run), color="black", linewidth=1.0)
    right.axhline(0.0, color="#889", linewidth=0.8)
    label(right, _time(run), "error of the energy balance", "s", "%")
    largest = 100.0 * float(np.nanmax(np.abs(run.history["energy_error"]), initial=0.0))
    warn = 100.0 * run.stored.energy.warn
    if largest > 0.3 * warn:
        judged = times[min(int(np.searchsorted(run.history["step"], FIRST_JUDGED)), len(times) - 1) :]
        if judged[0] < times[-1]:
            line = {"color": "#D55E00", "linestyle": "--", "linewidth": 1.0, "label": "warning limit"}
            right.hlines([-warn, warn], judged[0], times[-1], **line)
    if left.lines or right.collections:
        legend = figure.legend(loc="outside lower center", ncols=5)
        if small:
            entries = ", ".join(f"{words} {largest:.1g} J".replace(" ", "\u00a0") for words, largest in small.items())
            legend.set_title(fill(f"not shown (largest values): {entries}", 120))
    return figure


def _widths(curves: list[np.ndarray], equal: bool) -> list[float]:
    """Return the line width of each energy curve [pt], decreasing from curve to curve.

    curves: energies, one array per curve. All lines are thinner if a curve oscillates so often that its strokes would merge
    into a solid area. equal: give all curves the same width, as in a steady analysis.
    """
    swings = max((int(np.sum(np.diff(np.sign(np.diff(values))) != 0)) for values in curves), default=0)
    share = min(1.0, max(SWINGS / max(swings, 1), 0.4))
    return [EQUAL] * len(curves) if equal else [share * float(width) for width in np.linspace(*WIDE, max(len(curves), 2))]


def _shown_energies(run: Run) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Return the curves of the energy balance [J] by label, and the maximum magnitudes [J] of the entries that are too small to
    be visible and are not drawn, by label.

    The internal energy, and a strain energy that is not zero at the start, are shown as the change since the start: the stored
    energy of a stiff liquid or of a prestrained body can be a million times the kinetic energy.
    """
    curves = {}
    for name in energy_columns(run):
        values, words = run.history[name], name.removesuffix("_energy").replace("_", " ")
        if name == "internal_energy" or (name == "strain_energy" and values[0] != 0.0):
            values, words = values - values[0], f"change of {words}"
        if np.any(values != 0.0) and not (run.stored.steady and name in RESIDUE):
            curves[words] = values
    sizes = {words: float(np.nanmax(np.abs(values), initial=0.0)) for words, values in curves.items()}
    least = LEAST_SHOWN * max(sizes.values(), default=0.0)
    small = {words: size for words, size in sizes.items() if size < least}
    return {words: values for words, values in curves.items() if words not in small}, small


def columns(run: Run, names: Sequence[str], x: str = "time", beside: "Run | None" = None) -> Figure:
    """Plot columns of the history against time or against the column `x`, each on its own axes; return the figure.

    beside: another run; its column of the same name is drawn with each column.
    """
    number = len(names)
    across = 2 if number == 4 else min(3, number)
    figure, drawn = panels(number, across, height=2.8 * -(-number // across))
    for axes, name in zip(drawn, names, strict=True):
        axes.plot(*run.curve(name, x), _line(run))
        if beside and beside.units.get(name) == run.units[name]:
            axes.plot(*beside.curve(name, x), _line(beside, 1))
        if x == "time":
            mark_stop(run, axes)
        label(axes, _time(run) if x == "time" else x, name, run.units[x], run.units[name])
    lines = max((list(axes.lines) for axes in drawn), key=len)
    if beside and len(lines) > 1:
        figure.legend(lines, [_told_apart(run, beside), _told_apart(beside, run)], loc="outside lower center")
    return figure


def _time(run: Run) -> str:
    """Return the label of the time axis: "load time" for a steady analysis (a sequence of equilibria), "time along the path" if
    it follows a path of equilibria, otherwise "time"."""
    if run.stored.steady and run.stored.steady.control == "arc-length":
        return "time along the path"
    return "load time" if run.stored.steady else "time"


def _line(run: Run, number: int = 0) -> str:
    """Return the matplotlib format (line style and marker) of a curve of the history. Curves of a steady analysis and
    curves of a single row have markers.

    number: number of the run in a comparison: 0 for the run of the report, 1 for the run compared with it.
    """
    return LINES[number] + MARKERS[number] if run.stored.steady or len(run.history["time"]) == 1 else LINES[number]


def _told_apart(run: Run, other: Run) -> str:
    """Return the label of `run` in a comparison with the run `other`: the names and kinds of the bodies whose kinds differ
    in the two runs, otherwise the name of the folder of `run`."""
    kinds = {body.name: body.kind for body in other.stored.bodies}
    differing = [f"{body.name}: {body.kind}" for body in run.stored.bodies if kinds.get(body.name) != body.kind]
    return ", ".join(differing) or run.out.name
