"""Films of a run as animated GIF: they play everywhere and need nothing but pillow, which comes with matplotlib."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.progress import Progress
from pellucid.results.pictures.case_module import drawn_by_module, noticed
from pellucid.results.pictures.style import house_style
from pellucid.results.storage.drawn import drawing
from pellucid.results.storage.files import explained

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL.Image import Image

    from pellucid.results.storage.run import Run

FILM_DPI = 96
FRAME, HOLD = 120, 1500  # ms that a picture stays, and the last one
COLOURS = 256
NEARLY_WHITE = 244
SAMPLES = 6  # pictures whose pixels make the palette of the film; of more pictures it takes as many pixels, from each some
ALIKE = 8  # levels of a channel that are one colour as the palette is chosen
WEIGHT = 1.0 / 3.0  # power of the number of pixels with which a colour counts
ROUNDS = 3  # in which the palette moves to the means of what it stands for


class Animation(NamedTuple):
    """`draw(time)` gives the figure of an instant [s], all of one size; the film shows those of `times`, in order."""

    draw: "Callable[[float], Figure]"
    times: Iterable[float]


def write_films(run: "Run", progress: Progress, notices: list[str]) -> list[Path]:
    """Make the films of the run's gallery case as `figures/<name>.gif`; return their paths.

    To `notices` comes what cannot be drawn because files of the run are damaged.
    """
    folder = run.folder.figures
    paths = []
    with house_style(), explained(run.out):
        for name, film in drawn_by_module(run, "films").items():
            folder.mkdir(exist_ok=True)
            path = folder / f"{name}.gif"
            with noticed(notices):
                write_film(film, path, progress)
                paths.append(path)
    return paths


def write_film(film: Animation, path: Path, progress: Progress | None = None) -> None:
    """Draw every picture of a film and write it to `path`. Raises ValueError for a film without pictures."""
    from PIL.Image import Dither

    times, pictures = list(film.times), []
    if progress is not None:
        progress.begin("film", len(times))
    for number, time in enumerate(times, 1):
        pictures.append(_drawn(film.draw(time)))
        if progress is not None:
            progress.count(number)
    if not pictures:
        raise ValueError("a film needs at least one instant")
    palette = _palette(pictures)
    # one palette and no dithering: what does not change between pictures is not stored again
    first, *others = [picture.quantize(palette=palette, dither=Dither.NONE) for picture in pictures]
    durations = [FRAME] * len(others) + [HOLD]
    with drawing(path) as temporary:
        first.save(temporary, format="GIF", save_all=True, append_images=others, duration=durations, loop=0)


def _drawn(figure: "Figure") -> "Image":
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL.Image import fromarray

    figure.set_dpi(FILM_DPI)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3].copy())


def _palette(pictures: "list[Image]") -> "Image":
    """The palette of all pictures together. Its colours are means, which would tint white: those become white.

    A colour counts with a power of its pixels: by their number alone the few pixels of a hot spot would go without a colour
    of their own, and orange would become the red of something large.
    """
    from PIL.Image import Quantize, fromarray

    stride = -(-len(pictures) // SAMPLES)
    pixels = np.concatenate([np.asarray(picture).reshape(-1, 3)[k % stride :: stride] for k, picture in enumerate(pictures)])
    red, green, blue = (pixels // ALIKE).astype(np.int64).T
    _, which, count = np.unique((red * 256 + green) * 256 + blue, return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(which, channel) / count for channel in pixels.T], axis=1)
    weighted = np.repeat(means.round().astype(np.uint8), np.rint(count**WEIGHT).astype(int), axis=0)
    palette = fromarray(weighted[None]).quantize(COLOURS, method=Quantize.MEDIANCUT, kmeans=ROUNDS)
    colours = np.reshape(palette.getpalette() or [], (-1, 3))
    colours[colours.min(axis=1) >= NEARLY_WHITE] = 255
    palette.putpalette(colours.ravel().tolist())
    return palette
