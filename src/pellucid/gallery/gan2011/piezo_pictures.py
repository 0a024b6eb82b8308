"""Pictures of the oocyte that a pipette pushes sideways: as a whole, without its upper half so that the inside is visible ("cut
open"), and as a film."""

from collections.abc import Callable, Iterable
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from pellucid.bodies.membrane_points.model import MembranePointsCase
from pellucid.results.pictures.camera import Camera, Plane, View, camera_for, coloured, corner_words, scale_bar, show
from pellucid.results.pictures.drawables import (
    Balls,
    Colour,
    Drawable,
    Mesh,
    Section,
    ball_radii,
    bricks,
    lattice_sides,
)
from pellucid.results.pictures.films import Animation, evenly, recorded
from pellucid.results.pictures.render import render, rim, section
from pellucid.results.pictures.style import WIDTH, Axes, Figure, Run, colour_bar, new_figure, panels, settle

INSTANTS = (28e-6, 52e-6, 76e-6, 100e-6)
"""Times of the pictures in the paper [s]."""

CAPTIONS = {
    "oocyte": "The zona, whole and cut open along the path of the pipette; failed parts in red.",
    "oocyte_whole": "Zona, pipette and holding plate at the instants of the paper's pictures; failed parts of the zona in red.",
    "oocyte_cut": "The same instants, cut open along the path of the pipette: zona with its true thickness, pressure in "
    "the cytoplasm averaged over neighbouring points, and points of the medium in the layer of cells below the cut.",
}

WHOLE, CUT = View(-48.0, 24.0), View(-90.0, 60.0)
SPARE = 1.06  # room that a picture leaves for the oocyte to bulge
COLUMNS, FILM_COLUMNS = 1000, 520  # pixels, about twice those that a panel has in the figure: smooth edges
FILM_PICTURES = 26

ZONA: Colour = (0.36, 0.76, 0.77)
RIM: Colour = (0.05, 0.45, 0.50)
FAILED: Colour = (0.92, 0.10, 0.09)
FAILED_INK = "#C21A17"
PIPETTE: Colour = (0.90, 0.90, 0.92)
PLATE: Colour = (0.17, 0.27, 0.48)
MEDIUM: Colour = (0.66, 0.77, 0.94)
SWELL = 1.25  # of the balls under the pipette's skin, so that it has no holes
DOT = 0.45e-6  # radius of a dot of the medium [m]
PALETTE = "PuOr_r"
"""Colour map of the pressure: two hues about white, different from the colours of the membrane and of failure."""


class Stage(NamedTuple):
    """Settings that the pictures of the oocyte have in common at all times."""

    camera: Camera  # view, extent and size of the picture
    triangles: np.ndarray  # (m, 3) surface triangles of the zona
    plate: np.ndarray  # (3,) distances between the layers of points of the plate along x, y, z [m]
    cut: Plane | None = None  # plane at which the picture cuts the oocyte; None: the oocyte is drawn whole
    limits: tuple[float, float] = (-1.0, 1.0)  # pressures at the ends of the colour scale in the cut [Pa]


def figures(run: Run) -> "dict[str, Callable[[], Figure]]":
    """Return figures by name, as functions that draw them: the oocyte at the times of the paper as a whole, and without its
    upper half."""
    return {"oocyte_whole": partial(oocyte_whole, run), "oocyte_cut": partial(oocyte_cut, run)}


def films(run: Run) -> dict[str, Animation]:
    """Return the film of the oocyte, by name: as a whole and without its upper half, side by side."""
    times = evenly(run.times("zona"), FILM_PICTURES)
    whole, cut = whole_stage(run, FILM_COLUMNS), cut_stage(run, FILM_COLUMNS, times)

    @cache
    def empty() -> Figure:
        figure = new_figure(WIDTH, 4.0)
        figure.subplots(1, 2)
        return figure

    def draw(time: float) -> Figure:
        for axes, stage in zip(empty().axes, (whole, cut), strict=True):
            for shown in (*axes.images, *axes.lines, *axes.texts):
                shown.remove()
            draw_oocyte(axes, run, time, stage)
        settle(empty())
        return empty()

    return {"oocyte": Animation(draw, times)}


def oocyte_whole(run: Run, times: Iterable[float] = INSTANTS) -> Figure:
    """Return a figure of zona, pipette and plate at the given times [s]; failed parts of the zona are red."""
    stage = whole_stage(run, COLUMNS)
    return _panels(run, recorded(run.times("zona"), times), stage)


def oocyte_cut(run: Run, times: Iterable[float] = INSTANTS) -> Figure:
    """Return a figure of the oocyte without its upper half at the given times [s], seen from above; the cut is along the
    pipette's path and shows the pressure in the cytoplasm and the rim of the zona."""
    shown = recorded(run.times("zona"), times)
    stage = cut_stage(run, COLUMNS, shown)
    figure = _panels(run, shown, stage)
    low, high = stage.limits
    colour_bar(figure, "pressure in the cytoplasm [kPa]", (1e-3 * low, 1e-3 * high, "both"), PALETTE, shrink=0.6, aspect=30)
    return figure


def whole_stage(run: Run, columns: int) -> Stage:
    """Return the settings of the view from the side of the pipette. columns: width of the picture in pixels."""
    return _stage(run, camera_for(WHOLE, _places(run), columns))


def cut_stage(run: Run, columns: int, times: Iterable[float]) -> Stage:
    """Return the settings of the view from above into the lower half. columns: width of the picture in pixels. The pressures at
    the given times [s] determine the limits of the colours."""
    middle = float(run.fields("zona", 0.0)["position"][:, 2].mean())
    plane = Plane((0.0, 0.0, 1.0), middle)
    places = _places(run)
    sizes = [np.percentile(np.abs(run.fields("cytoplasm", time, ("pressure",))["pressure"]), 95.0) for time in times]
    largest = float(max(sizes, default=0.0)) or 1.0
    return _stage(run, camera_for(CUT, places[plane.beyond(places) <= 0.0], columns), plane, (-largest, largest))


def draw_oocyte(axes: Axes, run: Run, time: float, stage: Stage) -> None:
    """Draw the oocyte, the pipette and the plate on `axes` in the stored frame nearest to a time [s]. stage: camera, cut and
    colours."""
    zona = run.fields("zona", time, ("position", "failed"))
    failed = zona["failed"] > 0 if "failed" in zona else np.zeros(len(zona["position"]), bool)
    skin = Mesh(zona["position"], stage.triangles, np.tile(ZONA, (len(failed), 1)), failed, FAILED)
    drawn: list[Drawable] = [skin, _pipette(run, time), _plate(run, time, stage)]
    if stage.cut:
        thickness = next(body.thickness for body in run.case.body if isinstance(body, MembranePointsCase))
        inner = run.fields("cytoplasm", time, ("position", "pressure"))
        pressure = section(skin, stage.camera, stage.cut, inner["position"], inner["pressure"])
        drawn.append(Section(stage.cut, coloured(pressure, stage.limits, PALETTE)))
        drawn += [rim(skin, stage.cut, thickness, RIM), _medium(run, time, stage.cut)]
    show(axes, render(drawn, stage.camera, stage.cut), stage.camera)
    scale_bar(axes, stage.camera)
    times = run.times("zona")
    instant = 1e6 * float(times[np.argmin(np.abs(times - time))])
    count = int(failed.sum())
    words = "1 failed point" if count == 1 else f"{count} failed points"
    corner_words(axes, f"{instant:.0f} µs", words if "failed" in zona else "", FAILED_INK if count else "#666677")


def _panels(run: Run, times: np.ndarray, stage: Stage) -> Figure:
    across, down = min(2, len(times)), -(-len(times) // 2)
    rows, columns = stage.camera.shape
    width = WIDTH / (2.2 if across == 2 else 1.6)  # of a panel [inch]
    size = WIDTH * min(1.0, 0.35 + 0.35 * across), down * (width * rows / columns + 0.1)
    figure, subplots = panels(len(times), across, *size, layout="compressed")
    for axes, time in zip(subplots, times, strict=True):
        draw_oocyte(axes, run, float(time), stage)
    return figure


def _stage(run: Run, camera: Camera, cut: Plane | None = None, limits: tuple[float, float] = (-1.0, 1.0)) -> Stage:
    plate = run.fields("plate", 0.0)
    return Stage(camera, run.triangles("zona"), lattice_sides(plate["position"], plate["mass"] / plate["density"]), cut, limits)


def _places(run: Run) -> np.ndarray:
    """Return the positions that a picture must include [m], shape (n, 3): zona and plate at the start, the pipette at all
    times."""
    zona = _position(run, "zona", 0.0)
    middle = zona.mean(axis=0)
    pipette = [_position(run, "pipette", float(time)) for time in evenly(run.times("pipette"), FILM_PICTURES)]
    return np.concatenate([middle + SPARE * (zona - middle), *pipette, _position(run, "plate", 0.0)])


def _position(run: Run, body: str, time: float) -> np.ndarray:
    return run.fields(body, time, ("position",))["position"]


def _pipette(run: Run, time: float) -> Balls:
    body = run.fields("pipette", time, ("position", "mass", "density"))
    radii = SWELL * ball_radii(body["mass"], body["density"])
    return Balls(body["position"], radii, np.tile(PIPETTE, (len(radii), 1)), skin=True)


def _plate(run: Run, time: float, stage: Stage) -> Mesh:
    position = _position(run, "plate", time)
    kept = stage.cut.beyond(position) <= 0.0 if stage.cut else slice(None)
    return bricks(position[kept], stage.plate, PLATE)


def _medium(run: Run, time: float, cut: Plane) -> Balls:
    """Return the points of the medium in the layer of cells below the cut plane at a time [s], as dots."""
    position = _position(run, "medium", time)
    beyond = cut.beyond(position)
    layer = position[(beyond <= 0.0) & (beyond > -run.case.grid.cell)]
    return Balls(layer, np.full(len(layer), DOT), np.tile(MEDIUM, (len(layer), 1)), lit=False)
