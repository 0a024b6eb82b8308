"""Pictures of the oocyte that a pipette pushes sideways: whole, and cut open along the pipette's path."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.results.scenes.render import render
from pellucid.results.scenes.scene import (
    View,
    ball_radii,
    box_corners,
    camera_for,
    coloured,
    rim,
    scale_bar,
    section,
    show,
)
from pellucid.results.scenes.things import Balls, Camera, Colour, Mesh, Plane, Section, Thing
from pellucid.results.style import WIDTH, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pellucid.results.run import Run

INSTANTS = (28e-6, 52e-6, 76e-6, 100e-6)
"""Those of the paper's pictures [s]."""

WHOLE, CUT = View(-48.0, 24.0), View(-90.0, 56.0)

ZONA: Colour = (0.42, 0.78, 0.79)
RIM: Colour = (0.05, 0.45, 0.50)
FAILED: Colour = (0.86, 0.10, 0.10)
PIPETTE: Colour = (0.90, 0.90, 0.92)
PLATE: Colour = (0.17, 0.27, 0.48)
MEDIUM = np.array([0.55, 0.70, 0.92])
DOT = 0.45e-6  # radius of a dot of the medium [m]
PALETTE = "PuOr_r"
"""Of the pressure: two hues about white, neither of them the membrane's or that of failure."""


class Stage(NamedTuple):
    """What does not change from picture to picture."""

    camera: Camera
    plane: Plane | None
    limits: tuple[float, float]


def oocyte_whole(run: "Run", times: Sequence[float] = INSTANTS) -> "Figure":
    """The oocyte, the pipette and the plate at some instants [s]; failed parts of the zona in red."""
    figure = new_figure(WIDTH, 7.4)
    stage = stage_for(run, WHOLE, columns=1000)
    for axes, time in zip(figure.subplots(2, 2).flat, times, strict=False):
        draw(axes, run, time, stage)
    return figure


def oocyte_cut(run: "Run", times: Sequence[float] = INSTANTS) -> "Figure":
    """The lower half at some instants [s], cut along the pipette's path: the pressure in the cytoplasm, the zona's rim."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    figure = new_figure(WIDTH, 7.4)
    stage = stage_for(run, CUT, columns=1000, cut=True, times=times)
    panels = figure.subplots(2, 2)
    for axes, time in zip(panels.flat, times, strict=False):
        draw(axes, run, time, stage)
    low, high = stage.limits
    scale = ScalarMappable(Normalize(1e-3 * low, 1e-3 * high), PALETTE)
    bar = figure.colorbar(scale, ax=panels, shrink=0.6, aspect=30, pad=0.01)
    bar.set_label("pressure in the cytoplasm [kPa]")
    bar.outline.set_visible(False)
    return figure


def stage_for(run: "Run", view: View, columns: int, cut: bool = False, times: Sequence[float] = ()) -> Stage:
    """A stage that holds the bodies at the start and wherever the pipette goes."""
    bodies = [run.fields(name, 0.0)["position"] for name in ("zona", "pipette", "plate")]
    everything = np.concatenate(bodies)
    middle, half = bodies[0].mean(axis=0), 0.5 * np.ptp(bodies[0][:, 2])
    lower, upper = everything.min(axis=0), everything.max(axis=0)
    plane = Plane((0.0, 0.0, 1.0), float(middle[2])) if cut else None
    if plane:
        upper[2] = middle[2]
    ball = middle + 1.12 * half * np.array([[np.cos(a), np.sin(a), 0.0] for a in np.linspace(0.0, 6.2, 24)]) @ view.axes()
    corners = box_corners(lower, upper) if cut else box_corners(bodies[2].min(axis=0), bodies[2].max(axis=0))
    camera = camera_for(view, np.concatenate([corners, bodies[1], ball]), columns)
    pressures = [run.fields("cytoplasm", time)["pressure"] for time in times]
    size = float(np.percentile(np.abs(pressures), 99.0)) if pressures else 1.0
    return Stage(camera, plane, (-size, size))


def draw(axes: "Axes", run: "Run", time: float, stage: Stage) -> None:
    """Draw the frame nearest to a time [s]."""
    frames = run.times("zona")
    instant = float(frames[np.argmin(np.abs(frames - time))])
    zona = run.fields("zona", time)
    triangles = run.triangles("zona")
    failed = zona.get("failed", np.zeros(len(zona["mass"]))) > 0
    skin = Mesh(zona["position"], triangles, np.tile(ZONA, (len(failed), 1)), failed, FAILED)
    things: list[Thing] = [skin, _balls(run, "pipette", time, PIPETTE), _balls(run, "plate", time, PLATE)]
    if stage.plane:
        thickness = next(body.thickness for body in run.case.body if body.name == "zona")
        inner = run.fields("cytoplasm", time)
        pressure = section(skin, stage.camera, stage.plane, inner["position"], inner["pressure"])
        things += [
            Section(stage.plane, coloured(pressure, stage.limits, PALETTE)),
            rim(skin, stage.plane, thickness, RIM),
            _dots(run, time, stage.plane),
        ]
    show(axes, render(things, stage.camera, stage.plane), stage.camera)
    scale_bar(axes, stage.camera, 20e-6, "20 µm")
    count = int(failed.sum())
    text = f"{1e6 * instant:.0f} µs"
    axes.set_title(text, loc="left", fontsize=11, fontweight="bold", pad=2)
    note = f"{count} failed points" if count != 1 else "1 failed point"
    axes.text(0.985, 0.985, note, transform=axes.transAxes, ha="right", va="top", fontsize=8.5, color=FAILED if count else "#667")


def _balls(run: "Run", name: str, time: float, colour: Colour) -> Balls:
    body = run.fields(name, time)
    return Balls(body["position"], ball_radii(body["mass"], body["density"]), np.tile(colour, (len(body["mass"]), 1)))


def _dots(run: "Run", time: float, plane: Plane) -> Balls:
    """The points of the medium in the layer below the plane."""
    cell = run.case.grid.cell
    position = run.fields("medium", time)["position"]
    beyond = plane.beyond(position)
    layer = position[(beyond <= 0.0) & (beyond > -cell)]
    return Balls(layer, np.full(len(layer), DOT), np.tile(MEDIUM, (len(layer), 1)), lit=False)
