"""Drawing of bodies at several times with the same scales, side by side or as a film: an animated GIF, which needs only
pillow, a dependency of matplotlib."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from pellucid.results.pictures.style import WIDTH, Axes, Figure, new_figure, panels
from pellucid.results.storage.files import drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL.Image import Image


FILM_DPI = 96
FRAME, HOLD = 120, 1500  # ms that a picture stays, and the last one
COLOURS = 256
NEARLY_WHITE = 244
SAMPLES = 6  # pictures whose pixels make the palette of the film; of more pictures it takes as many pixels, from each some
ALIKE = 8  # levels of a channel that are one colour as the palette is chosen
WEIGHT = 1.0 / 3.0  # power of the number of pixels with which a colour counts
ROUNDS = 3  # in which the palette moves to the means of what it stands for


class Animation(NamedTuple):
    """A film of a run: `draw(time)` returns the figure that shows the run at a time [s], `times` are the times of the
    pictures in order [s]. All figures have the same size."""

    draw: "Callable[[float], Figure]"
    times: Iterable[float]


def pixels_of(figure: "Figure") -> np.ndarray:
    """Return the RGB pixels of a figure, shape (rows, columns, 3)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure.set_dpi(FILM_DPI)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def write_film(pictures: Sequence[np.ndarray], path: Path) -> None:
    """Write a film as animated GIF to `path`. pictures: RGB pixels of each frame, all of one shape (rows, columns, 3). Raises
    ValueError for a film without pictures."""
    from PIL.Image import Dither, fromarray

    if not pictures:
        raise ValueError("an animation requires at least one frame")
    images = [fromarray(picture) for picture in pictures]
    palette = _palette(images)
    # one palette and no dithering: what does not change between pictures is not stored again
    first, *others = [image.quantize(palette=palette, dither=Dither.NONE) for image in images]
    durations = [FRAME] * len(others) + [HOLD]
    with drawing(path) as temporary:
        first.save(temporary, format="GIF", save_all=True, append_images=others, duration=durations, loop=0)


def _palette(pictures: "list[Image]") -> "Image":
    """Return a colour table (an image with a palette) for all pictures of a film; a GIF has at most 256 colours.

    Mean colours would tint white areas; such colours are replaced by white. Each colour is weighted by a power of its number of
    pixels. If weighted by the number itself, the few pixels of a small hot spot would get no colour of their own.
    """
    from PIL.Image import Quantize, fromarray

    stride = -(-len(pictures) // SAMPLES)
    pixels = np.concatenate([np.asarray(picture).reshape(-1, 3)[k % stride :: stride] for k, picture in enumerate(pictures)])
    red, green, blue = (pixels // ALIKE).astype(np.int64).T
    levels = 256 // ALIKE
    which = (red * levels + green) * levels + blue
    count = np.bincount(which, minlength=levels**3)
    found = np.flatnonzero(count)
    count = count[found]
    means = np.stack([np.bincount(which, channel, levels**3)[found] / count for channel in pixels.T], axis=1)
    weighted = np.repeat(means.round().astype(np.uint8), np.rint(count**WEIGHT).astype(int), axis=0)
    palette = fromarray(weighted[None]).quantize(COLOURS, method=Quantize.MEDIANCUT, kmeans=ROUNDS)
    colours = np.reshape(palette.getpalette() or [], (-1, 3))
    colours[colours.min(axis=1) >= NEARLY_WHITE] = 255
    palette.putpalette(colours.ravel().tolist())
    return palette


MOST_HEIGHT = 7.0  # of the panels together [inch]
BAR, WORDS = 1.4, 0.3  # beside the panels, and above each [inch]
FILM_SIDE = 5.5  # of a picture of a film, at most [inch]


class Stage(Protocol):
    """Object that draws the bodies of a run at any time; all pictures of a figure or film have the same scales of position
    and colour. Figures and films are composed with it (`side_by_side`, `film_of`)."""

    @property
    def ratio(self) -> float:
        """Ratio of height to width of a picture."""

    def draw(self, axes: Axes, time: float, width: float) -> None:
        """Draw the frame nearest to a time [s] on axes; width: width of the axes [inch]."""

    def bar(self, figure: Figure) -> None:
        """Draw the colour bar of the shown quantity, or a legend if each body has its own colour."""


def side_by_side(stage: Stage, times: Sequence[float]) -> Figure:
    """Return a figure of the bodies at several times [s], one panel each, as large as the page allows."""
    down, width = _arrangement(stage.ratio, len(times))
    across = -(-len(times) // down)
    size = {"width": min(WIDTH, across * width + BAR), "height": down * (width * stage.ratio + WORDS) + 0.75}
    figure, drawn = panels(len(times), across, layout="compressed", sharex=True, sharey=True, **size)
    for axes, time in zip(drawn, times, strict=True):
        stage.draw(axes, float(time), width)
    stage.bar(figure)
    return figure


def film_of(stage: Stage, times: Sequence[float]) -> Animation:
    """Return a film of the bodies at several times [s]."""
    width = FILM_SIDE * min(1.0, 1.0 / stage.ratio)

    def draw(time: float) -> Figure:
        figure = new_figure(width + BAR, width * stage.ratio + 2.0 * WORDS, layout="compressed")
        stage.draw(figure.subplots(), time, width)
        stage.bar(figure)
        return figure

    return Animation(draw, [float(time) for time in times])


def _arrangement(ratio: float, panels: int) -> tuple[int, float]:
    """Arrange panels on a page so that they are as large as possible; return the number of rows and the width of a panel
    [inch]. ratio: height to width of a panel."""
    best = (1, 0.0)
    for down in range(1, panels + 1):
        across = -(-panels // down)
        width = min((WIDTH - BAR) / across, (MOST_HEIGHT / down - WORDS) / ratio)
        if width > best[1]:
            best = (down, width)
    return best


def evenly(times: np.ndarray, most: int) -> np.ndarray:
    """Choose at most `most` of the times [s] at even intervals, including the first and the last; for `most` = 1, the last."""
    return times[-1:] if most == 1 else times[np.unique(np.linspace(0, len(times) - 1, most).round().astype(int))]


def recorded(frames: np.ndarray, times: Iterable[float]) -> np.ndarray:
    """Return the times [s] of the stored frames that are nearest to the given times [s], without duplicates.

    frames: times of all frames [s]. Given times that the run did not reach are omitted; if the run reached none of the
    given times, the time of the last frame is returned.
    """
    reached = [time for time in times if time <= 1.01 * frames[-1]] or [frames[-1]]
    return np.unique([frames[np.argmin(np.abs(frames - time))] for time in reached])
