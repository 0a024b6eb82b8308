"""Pictures of a sheet and of what falls on it, of which a quarter, x and y above zero, is computed."""

from collections.abc import Iterable

import numpy as np

from pellucid.results.pictures.annotations import Axes, Figure, Run
from pellucid.results.pictures.films import Animation
from pellucid.results.pictures.instants import evenly, recorded
from pellucid.results.pictures.rendering.axes import corner_words, scale_bar, show
from pellucid.results.pictures.rendering.camera import Camera, View, camera_for
from pellucid.results.pictures.rendering.drawables import Balls, Colour, Drawable, Mesh
from pellucid.results.pictures.rendering.points import ball_radii
from pellucid.results.pictures.rendering.render import render
from pellucid.results.pictures.style import WIDTH, new_figure

SHEET: Colour = (0.36, 0.76, 0.77)
SPHERE: Colour = (0.80, 0.62, 0.40)
IMAGES = np.array([(1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, 1)])
"""Signs of x, y, z."""
PANEL_COLUMNS = 900
FILM_COLUMNS, FILM_PICTURES = 600, 26


def panels(run: Run, view: View, times: Iterable[float]) -> Figure:
    """Pictures of the frames nearest to some instants [s], two in a row."""
    chosen = recorded(run.times("sheet"), times)
    camera = camera_for(view, _places(run, chosen), PANEL_COLUMNS)
    rows, columns = -(-len(chosen) // 2), 2
    high, wide = camera.shape
    figure = new_figure(height=WIDTH / columns * high / wide * rows)
    for axes, time in zip(figure.subplots(rows, columns, squeeze=False).flat, chosen, strict=False):
        draw(axes, run, float(time), camera)
    for axes in figure.axes[len(chosen) :]:
        axes.set_axis_off()
    return figure


def film(run: Run, view: View) -> Animation:
    """Sheet and sphere from the start to the end."""
    times = evenly(run.times("sheet"), FILM_PICTURES)
    camera = camera_for(view, _places(run, times), FILM_COLUMNS)

    def picture(time: float) -> Figure:
        rows, columns = camera.shape
        figure = new_figure(WIDTH / 2, WIDTH / 2 * rows / columns)
        draw(figure.subplots(), run, time, camera)
        return figure

    return Animation(picture, times)


def draw(axes: Axes, run: Run, time: float, camera: Camera) -> None:
    """Draw the frame nearest to a time [s]."""
    quarter, sphere = run.fields("sheet", time)["position"], run.fields("sphere", time)
    sheet, triangles = _mirrored(quarter), run.triangles("sheet")
    triangles = np.concatenate([triangles + image * len(quarter) for image in range(len(IMAGES))])
    # one ball of the volume of all points: it deforms by micrometres, and the points' own balls would stick through the sheet
    mass = len(IMAGES) * sphere["mass"].sum()
    radius = ball_radii(mass, sphere["density"][0])
    middle = np.array([[0.0, 0.0, np.average(sphere["position"][:, 2], weights=sphere["mass"])]])
    drawn: list[Drawable] = [
        Mesh(sheet, triangles, np.tile(SHEET, (len(sheet), 1)), np.zeros(len(sheet), bool)),
        Balls(middle, np.array([float(radius)]), np.array([SPHERE])),
    ]
    show(axes, render(drawn, camera, None), camera)
    scale_bar(axes, camera)
    times = run.times("sheet")
    corner_words(axes, f"{1e3 * float(times[np.argmin(np.abs(times - time))]):.2f} ms", "")


def _places(run: Run, times: Iterable[float]) -> np.ndarray:
    quarter = [run.fields(name, float(time))["position"] for time in times for name in ("sheet", "sphere")]
    return _mirrored(np.concatenate(quarter))


def _mirrored(quarter: np.ndarray) -> np.ndarray:
    """Places [m], shape (n, 3), and their images in the planes of symmetry, shape (4 n, 3)."""
    return np.concatenate([quarter * image for image in IMAGES])
